// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/plausibility/finding.h"
#include "task_scene_graph/plausibility/input_checks.h"

namespace tsg::plausibility {

/// The part of the depth that maps are made of (tsdf/min_range_m, tsdf/max_range_m).
struct PlausibilityConfig {
  double min_range_m = 0.3;
  double max_range_m = 5.0;
};

/// The plausibility report on RGB-D input: looks at a bounded sample of the frames and says, at any
/// time, what about them is unusual, what that usually means and what to set. Silent on input that
/// is as it should be; silent too where nothing can be told yet (a camera that stands still says
/// nothing of poses). docs/plausibility.md lists the checks and how sure they are.
///
/// Keeps no frame: about 5 MB of sampled depth at most. Not thread-safe.
class InputPlausibility {
 public:
  explicit InputPlausibility(const PlausibilityConfig& config = {});
  ~InputPlausibility();

  /// Frames with their poses, in the order of their stamps; stamps may jump back. Unusable ones are
  /// ignored. 10 to 30 us for most frames, up to 1 ms for those that are sampled.
  void addFrame(const RgbdFrame& frame);

  /// Of the newest messages; cheap enough for every one.
  void noteFrameIds(const FrameIds& ids);

  /// All counts so far; they replace the ones before.
  void noteMatches(const MatchCounts& counts);

  /// The report on everything so far; empty on clean input. Each key (Finding::check) stays the
  /// same from call to call, numbers in the text do not. Up to 60 ms where much is new since the
  /// last call, else below 1 ms.
  std::vector<Finding> findings();

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tsg::plausibility
