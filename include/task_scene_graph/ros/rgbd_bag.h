// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/ros/frame_assembler.h"
#include "task_scene_graph/ros/input_config.h"

namespace tsg::ros_interface {

/// RGB-D frames with poses out of one or more rosbags (the parts of a split recording, say), in
/// order of their stamps and without a clock. What belongs together, what is dropped and by which
/// words is FrameAssembler's to say, as it is live. Poses are tf's, the pose topic's or the
/// trajectory's at the colour image's stamp, interpolated. Raw topics that the bags lack are looked
/// for in their compressed form.
class RgbdBag {
 public:
  /// `recorded` is null where the bags have no segmentation of the frame; it is of the image as
  /// published (alignToFrame). Returns false to stop reading.
  using OnFrame = std::function<bool(const RgbdFramePtr&, const SegmentationPtr& recorded)>;

  /// Reads the whole of tf and of the pose topic. @throws std::runtime_error naming the file and
  /// what is wrong with it, or the topic without messages and those that the bags have; InputError,
  /// config::ConfigError.
  RgbdBag(const std::vector<std::string>& paths, const InputConfig& config,
          bool use_recorded_segmentation);
  ~RgbdBag();

  std::size_t numColorImages() const;
  bool hasRecordedSegmentation() const;
  /// Topic of the recorded segmentations.
  std::string segmentationTopic() const;

  /// Calls `on_frame` for every usable frame. `on_progress` gets the number of colour images read
  /// so far. Frames that cannot be used are counted in drops().
  void forEachFrame(const OnFrame& on_frame, const std::function<void(std::size_t)>& on_progress);

  struct Drops {
    std::size_t count = 0;
    std::string example;  ///< what was wrong with the first of them
  };
  /// By reason, of the last forEachFrame.
  const std::map<std::string, Drops>& drops() const;
  /// What the user should know besides, one text each.
  std::vector<std::string> warnings() const;
  const FrameAssembler::Counters& counters() const;
  const FrameAssembler::FrameIds& frameIds() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tsg::ros_interface
