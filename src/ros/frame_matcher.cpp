// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/frame_matcher.h"

#include <algorithm>
#include <utility>

namespace tsg::ros_interface {
std::optional<FrameMatcher::Match> FrameMatcher::addFrame(RgbdFramePtr frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found =
      std::find_if(segmentations_.begin(), segmentations_.end(), [&](const Waiting& waiting) {
        return waiting.epoch == epoch_ && waiting.segmentation->stamp == frame->stamp;
      });
  if (found != segmentations_.end()) return finish(std::move(frame), found->segmentation);
  if (frames_.size() >= max_frames_) frames_.pop_front();
  frames_.push_back(std::move(frame));
  return std::nullopt;
}

std::optional<FrameMatcher::Match> FrameMatcher::addSegmentation(SegmentationPtr segmentation,
                                                                 std::uint32_t epoch) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (epoch < epoch_) {
    ++num_unmatched_;
    return std::nullopt;
  }
  const auto found = std::find_if(frames_.begin(), frames_.end(), [&](const RgbdFramePtr& frame) {
    return epoch == epoch_ && frame->stamp == segmentation->stamp;
  });
  if (found != frames_.end()) return finish(*found, std::move(segmentation));
  if (segmentations_.size() >= max_frames_) {
    segmentations_.pop_front();
    ++num_unmatched_;
  }
  segmentations_.push_back({std::move(segmentation), epoch});
  return std::nullopt;
}

FrameMatcher::Match FrameMatcher::finish(RgbdFramePtr frame, SegmentationPtr segmentation) {
  const Stamp stamp = frame->stamp;
  while (!frames_.empty() && frames_.front()->stamp <= stamp) frames_.pop_front();
  const auto isOver = [&](const Waiting& waiting) {
    return waiting.epoch == epoch_ && waiting.segmentation->stamp <= stamp;
  };
  while (!segmentations_.empty() && isOver(segmentations_.front())) {
    if (segmentations_.front().segmentation->stamp != stamp) ++num_unmatched_;
    segmentations_.pop_front();
  }
  return {std::move(frame), std::move(segmentation)};
}

void FrameMatcher::startEpoch(std::uint32_t epoch) {
  const std::lock_guard<std::mutex> lock(mutex_);
  epoch_ = epoch;
  frames_.clear();
  while (!segmentations_.empty() && segmentations_.front().epoch < epoch) {
    segmentations_.pop_front();
    ++num_unmatched_;
  }
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
