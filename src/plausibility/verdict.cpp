// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "consistency.h"

namespace tsg::plausibility {
namespace {

using Kind = Hypothesis::Kind;

// In-view cost: 0.00 to 0.05 on clean input (0.19 in the worst group of a hand-held recording).
constexpr double kMinGivenCost = 0.08;
constexpr double kMinInViewShare = 0.3;
constexpr double kMinGain = 0.08;  // of the cost, points out of view included
constexpr double kSeveralGroups = 1.5;
constexpr double kMinGainAlone = 0.2;    // where there is but one group
constexpr double kMaxCostRatio = 0.5;    // of the in-view costs
constexpr double kMinWinShare = 0.75;    // of the groups that tell two readings apart
constexpr double kMaxReadingCost = 0.2;  // in-view, of a reading that is named
constexpr double kBadCost = 0.3;         // in-view: the given reading does not fit
constexpr std::size_t kMinGroupsForBad = 4;
constexpr double kDownCosine = 0.3;
constexpr double kMinFrozenShare = 0.98;
constexpr double kMinFrozenTurn_rad = 0.07;
constexpr std::size_t kMinFrozenGroups = 3;

bool isNamedRotation(const Eigen::Matrix3d& R) {
  return R.isIdentity() || R.isApprox(openglAxes()) || R.isApprox(bodyAxes());
}

bool isPlausibleDepth(double median_m) { return median_m >= 0.3 && median_m <= 8.0; }

/// How much better a reading has to fit than one that is met more often.
double computePenalty(const Hypothesis& hypothesis, double median_depth_m) {
  switch (hypothesis.kind) {
    case Kind::kAxes:
    case Kind::kInverseAxes:
      if (!isNamedRotation(hypothesis.R_given_true)) return 0.05;
      break;
    case Kind::kMirrored:
    case Kind::kTilted:
    case Kind::kDelay:
      return 0.03;
    default:
      break;
  }
  if (hypothesis.depth_factor == 1.0) return 0.0;
  if (isPlausibleDepth(median_depth_m * hypothesis.depth_factor)) return 0.0;
  const bool may_be_unit_of_poses = std::abs(std::log10(hypothesis.depth_factor)) > 1.99;
  return may_be_unit_of_poses && isPlausibleDepth(median_depth_m) ? 0.02 : 0.1;
}

std::size_t findBest(const DisagreementTable& table, const std::vector<ViewGroup>& groups,
                     double median_depth_m) {
  std::size_t best = 0;
  double best_rank = std::numeric_limits<double>::infinity();
  for (std::size_t i = 2; i < table.hypotheses().size(); ++i) {
    const Hypothesis& hypothesis = table.hypotheses()[i];
    const double tilt = computeDownShare(groups, hypothesis) < 0.5 ? 0.02 : 0.0;
    const double rank = table.meanCost(i) + computePenalty(hypothesis, median_depth_m) + tilt;
    if (rank >= best_rank) continue;
    best = i;
    best_rank = rank;
  }
  return best;
}

/// Whether all that speaks for a reading is one group of views.
bool isAlone(const DisagreementTable::Comparison& reading) { return reading.wins < kSeveralGroups; }

/// Whether a reading is so much better than the given one that it is worth a word.
bool isMuchBetter(const DisagreementTable::Comparison& reading) {
  return reading.wins >= kMinWinShare * (reading.wins + reading.losses) &&
         reading.gain >= (isAlone(reading) ? kMinGainAlone : kMinGain) &&
         reading.first_in_view >= kMinGivenCost && reading.in_view <= kMaxReadingCost &&
         reading.in_view <= kMaxCostRatio * reading.first_in_view &&
         reading.in_view_share >= kMinInViewShare;
}

/// Groups that have to speak for a reading: more for what no sensor or file is known for.
double winsNeeded(const Hypothesis& reading, double median_depth_m) {
  if (reading.depth_factor == 1.0) return 0.0;
  const double decades = std::abs(std::log10(reading.depth_factor));
  const bool is_known =
      decades > 0.5 && (isPlausibleDepth(median_depth_m * reading.depth_factor) || decades > 1.99);
  if (!is_known) return 3.0;
  return reading.kind == Kind::kDepthScale ? 0.0 : kSeveralGroups;
}

/// Puts the best reading into the verdict if it is much better.
bool findReading(const DisagreementTable& table, const std::vector<ViewGroup>& groups,
                 double median_depth_m, Verdict& verdict) {
  const std::size_t best = findBest(table, groups, median_depth_m);
  const auto comparison = table.compare(best);
  const Hypothesis& reading = table.hypotheses()[best];
  if (!isMuchBetter(comparison) || comparison.wins < winsNeeded(reading, median_depth_m)) {
    return false;
  }
  verdict.kind = Verdict::Kind::kOtherReading;
  verdict.reading = reading;
  verdict.given_cost = comparison.first_in_view;
  verdict.reading_cost = comparison.in_view;
  verdict.beats_standstill = comparison.over_second >= kMinGain;
  return true;
}

/// Of frames that do not agree, nor in any other reading: things that move disturb the given
/// reading and standing still alike, wrong poses are worse than none.
Verdict::Kind judgeBad(const DisagreementTable& table) {
  const bool is_worse_than_none = table.meanCost(0) >= table.meanCost(1) + kMinGain;
  return is_worse_than_none && table.numGroups() >= kMinGroupsForBad ? Verdict::Kind::kNoneFits
                                                                     : Verdict::Kind::kUndecided;
}

bool areImagesFrozen(const std::vector<ViewGroup>& groups) {
  std::size_t frozen = 0;
  std::size_t all = 0;
  for (const ViewGroup& group : groups) {
    if (group.targets.empty()) continue;
    ++all;
    const SampledView& last = group.targets.back();
    // Moving along a wall leaves exact depth as it is; turning does not.
    const double turned_rad = Eigen::AngleAxisd(last.pose.T_world_camera.linear().transpose() *
                                                group.source_pose.T_world_camera.linear())
                                  .angle();
    const bool is_same = computeUnchangedShare(group.source, last.depth) >= kMinFrozenShare;
    frozen += is_same && turned_rad >= kMinFrozenTurn_rad ? 1 : 0;
  }
  return all >= kMinFrozenGroups && frozen * 5 >= all * 4;
}

}  // namespace

ConsistencyCheck::ConsistencyCheck()
    : singles_(makeSingleHypotheses()), doubles_(makeDoubleHypotheses()) {}

FactorRange ConsistencyCheck::updateFactors(const std::vector<ViewGroup>& groups,
                                            const Hypothesis& reading) {
  if (has_news_ || factors_of_ != reading.depth_factor) factors_ = findFactors(groups, reading);
  has_news_ = false;
  factors_of_ = reading.depth_factor;
  return factors_;
}

Verdict ConsistencyCheck::judge(const std::vector<ViewGroup>& groups, double median_depth_m) {
  has_news_ |= singles_.update(groups);
  Verdict verdict;
  verdict.num_groups = singles_.numGroups();
  if (verdict.num_groups == 0) return verdict;
  verdict.given_cost = singles_.medianInViewCost(0);
  if (verdict.given_cost >= kMinGivenCost && areImagesFrozen(groups)) {
    verdict.kind = Verdict::Kind::kFrozenImages;
    return verdict;
  }
  const bool is_bad = verdict.given_cost >= kBadCost;
  bool has_reading = findReading(singles_, groups, median_depth_m, verdict);
  if (!has_reading && is_bad) {
    doubles_.update(groups);
    has_reading = findReading(doubles_, groups, median_depth_m, verdict);
  }
  if (has_reading) {
    if (verdict.reading.depth_factor != 1.0) {
      verdict.factors = updateFactors(groups, verdict.reading);
    }
  } else if (is_bad) {
    verdict.kind = judgeBad(singles_);
  } else if (singles_.medianInViewCost(1) > verdict.given_cost + kMinGain) {
    verdict.kind = Verdict::Kind::kConsistent;
  }
  return verdict;
}

double computeDownShare(const std::vector<ViewGroup>& groups, const Hypothesis& hypothesis) {
  std::size_t down = 0;
  for (const ViewGroup& group : groups) {
    const Eigen::Matrix3d R = group.source_pose.T_world_camera.linear();
    const Eigen::Matrix3d R_world_given =
        hypothesis.is_inverse ? Eigen::Matrix3d(R.transpose()) : R;
    const Eigen::Vector3d y_world = R_world_given * hypothesis.R_given_true.col(1);
    down += -y_world.z() > kDownCosine ? 1 : 0;
  }
  return groups.empty() ? 0.0 : static_cast<double>(down) / static_cast<double>(groups.size());
}

}  // namespace tsg::plausibility
