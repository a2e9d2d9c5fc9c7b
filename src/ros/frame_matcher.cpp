// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/frame_matcher.h"

#include <algorithm>
#include <utility>

namespace tsg::ros_interface {
namespace {

template <typename Queue>
auto findStamp(const Queue& queue, Stamp stamp) {
  return std::find_if(queue.begin(), queue.end(),
                      [stamp](const auto& item) { return item->stamp == stamp; });
}

}  // namespace

std::optional<FrameMatcher::Match> FrameMatcher::addFrame(RgbdFramePtr frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = findStamp(segmentations_, frame->stamp);
  if (found != segmentations_.end()) return finish(std::move(frame), *found);
  if (frames_.size() >= max_frames_) frames_.pop_front();
  frames_.push_back(std::move(frame));
  return std::nullopt;
}

std::optional<FrameMatcher::Match> FrameMatcher::addSegmentation(SegmentationPtr segmentation) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = findStamp(frames_, segmentation->stamp);
  if (found != frames_.end()) return finish(*found, std::move(segmentation));
  if (segmentations_.size() >= max_frames_) {
    segmentations_.pop_front();
    ++num_unmatched_;
  }
  segmentations_.push_back(std::move(segmentation));
  return std::nullopt;
}

FrameMatcher::Match FrameMatcher::finish(RgbdFramePtr frame, SegmentationPtr segmentation) {
  const Stamp stamp = frame->stamp;
  while (!frames_.empty() && frames_.front()->stamp <= stamp) frames_.pop_front();
  while (!segmentations_.empty() && segmentations_.front()->stamp <= stamp) {
    if (segmentations_.front()->stamp != stamp) ++num_unmatched_;
    segmentations_.pop_front();
  }
  return {std::move(frame), std::move(segmentation)};
}

void FrameMatcher::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  frames_.clear();
  num_unmatched_ += segmentations_.size();
  segmentations_.clear();
}

std::uint64_t FrameMatcher::numUnmatchedSegmentations() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return num_unmatched_;
}

std::size_t FrameMatcher::numFrames() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return frames_.size();
}

}  // namespace tsg::ros_interface
