// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "task_scene_graph/core/frame.h"

namespace tsg::plausibility {

/// Distribution of depth readings over any number of images: counts in bins of 1/16 octave, so
/// quantiles are right to 4 %. Not thread-safe.
class DepthStatistics {
 public:
  /// Samples every image at about 40 x 30 pixels.
  void add(const DepthImage& depth);

  std::uint64_t numImages() const { return num_images_; }
  std::uint64_t numReadings() const { return num_readings_; }
  double validShare() const;
  /// Share of the valid readings in [min_m, max_m].
  double shareWithin(double min_m, double max_m) const;
  /// Of the valid readings, metres; 0 if there is none.
  double quantile(double share) const;
  double median_m() const { return quantile(0.5); }
  /// The one value that all valid readings of all images have, metres; nothing if they differ.
  std::optional<float> constantValue_m() const;

 private:
  static constexpr int kBinsPerOctave = 16;
  static constexpr int kMinOctave = -17;  // 7.6e-6 m
  static constexpr int kOctaves = 40;
  static int toBin(float z_m);
  static double toDepth(int bin);

  std::array<std::uint64_t, kBinsPerOctave * kOctaves> counts_{};
  std::uint64_t num_images_ = 0;
  std::uint64_t num_readings_ = 0;
  std::uint64_t num_valid_ = 0;
  float least_m_ = 0.0F;
  float greatest_m_ = 0.0F;
};

}  // namespace tsg::plausibility
