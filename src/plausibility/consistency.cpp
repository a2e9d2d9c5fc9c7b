// SPDX-License-Identifier: BSD-3-Clause
#include "consistency.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tsg::plausibility {
namespace {

using Kind = Hypothesis::Kind;
constexpr std::size_t kMinPoints = 50;
constexpr double kMinDifference = 0.05;

std::optional<Pose> findRelativePose(const Hypothesis& hypothesis, const ViewGroup& group,
                                     const StampedPose& target) {
  if (hypothesis.kind != Kind::kDelay) {
    return computeRelativePose(hypothesis, target.T_world_camera, group.source_pose.T_world_camera);
  }
  const auto later = [&](Stamp stamp) {
    return Stamp{stamp.ns + Stamp::fromSeconds(hypothesis.delay_s).ns};
  };
  const auto T_world_target = group.findPose(later(target.stamp));
  const auto T_world_source = group.findPose(later(group.source_pose.stamp));
  if (!T_world_target || !T_world_source) return std::nullopt;
  return computeRelativePose(hypothesis, *T_world_target, *T_world_source);
}

}  // namespace

std::optional<Disagreement> computeGroupDisagreement(const Hypothesis& hypothesis,
                                                     const ViewGroup& group) {
  Disagreement mean{0.0, 0.0, 0.0, 0};
  const auto share = 1.0 / static_cast<double>(group.targets.size());
  for (const SampledView& target : group.targets) {
    const auto T_target_source = findRelativePose(hypothesis, group, target.pose);
    if (!T_target_source) return std::nullopt;
    const Disagreement one =
        computeDisagreement(hypothesis, group.source, target.depth, *T_target_source);
    if (one.num_points < kMinPoints) return std::nullopt;
    mean.cost += share * one.cost;
    mean.in_view_cost += share * one.in_view_cost;
    mean.in_view_share += share * one.in_view_share;
    mean.num_points += one.num_points;
  }
  return mean;
}

DisagreementTable::DisagreementTable(std::vector<Hypothesis> hypotheses)
    : hypotheses_(std::move(hypotheses)) {}

bool DisagreementTable::update(const std::vector<ViewGroup>& groups) {
  std::map<std::uint64_t, Row> rows;
  std::size_t num_known = 0;
  for (const ViewGroup& group : groups) {
    if (group.targets.empty()) continue;
    const auto known = rows_.find(group.id);
    const Stamp newest = group.poses.empty() ? Stamp{} : group.poses.back().stamp;
    const bool is_current = known != rows_.end() && known->second.newest_pose == newest;
    Row row = is_current ? std::move(known->second)
                         : Row{newest, std::ldexp(1.0, group.level), computeCells(group)};
    num_known += is_current ? 1 : 0;
    if (!row.cells.empty()) rows.emplace(group.id, std::move(row));
  }
  const bool has_news = num_known < rows.size() || num_known < rows_.size();
  rows_ = std::move(rows);
  return has_news;
}

std::vector<Disagreement> DisagreementTable::computeCells(const ViewGroup& group) const {
  std::vector<Disagreement> cells;
  cells.reserve(hypotheses_.size());
  for (const Hypothesis& hypothesis : hypotheses_) {
    const auto cell = computeGroupDisagreement(hypothesis, group);
    if (!cell && cells.empty()) return {};  // nothing can be said of the given reading
    cells.push_back(cell.value_or(Disagreement{}));
  }
  return cells;
}

double DisagreementTable::greatestWeight() const {
  double greatest = 0.0;
  for (const auto& [id, row] : rows_) greatest = std::max(greatest, row.weight);
  return greatest;
}

double DisagreementTable::meanCost(std::size_t hypothesis) const {
  double sum = 0.0;
  double weights = 0.0;
  for (const auto& [id, row] : rows_) {
    sum += row.weight * row.cells[hypothesis].cost;
    weights += row.weight;
  }
  return weights > 0.0 ? sum / weights : 1.0;
}

double DisagreementTable::medianInViewCost(std::size_t hypothesis) const {
  return computeMedian(hypothesis, &Disagreement::in_view_cost);
}

double DisagreementTable::medianInViewShare(std::size_t hypothesis) const {
  return computeMedian(hypothesis, &Disagreement::in_view_share);
}

double DisagreementTable::computeMedian(std::size_t hypothesis, double Disagreement::*value) const {
  std::vector<std::pair<double, double>> weighted;
  double total = 0.0;
  for (const auto& [id, row] : rows_) {
    weighted.emplace_back(row.cells[hypothesis].*value, row.weight);
    total += row.weight;
  }
  std::sort(weighted.begin(), weighted.end());
  double below = 0.0;
  for (const auto& [x, weight] : weighted) {
    below += weight;
    if (2.0 * below >= total) return x;
  }
  return 1.0;
}

DisagreementTable::Comparison DisagreementTable::compare(std::size_t hypothesis) const {
  Comparison result;
  const double greatest = greatestWeight();
  for (const auto& [id, row] : rows_) {
    const Disagreement& first = row.cells.front();
    const Disagreement& other = row.cells[hypothesis];
    const double gain = first.cost - other.cost;
    const double weight = row.weight / greatest;
    if (gain <= -kMinDifference) result.losses += weight;
    if (gain < kMinDifference) continue;
    result.wins += weight;
    result.gain += weight * gain;
    result.first_in_view += weight * first.in_view_cost;
    result.in_view += weight * other.in_view_cost;
    result.in_view_share += weight * other.in_view_share;
    result.over_second += weight * (row.cells[1].cost - other.cost);
  }
  if (result.wins == 0.0) return result;
  for (double* mean : {&result.gain, &result.first_in_view, &result.in_view, &result.in_view_share,
                       &result.over_second}) {
    *mean /= result.wins;
  }
  return result;
}

}  // namespace tsg::plausibility
