// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/pair_matcher.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tsg::ros_interface {
namespace {

double computeDistance_s(Stamp a, Stamp b) { return std::abs(secondsBetween(a, b)); }

void insertByStamp(std::deque<SourceImage>& images, SourceImage image) {
  const Stamp stamp = image.stamp();
  auto place = images.end();
  while (place != images.begin() && stamp < std::prev(place)->stamp()) --place;
  images.insert(place, std::move(image));
}

}  // namespace

PairMatcher::PairMatcher(double tolerance_s, std::size_t capacity)
    : tolerance_s_(tolerance_s), capacity_(std::max<std::size_t>(capacity, 1)) {}

PairMatcher::Outcome PairMatcher::addColor(SourceImage image) {
  Outcome outcome;
  insertByStamp(colors_, std::move(image));
  decide(false, outcome);
  while (colors_.size() > capacity_) decideFront(true, outcome);
  return outcome;
}

PairMatcher::Outcome PairMatcher::addDepth(SourceImage image) {
  Outcome outcome;
  insertByStamp(depths_, std::move(image));
  decide(false, outcome);
  if (depths_.size() > capacity_) forgetDepths(depths_.size() - capacity_, outcome);
  return outcome;
}

PairMatcher::Outcome PairMatcher::flush() {
  Outcome outcome;
  decide(true, outcome);
  forgetDepths(depths_.size(), outcome);
  return outcome;
}

std::size_t PairMatcher::clear() {
  const std::size_t count = colors_.size();
  colors_.clear();
  depths_.clear();
  last_gone_depth_.reset();
  return count;
}

void PairMatcher::decide(bool is_end, Outcome& outcome) {
  while (!colors_.empty() && decideFront(is_end, outcome)) {
  }
}

bool PairMatcher::decideFront(bool is_end, Outcome& outcome) {
  const Stamp stamp = colors_.front().stamp();
  const bool knows_nearest = !depths_.empty() && stamp <= depths_.back().stamp();
  if (!knows_nearest && !is_end) return false;
  const auto nearest = findNearestDepth(stamp);
  const bool is_near =
      nearest && computeDistance_s(stamp, depths_[*nearest].stamp()) <= tolerance_s_;
  if (is_near) {
    // A later colour image may be nearer to a depth image that lies ahead.
    const bool is_ahead = stamp < depths_[*nearest].stamp();
    if (is_ahead && colors_.size() == 1 && !is_end) return false;
    if (!is_ahead || !belongsToNextColor(*nearest)) {
      pairFront(*nearest, outcome);
      return true;
    }
    const bool has_earlier =
        *nearest > 0 && computeDistance_s(stamp, depths_[*nearest - 1].stamp()) <= tolerance_s_;
    if (has_earlier) {
      pairFront(*nearest - 1, outcome);
      return true;
    }
  }
  outcome.unmatched_colors.push_back({colors_.front(), distanceToNearest(stamp)});
  colors_.pop_front();
  return true;
}

std::optional<std::size_t> PairMatcher::findNearestDepth(Stamp stamp) const {
  std::optional<std::size_t> nearest;
  double least_s = 0.0;
  for (std::size_t i = 0; i < depths_.size(); ++i) {
    const double distance_s = computeDistance_s(stamp, depths_[i].stamp());
    if (nearest && distance_s >= least_s) break;
    nearest = i;
    least_s = distance_s;
  }
  return nearest;
}

bool PairMatcher::belongsToNextColor(std::size_t depth) const {
  if (colors_.size() < 2) return false;
  const Stamp stamp = depths_[depth].stamp();
  return computeDistance_s(colors_[1].stamp(), stamp) <
         computeDistance_s(colors_[0].stamp(), stamp);
}

void PairMatcher::pairFront(std::size_t depth, Outcome& outcome) {
  outcome.pairs.push_back({colors_.front(), depths_[depth]});
  colors_.pop_front();
  last_gone_depth_ = depths_[depth].stamp();
  outcome.unmatched_depths += depth;  // those before it: no colour image can want them any more
  depths_.erase(depths_.begin(), depths_.begin() + static_cast<std::ptrdiff_t>(depth) + 1);
}

void PairMatcher::forgetDepths(std::size_t count, Outcome& outcome) {
  if (count == 0) return;
  last_gone_depth_ = depths_[count - 1].stamp();
  outcome.unmatched_depths += count;
  depths_.erase(depths_.begin(), depths_.begin() + static_cast<std::ptrdiff_t>(count));
}

std::optional<double> PairMatcher::distanceToNearest(Stamp stamp) const {
  std::optional<double> distance_s;
  if (last_gone_depth_) distance_s = computeDistance_s(stamp, *last_gone_depth_);
  if (const auto nearest = findNearestDepth(stamp)) {
    const double other_s = computeDistance_s(stamp, depths_[*nearest].stamp());
    distance_s = distance_s ? std::min(*distance_s, other_s) : other_s;
  }
  return distance_s;
}

}  // namespace tsg::ros_interface
