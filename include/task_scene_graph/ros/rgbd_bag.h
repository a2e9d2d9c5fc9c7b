// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/bag.h>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "task_scene_graph/core/frame.h"

namespace tsg::ros_interface {

struct BagTopics {
  std::string color = "/camera/color/image_raw";
  std::string camera_info = "/camera/color/camera_info";
  std::string depth = "/camera/aligned_depth_to_color/image_raw";
  std::string segmentation = "/segmentation";
};

struct BagOptions {
  BagTopics topics;
  std::string world_frame = "world";
  bool use_recorded_segmentation = true;  ///< where the bag has some
  double sync_tolerance_s = 0.02;         ///< between colour and depth
};

/// RGB-D frames with poses out of a rosbag, in order of their stamps and without a clock. Depth is
/// the nearest in time to the colour image; the pose is tf's at the colour image's stamp,
/// interpolated.
class RgbdBag {
 public:
  using OnFrame = std::function<void(const RgbdFramePtr&, const SegmentationPtr& recorded)>;

  /// Reads the whole of tf. @throws std::runtime_error naming the file, or the topic without
  /// messages and those that the bag has.
  RgbdBag(const std::string& path, const BagOptions& options);
  ~RgbdBag();

  std::size_t numColorImages() const;
  bool hasRecordedSegmentation() const;

  /// Calls `on_frame` for every usable frame; `recorded` is null where the bag has no segmentation
  /// of it. `on_progress` gets the number of colour images read so far. Frames that cannot be used
  /// are counted in drops().
  void forEachFrame(const OnFrame& on_frame, const std::function<void(std::size_t)>& on_progress);

  struct Drops {
    std::size_t count = 0;
    std::string example;  ///< what was wrong with the first of them
  };
  /// By reason, of the last forEachFrame.
  const std::map<std::string, Drops>& drops() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tsg::ros_interface
