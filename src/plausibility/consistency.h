// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "reprojection.h"
#include "view_groups.h"

namespace tsg::plausibility {

/// Mean over a group's pairs of views of how far they disagree under a hypothesis; nothing if a
/// pose is not here or too few points can be compared.
std::optional<Disagreement> computeGroupDisagreement(const Hypothesis& hypothesis,
                                                     const ViewGroup& group);

/// Disagreement of many hypotheses over groups of views. A group is computed anew only when
/// something was added to it.
class DisagreementTable {
 public:
  explicit DisagreementTable(std::vector<Hypothesis> hypotheses);

  /// Adds what is new in `groups` and forgets what is gone. About 15 us for each hypothesis and
  /// pair of views that is new. @returns whether anything was.
  bool update(const std::vector<ViewGroup>& groups);

  const std::vector<Hypothesis>& hypotheses() const { return hypotheses_; }
  std::size_t numGroups() const { return rows_.size(); }
  /// Weighted mean over the groups: the more motion, the more a group counts.
  double meanCost(std::size_t hypothesis) const;
  /// Weighted medians over the groups.
  double medianInViewCost(std::size_t hypothesis) const;
  double medianInViewShare(std::size_t hypothesis) const;

  /// A hypothesis beside the first one, by groups that tell the two apart (costs that differ by
  /// 0.05 or more): turning on the spot, for instance, says nothing of the depth's scale.
  struct Comparison {
    double wins = 0.0;    ///< groups that the hypothesis fits better, one of most motion counts 1
    double losses = 0.0;  ///< ... worse
    // Weighted means over the groups that it fits better.
    double gain = 0.0;           ///< difference of costs
    double first_in_view = 0.0;  ///< in-view cost of the first hypothesis
    double in_view = 0.0;        ///< ... of this one
    double in_view_share = 0.0;  ///< of this one
    double over_second = 0.0;    ///< cost of the table's second hypothesis less that of this one
  };
  Comparison compare(std::size_t hypothesis) const;

 private:
  struct Row {
    Stamp newest_pose;
    double weight = 1.0;              ///< doubles with every level of motion
    std::vector<Disagreement> cells;  ///< one per hypothesis
  };
  std::vector<Disagreement> computeCells(const ViewGroup& group) const;
  double greatestWeight() const;
  double computeMedian(std::size_t hypothesis, double Disagreement::*value) const;

  std::vector<Hypothesis> hypotheses_;
  std::map<std::uint64_t, Row> rows_;  ///< by the groups' ids
};

/// Factors of depth that fit nearly as well as the best one near `factor`, least and greatest.
struct FactorRange {
  double low = 1.0;
  double high = 1.0;
};
FactorRange findFactors(const std::vector<ViewGroup>& groups, const Hypothesis& reading);

/// What the groups say of the way in which the input is read.
struct Verdict {
  enum class Kind {
    kUndecided,     ///< too little motion, or nothing that tells readings apart
    kConsistent,    ///< the frames agree as given
    kOtherReading,  ///< they agree much better if read as `reading`
    kNoneFits,      ///< they do not agree as given, nor in any other way that was tried
    kFrozenImages   ///< they are the same, reading for reading, while the pose moves
  };
  Kind kind = Kind::kUndecided;
  Hypothesis reading;
  FactorRange factors;        ///< of depth, where `reading` has another than 1
  double given_cost = 0.0;    ///< in-view cost as given
  double reading_cost = 0.0;  ///< in-view cost as `reading` has it
  /// False if the images would agree as well had the camera stood still: then `reading` is one way
  /// among several to make the motion that the poses say disappear.
  bool beats_standstill = false;
  std::size_t num_groups = 0;
};

/// Whether neighbouring frames agree when depth is reprojected, and if not, how else the input has
/// to be read. Not thread-safe.
class ConsistencyCheck {
 public:
  ConsistencyCheck();

  /// @param median_depth_m  of all images: factors of depth that make it implausible count less
  Verdict judge(const std::vector<ViewGroup>& groups, double median_depth_m);

 private:
  FactorRange updateFactors(const std::vector<ViewGroup>& groups, const Hypothesis& reading);

  DisagreementTable singles_;
  DisagreementTable doubles_;
  bool has_news_ = false;    ///< since factors_ was computed
  double factors_of_ = 1.0;  ///< depth_factor of the reading that factors_ belongs to
  FactorRange factors_;
};

/// Share of the groups in which the camera's y axis points down (cosine to -z of the world above
/// 0.3) if poses are read as the hypothesis says. 1 for a camera held level in a world with z up.
double computeDownShare(const std::vector<ViewGroup>& groups, const Hypothesis& hypothesis);

}  // namespace tsg::plausibility
