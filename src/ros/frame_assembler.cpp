// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/frame_assembler.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

std::string formatSeconds(double seconds) {
  std::ostringstream text;
  text.precision(3);
  text << std::fixed << seconds;
  return text.str();
}

}  // namespace

FrameAssembler::FrameAssembler(const InputConfig& config, const InputTopics& topics,
                               Callbacks callbacks)
    : config_(config),
      callbacks_(std::move(callbacks)),
      maker_(config, topics),
      matcher_(config.sync_tolerance_s, static_cast<std::size_t>(config.queue_size)) {
  checkInput(config);
}

void FrameAssembler::addColor(SourceImage image) {
  ++counters_.colors;
  if (!isUsable(image, maker_.topics().color)) return;
  switch (color_order_.update(image.stamp())) {
    case StampOrder::Kind::kDuplicate:
      callbacks_.on_drop(
          "repeated stamp",
          "dropped a frame: its stamp on " + maker_.topics().color + " is that of the one before",
          1);
      return;
    case StampOrder::Kind::kLate:
      callbacks_.on_drop(
          "late",
          "dropped a frame: on " + maker_.topics().color + " it is older than the one before", 1);
      return;
    case StampOrder::Kind::kJumpBack:
      jumpBack();
      break;
    case StampOrder::Kind::kNext:
      break;
  }
  handle(matcher_.addColor(std::move(image)));
}

void FrameAssembler::addDepth(SourceImage image) {
  ++counters_.depths;
  if (!isUsable(image, maker_.topics().depth)) return;
  const auto kind = depth_order_.update(image.stamp());
  if (kind == StampOrder::Kind::kDuplicate || kind == StampOrder::Kind::kLate) {
    ++counters_.unmatched_depths;
    return;
  }
  handle(matcher_.addDepth(std::move(image)));
}

bool FrameAssembler::isUsable(const SourceImage& image, const std::string& topic) {
  try {
    checkStamp(image.header().stamp, topic);
    return true;
  } catch (const InputError& e) {
    callbacks_.on_drop(e.reason(), std::string("dropped a frame: ") + e.what(), 1);
    return false;
  }
}

void FrameAssembler::addCameraInfo(const sensor_msgs::CameraInfoConstPtr& info) {
  try {
    if (const auto warning = maker_.setCameraInfo(info)) {
      callbacks_.on_warning("distortion", *warning);
    }
    frame_ids_.camera_info = info->header.frame_id;
  } catch (const InputError& e) {
    callbacks_.on_drop(e.reason(),
                       std::string("ignored a message: ") + e.what() +
                           (maker_.hasCamera() ? "; the one before it stays in force" : ""),
                       1);
  }
  if (!maker_.hasCamera()) return;
  const auto waiting = std::exchange(waiting_, {});
  for (const auto& pair : waiting) makeFrame(pair);
}

void FrameAssembler::decide() { handle(matcher_.flush()); }

void FrameAssembler::flush() {
  decide();
  dropWaiting();
}

void FrameAssembler::dropWaiting() {
  if (waiting_.empty()) return;
  callbacks_.on_drop("no camera_info",
                     "dropped " + std::to_string(waiting_.size()) + " frames: no camera_info on " +
                         maker_.topics().camera_info +
                         "; remap it, or set input/intrinsics (--intrinsics)",
                     waiting_.size());
  waiting_.clear();
}

void FrameAssembler::jumpBack() {
  callbacks_.on_warning("time jumped back", "stamps jumped back by more than a second on " +
                                                maker_.topics().color +
                                                " (a bag in a loop?): frames start "
                                                "anew");
  callbacks_.on_drop("time jumped back", "", matcher_.clear() + waiting_.size());
  waiting_.clear();
  depth_order_ = StampOrder();
  callbacks_.on_jump_back();
}

void FrameAssembler::handle(const PairMatcher::Outcome& outcome) {
  counters_.unmatched_depths += outcome.unmatched_depths;
  for (const auto& unmatched : outcome.unmatched_colors) dropUnmatched(unmatched);
  for (const auto& pair : outcome.pairs) handlePair(pair);
}

void FrameAssembler::handlePair(const PairMatcher::Pair& pair) {
  ++counters_.matched;
  frame_ids_.color = pair.color.header().frame_id;
  frame_ids_.depth = pair.depth.header().frame_id;
  if (maker_.hasCamera()) {
    makeFrame(pair);
    return;
  }
  if (waiting_.size() >= static_cast<std::size_t>(config_.queue_size)) {
    callbacks_.on_drop("no camera_info",
                       "dropped a frame: still no camera_info on " + maker_.topics().camera_info +
                           "; remap it, or set input/intrinsics (--intrinsics)",
                       1);
    waiting_.pop_front();
  }
  waiting_.push_back(pair);
}

void FrameAssembler::makeFrame(const PairMatcher::Pair& pair) {
  try {
    const auto made = maker_.make(pair.color, pair.depth);
    callbacks_.on_image(made.is_color_shared, made.frame->color.image.data);
    callbacks_.on_image(made.is_depth_shared, made.frame->depth.image.data);
    const std::string& own_frame = pair.color.header().frame_id;
    callbacks_.on_frame(
        {made.frame, config_.camera_frame.empty() ? own_frame : config_.camera_frame});
  } catch (const InputError& e) {
    callbacks_.on_drop(e.reason(), std::string("dropped a frame: ") + e.what(), 1);
  } catch (const std::exception& e) {
    callbacks_.on_drop("unusable images", std::string("dropped a frame: ") + e.what(), 1);
  }
}

void FrameAssembler::dropUnmatched(const PairMatcher::Unmatched& unmatched) {
  auto& least_s = counters_.nearest_unmatched_s;
  if (unmatched.nearest_s) {
    least_s = least_s ? std::min(*least_s, *unmatched.nearest_s) : *unmatched.nearest_s;
  }
  ++counters_.unmatched_colors;
  const std::string at =
      " of the colour image at " + formatSeconds(unmatched.color.stamp().seconds()) + " s";
  const std::string nearest =
      unmatched.nearest_s
          ? "; the nearest was " + formatSeconds(*unmatched.nearest_s) +
                " s away: raise input/sync_tolerance_s (--sync-tolerance) if they belong together"
          : "; none has come at all";
  callbacks_.on_drop("no depth image",
                     "dropped a frame: no depth image on " + maker_.topics().depth + " within " +
                         formatSeconds(config_.sync_tolerance_s) + " s" + at + nearest,
                     1);
}

}  // namespace tsg::ros_interface
