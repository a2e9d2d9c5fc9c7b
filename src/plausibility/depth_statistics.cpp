// SPDX-License-Identifier: BSD-3-Clause
#include "depth_statistics.h"

#include <algorithm>
#include <cmath>

namespace tsg::plausibility {
namespace {

constexpr int kColumns = 40;

}  // namespace

int DepthStatistics::toBin(float z_m) {
  int octave = 0;
  const float fraction = std::frexp(z_m, &octave);  // in [0.5, 1)
  const auto part = static_cast<int>((fraction - 0.5F) * 2.0F * kBinsPerOctave);
  return std::clamp((octave - 1 - kMinOctave) * kBinsPerOctave + part, 0,
                    kBinsPerOctave * kOctaves - 1);
}

double DepthStatistics::toDepth(int bin) {
  const double fraction = 0.5 + 0.5 * (bin % kBinsPerOctave + 0.5) / kBinsPerOctave;
  return std::ldexp(fraction, bin / kBinsPerOctave + kMinOctave + 1);
}

void DepthStatistics::add(const DepthImage& depth) {
  ++num_images_;
  const int step_px = std::max(1, depth.image.cols / kColumns);
  for (int v = step_px / 2; v < depth.image.rows; v += step_px) {
    for (int u = step_px / 2; u < depth.image.cols; u += step_px) {
      ++num_readings_;
      const float z_m = depth.at(u, v);
      if (!(z_m > 0.0F)) continue;
      ++counts_[static_cast<std::size_t>(toBin(z_m))];
      least_m_ = num_valid_ == 0 ? z_m : std::min(least_m_, z_m);
      greatest_m_ = num_valid_ == 0 ? z_m : std::max(greatest_m_, z_m);
      ++num_valid_;
    }
  }
}

double DepthStatistics::validShare() const {
  return num_readings_ == 0 ? 0.0
                            : static_cast<double>(num_valid_) / static_cast<double>(num_readings_);
}

double DepthStatistics::shareWithin(double min_m, double max_m) const {
  if (num_valid_ == 0) return 0.0;
  std::uint64_t within = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const double z_m = toDepth(static_cast<int>(i));
    if (z_m >= min_m && z_m <= max_m) within += counts_[i];
  }
  return static_cast<double>(within) / static_cast<double>(num_valid_);
}

double DepthStatistics::quantile(double share) const {
  const double rank = share * static_cast<double>(num_valid_);
  double below = 0.0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    below += static_cast<double>(counts_[i]);
    if (below > 0.0 && below >= rank) return toDepth(static_cast<int>(i));
  }
  return 0.0;
}

std::optional<float> DepthStatistics::constantValue_m() const {
  if (num_valid_ == 0 || least_m_ != greatest_m_) return std::nullopt;
  return least_m_;
}

}  // namespace tsg::plausibility
