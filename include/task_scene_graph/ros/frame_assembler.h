// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "task_scene_graph/ros/frame_maker.h"
#include "task_scene_graph/ros/pair_matcher.h"
#include "task_scene_graph/ros/stamp_order.h"

namespace tsg::ros_interface {

/// A frame that lacks only its pose.
struct AssembledFrame {
  std::shared_ptr<RgbdFrame> frame;
  std::string camera_frame;  ///< whose pose is wanted
};

/// Messages of colour, depth and camera_info -> frames without poses. The same for live topics and
/// bags: what is dropped is counted and named by the same words. Not thread-safe.
///
/// camera_info is held: images that come before the first one wait for it. Dropped are: stamps that
/// are 0, out of range, repeated or older than the newest; images without a partner; what
/// FrameMaker refuses. When colour's stamps jump back by more than a second (a bag in a loop),
/// everything starts anew.
class FrameAssembler {
 public:
  struct Callbacks {
    std::function<void(AssembledFrame)> on_frame;
    /// `reason` is the counter's name; `text` says it all, with the remedy, and may be empty.
    std::function<void(const std::string& reason, const std::string& text, std::uint64_t count)>
        on_drop;
    std::function<void(const std::string& key, const std::string& text)> on_warning;
    std::function<void()> on_jump_back;
    /// A frame's image reads the message's own bytes, or a copy.
    std::function<void(bool is_shared, const void* pixels)> on_image;
  };
  struct Counters {
    std::uint64_t colors = 0;            ///< colour images that came
    std::uint64_t depths = 0;            ///< depth images that came
    std::uint64_t matched = 0;           ///< pairs
    std::uint64_t unmatched_colors = 0;  ///< colour images without a depth image
    std::uint64_t unmatched_depths = 0;  ///< depth images without a colour image
    /// Least distance of an unmatched colour image to depth.
    std::optional<double> nearest_unmatched_s;
  };
  /// Frame ids of the newest pair and of the camera_info in force.
  struct FrameIds {
    std::string color;
    std::string depth;
    std::string camera_info;
  };

  /// @throws config::ConfigError, InputError
  FrameAssembler(const InputConfig& config, const InputTopics& topics, Callbacks callbacks);

  void addColor(SourceImage image);
  void addDepth(SourceImage image);
  void addCameraInfo(const sensor_msgs::CameraInfoConstPtr& info);
  /// Decides on all images that wait for a partner, as if none would come.
  void decide();
  /// The end: as decide(), and frames that wait for camera_info are dropped.
  void flush();

  const Counters& counters() const { return counters_; }
  const FrameIds& frameIds() const { return frame_ids_; }
  std::size_t numWaiting() const { return matcher_.numWaiting() + waiting_.size(); }

 private:
  bool isUsable(const SourceImage& image, const std::string& topic);
  void jumpBack();
  void handle(const PairMatcher::Outcome& outcome);
  void handlePair(const PairMatcher::Pair& pair);
  void makeFrame(const PairMatcher::Pair& pair);
  void dropUnmatched(const PairMatcher::Unmatched& unmatched);
  void dropWaiting();

  const InputConfig config_;
  const Callbacks callbacks_;
  FrameMaker maker_;
  PairMatcher matcher_;
  StampOrder color_order_;
  StampOrder depth_order_;
  std::deque<PairMatcher::Pair> waiting_;  ///< for the first camera_info
  Counters counters_;
  FrameIds frame_ids_;
};

}  // namespace tsg::ros_interface
