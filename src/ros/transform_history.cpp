// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/transform_history.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "task_scene_graph/ros/frame_names.h"
#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

constexpr std::size_t kMaxFramesInChain = 100;
// Spacings on each side of a gap that say what is usual for its link.
constexpr std::size_t kNeighbours = 50;

/// The frame and all above it.
std::vector<std::string> listAncestors(const tf2::BufferCore& tf, const std::string& frame) {
  std::vector<std::string> frames{frame};
  std::string parent;
  while (frames.size() < kMaxFramesInChain &&
         tf._getParent(frames.back(), ::ros::Time(0), parent)) {
    frames.push_back(parent);
  }
  return frames;
}

/// Child frames of the links between two frames: what is above one of them, but not above both.
std::vector<std::string> listLinks(const tf2::BufferCore& tf, const std::string& target,
                                   const std::string& source) {
  std::vector<std::string> a = listAncestors(tf, target);
  std::vector<std::string> b = listAncestors(tf, source);
  while (!a.empty() && !b.empty() && a.back() == b.back()) {
    a.pop_back();
    b.pop_back();
  }
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

TransformHistory::TransformHistory(double memory_s)
    : memory_ns_(static_cast<std::int64_t>(memory_s * 1e9)) {}

void TransformHistory::add(const geometry_msgs::TransformStamped& transform) {
  const std::int64_t stamp = toStamp(transform.header.stamp).ns;
  const std::lock_guard<std::mutex> lock(mutex_);
  Stamps_ns& stamps = links_[stripLeadingSlash(transform.child_frame_id)];
  const auto place = std::lower_bound(stamps.begin(), stamps.end(), stamp);
  if (place == stamps.end() || *place != stamp) stamps.insert(place, stamp);
  while (stamps.front() < stamps.back() - memory_ns_) stamps.pop_front();
}

void TransformHistory::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  links_.clear();
}

std::optional<TransformHistory::Gap> TransformHistory::findGap(const tf2::BufferCore& tf,
                                                               const std::string& target,
                                                               const std::string& source,
                                                               Stamp stamp) const {
  const auto children = listLinks(tf, target, source);
  const std::lock_guard<std::mutex> lock(mutex_);
  std::optional<Gap> longest;
  for (const auto& child : children) {
    const auto link = links_.find(child);
    if (link == links_.end()) continue;
    const Stamps_ns& stamps = link->second;
    const auto after = std::lower_bound(stamps.begin(), stamps.end(), stamp.ns);
    if (after == stamps.begin() || after == stamps.end() || *after == stamp.ns) continue;
    const Stamp before{*(after - 1)};
    const double length_s = secondsBetween(before, Stamp{*after});
    if (longest && longest->length_s >= length_s) continue;
    const auto number = static_cast<std::size_t>(after - stamps.begin());
    longest = Gap{child, before, Stamp{*after}, length_s, computeUsual(stamps, number)};
  }
  return longest;
}

double TransformHistory::computeUsual(const Stamps_ns& stamps, std::size_t after) {
  const std::size_t begin = after > kNeighbours ? after - kNeighbours : 1;
  const std::size_t end = std::min(stamps.size(), after + kNeighbours);
  std::vector<std::int64_t> spacings;
  for (std::size_t i = begin; i < end; ++i) spacings.push_back(stamps[i] - stamps[i - 1]);
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>((spacings.size() - 1) / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return static_cast<double>(*middle) * 1e-9;
}

}  // namespace tsg::ros_interface
