// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/object_scores.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "agreement.h"
#include "median.h"

namespace tsg::evaluation {
namespace {

constexpr double kNearBest = 0.9;  // of the best cosine, [Clio24, Sec. V-A]

RotatedBox asReleased(const RotatedBox& box) {
  return {box.center_m, 2.0 * box.size_m, Eigen::Matrix3d::Identity()};
}

Agreement compare(const RotatedBox& estimate, const RotatedBox& truth, ScoreMode mode) {
  if (mode == ScoreMode::kAsReleased) {
    const bool holds_truth = asReleased(estimate).contains(truth.center_m);
    const bool is_held = asReleased(truth).contains(estimate.center_m);
    return {holds_truth && is_held, holds_truth};
  }
  return compareBoxes(estimate, truth);
}

struct Matches {
  std::size_t strict = 0;
  std::size_t relaxed = 0;
  double iou_sum = 0.0;
};

struct Pair {
  double iou = 0.0;
  std::size_t truth = 0;
  std::size_t estimate = 0;  ///< of the list
};

/// By falling IoU; among equals by box, then by estimate.
std::vector<Pair> listOverlaps(const std::vector<const RotatedBox*>& estimates,
                               const std::vector<RotatedBox>& truth) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t j = 0; j < estimates.size(); ++j) {
      const double iou = computeIou(*estimates[j], truth[i]);
      if (iou > 0.0) pairs.push_back({iou, i, j});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.iou > b.iou; });
  return pairs;
}

Matches match(const std::vector<const RotatedBox*>& estimates, const std::vector<RotatedBox>& truth,
              ScoreMode mode) {
  std::vector<bool> truth_taken(truth.size());
  std::vector<bool> estimate_taken(estimates.size());
  Matches matches;
  for (const Pair& pair : listOverlaps(estimates, truth)) {
    if (truth_taken[pair.truth] || estimate_taken[pair.estimate]) continue;
    truth_taken[pair.truth] = estimate_taken[pair.estimate] = true;
    const Agreement agreement = compare(*estimates[pair.estimate], truth[pair.truth], mode);
    matches.strict += agreement.is_strict ? 1 : 0;
    matches.relaxed += agreement.is_relaxed ? 1 : 0;
    matches.iou_sum += pair.iou;
  }
  return matches;
}

std::vector<const RotatedBox*> findNearest(const std::vector<Estimate>& estimates,
                                           Eigen::Index task, std::size_t count) {
  std::vector<std::size_t> order(estimates.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return estimates[a].cosines[task] > estimates[b].cosines[task];
  });
  order.resize(std::min(count, order.size()));
  std::vector<const RotatedBox*> boxes;
  for (const std::size_t i : order) boxes.push_back(&estimates[i].box);
  return boxes;
}

Eigen::Index findTask(const Estimate& estimate) {
  Eigen::Index best = 0;
  estimate.cosines.maxCoeff(&best);
  return best;
}

std::vector<const RotatedBox*> findKept(const std::vector<Estimate>& estimates, Eigen::Index task,
                                        ScoreMode mode) {
  double best = 0.0;
  for (const Estimate& estimate : estimates) {
    if (findTask(estimate) == task) best = std::max(best, estimate.cosines[task]);
  }
  std::vector<const RotatedBox*> kept;
  for (const Estimate& estimate : estimates) {
    const double cosine = estimate.cosines[task];
    const double least = kNearBest * best;
    const bool is_near = mode == ScoreMode::kPaper ? best > 0.0 && cosine >= least : cosine > least;
    if (is_near && findTask(estimate) == task) kept.push_back(&estimate.box);
  }
  return kept;
}

/// How far the nearest estimate is from each thing, middle to middle.
void appendCenterErrors(const std::vector<const RotatedBox*>& estimates,
                        const std::vector<RotatedBox>& truth, std::vector<double>& errors_m) {
  if (estimates.empty()) return;
  for (const RotatedBox& thing : truth) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const RotatedBox* estimate : estimates) {
      nearest_m = std::min(nearest_m, (estimate->center_m - thing.center_m).norm());
    }
    errors_m.push_back(nearest_m);
  }
}

TaskCounts count(const TaskTruth& truth, const std::vector<Estimate>& estimates, Eigen::Index task,
                 ScoreMode mode) {
  TaskCounts counts;
  counts.task = truth.task;
  counts.num_true = truth.boxes.size();
  const Matches found = match(findNearest(estimates, task, truth.boxes.size()), truth.boxes, mode);
  counts.found_strict = found.strict;
  counts.found_relaxed = found.relaxed;
  counts.iou_sum = found.iou_sum;
  const auto kept = findKept(estimates, task, mode);
  const Matches correct = match(kept, truth.boxes, mode);
  counts.num_kept = kept.size();
  counts.correct_strict = correct.strict;
  counts.correct_relaxed = correct.relaxed;
  return counts;
}

double divide(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

DetectionScores makeScores(double recall, double precision) {
  const double sum = recall + precision;
  return {recall, precision, sum > 0.0 ? 2.0 * recall * precision / sum : 0.0};
}

void check(const std::vector<TaskTruth>& truth, const std::vector<Estimate>& estimates) {
  const bool has_boxes = std::any_of(truth.begin(), truth.end(),
                                     [](const TaskTruth& task) { return !task.boxes.empty(); });
  if (!has_boxes) {
    throw std::invalid_argument("none of the " + std::to_string(truth.size()) +
                                " tasks of the truth has a box; expected at least one thing");
  }
  for (const Estimate& estimate : estimates) {
    if (static_cast<std::size_t>(estimate.cosines.size()) != truth.size()) {
      throw std::invalid_argument("an object has " + std::to_string(estimate.cosines.size()) +
                                  " cosines, expected one for each of the " +
                                  std::to_string(truth.size()) + " tasks");
    }
  }
}

}  // namespace

ObjectScores computeObjectScores(const std::vector<TaskTruth>& truth,
                                 const std::vector<Estimate>& estimates, ScoreMode mode) {
  check(truth, estimates);
  ObjectScores scores;
  scores.num_objects = estimates.size();
  TaskCounts sum;
  std::vector<double> center_errors_m;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    appendCenterErrors(findNearest(estimates, static_cast<Eigen::Index>(i), truth[i].boxes.size()),
                       truth[i].boxes, center_errors_m);
    const TaskCounts row = count(truth[i], estimates, static_cast<Eigen::Index>(i), mode);
    sum.num_true += row.num_true;
    sum.found_strict += row.found_strict;
    sum.found_relaxed += row.found_relaxed;
    sum.iou_sum += row.iou_sum;
    sum.num_kept += row.num_kept;
    sum.correct_strict += row.correct_strict;
    sum.correct_relaxed += row.correct_relaxed;
    scores.tasks.push_back(row);
  }
  scores.num_true = sum.num_true;
  scores.num_kept = sum.num_kept;
  scores.center_error_m = computeMedian(std::move(center_errors_m));
  scores.iou = sum.iou_sum / static_cast<double>(sum.num_true);
  scores.strict =
      makeScores(divide(sum.found_strict, sum.num_true), divide(sum.correct_strict, sum.num_kept));
  scores.relaxed = makeScores(divide(sum.found_relaxed, sum.num_true),
                              divide(sum.correct_relaxed, sum.num_kept));
  return scores;
}

}  // namespace tsg::evaluation
