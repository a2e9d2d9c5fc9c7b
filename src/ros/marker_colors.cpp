// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/marker_colors.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tsg::ros_interface {
namespace {

/// @param hue  in [0, 6): red, yellow, green, cyan, blue, magenta
std_msgs::ColorRGBA makeColor(double hue, float saturation, float value) {
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double part = std::max(0.0, std::min({k, 4.0 - k, 1.0}));
    return value * (1.0F - saturation * static_cast<float>(part));
  };
  std_msgs::ColorRGBA color;
  color.r = channel(5.0);
  color.g = channel(3.0);
  color.b = channel(1.0);
  return color;
}

}  // namespace

std_msgs::ColorRGBA computeColor(int index, float alpha) {
  std_msgs::ColorRGBA color;
  color.r = color.g = color.b = 0.45F;
  if (index >= 0) {  // golden ratio: hues spread evenly
    color = makeColor(std::fmod(index * 0.61803398875, 1.0) * 6.0, 0.85F,
                      index % 2 == 0 ? 0.95F : 0.7F);
  }
  color.a = alpha;
  return color;
}

std_msgs::ColorRGBA computeRegionColor(int index, float alpha) {
  const std_msgs::ColorRGBA grey = computeColor(-1, alpha);
  if (index < 0) return grey;
  // 5 and 12 have no common factor: neighbours are 150 degrees of hue apart.
  const double hue = (index * 5 % kNumRegionColors) * 6.0 / kNumRegionColors;
  const float value = index % 2 == 0 ? 0.95F : 0.75F;
  std_msgs::ColorRGBA color = makeColor(hue, 0.5F, value);
  color.a = alpha;
  return color;
}

int chooseRegionColor(const scene_graph::SceneGraph& graph, const scene_graph::Region& region,
                      const std::map<RegionId, int>& colors) {
  std::vector<double> nearness(kNumRegionColors, 0.0);
  for (const auto& other : graph.regions) {
    const auto color = colors.find(other.id);
    if (color == colors.end() || other.id == region.id) continue;
    const double distance2_m2 = (other.position_m - region.position_m).squaredNorm();
    nearness[static_cast<std::size_t>(color->second)] += 1.0 / std::max(distance2_m2, 0.01);
  }
  int best = static_cast<int>((region.id.value - 1) % kNumRegionColors);
  for (int i = 0, color = best; i < kNumRegionColors; ++i, color = (color + 1) % kNumRegionColors) {
    if (nearness[static_cast<std::size_t>(color)] < nearness[static_cast<std::size_t>(best)]) {
      best = color;
    }
  }
  return best;
}

std_msgs::ColorRGBA computeScoreColor(double part, float alpha) {
  const auto x = static_cast<float>(4.0 * std::clamp(part, 0.0, 1.0));
  const auto limit = [](float value) { return std::clamp(value, 0.0F, 1.0F); };
  std_msgs::ColorRGBA color;  // blue, cyan, green, yellow, red
  color.r = limit(x - 2.0F);
  color.g = limit(std::min(x, 4.0F - x));
  color.b = limit(2.0F - x);
  color.a = alpha;
  return color;
}

}  // namespace tsg::ros_interface
