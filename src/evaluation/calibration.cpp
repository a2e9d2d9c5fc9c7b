// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "agreement.h"

namespace tsg::evaluation {
namespace {

/// Pairs of a right and a wrong object that are in the right order, equal ones half, over all.
double computeSeparation(std::vector<ScoredObject> objects) {
  std::sort(objects.begin(), objects.end(),
            [](const ScoredObject& a, const ScoredObject& b) { return a.score < b.score; });
  double ordered = 0.0;
  double wrong_below = 0.0;
  double num_right = 0.0;
  for (std::size_t i = 0; i < objects.size();) {
    double right = 0.0;
    double wrong = 0.0;
    const double score = objects[i].score;
    for (; i < objects.size() && objects[i].score == score; ++i) {
      (objects[i].is_right ? right : wrong) += 1.0;
    }
    ordered += right * (wrong_below + 0.5 * wrong);
    wrong_below += wrong;
    num_right += right;
  }
  const double pairs = num_right * wrong_below;
  return pairs > 0.0 ? ordered / pairs : 0.5;
}

/// Number of the step that a score has reached; what is on it but for rounding has.
double findStep(double score, double step) { return std::floor(score / step + 1e-9); }

Eigen::Index findTask(const std::vector<TaskTruth>& truth, const Estimate& estimate) {
  if (truth.empty() || static_cast<std::size_t>(estimate.cosines.size()) != truth.size()) {
    throw std::invalid_argument("an object has " + std::to_string(estimate.cosines.size()) +
                                " cosines, expected one for each of the " +
                                std::to_string(truth.size()) + " tasks");
  }
  Eigen::Index task = 0;
  estimate.cosines.maxCoeff(&task);
  return task;
}

/// Of each thing for which there is a right object the highest score of these.
std::vector<double> scoreThings(const std::vector<TaskTruth>& truth,
                                const std::vector<Estimate>& estimates) {
  std::vector<double> scores;
  std::vector<std::size_t> tasks;
  for (const Estimate& estimate : estimates) {
    tasks.push_back(static_cast<std::size_t>(findTask(truth, estimate)));
  }
  for (std::size_t task = 0; task < truth.size(); ++task) {
    for (const RotatedBox& thing : truth[task].boxes) {
      std::optional<double> best;
      for (std::size_t i = 0; i < estimates.size(); ++i) {
        if (tasks[i] != task || !compareBoxes(estimates[i].box, thing).is_strict) continue;
        best = std::max(best.value_or(-1.0), estimates[i].cosines.maxCoeff());
      }
      if (best) scores.push_back(*best);
    }
  }
  return scores;
}

}  // namespace

std::vector<ScoredObject> judgeObjects(const std::vector<TaskTruth>& truth,
                                       const std::vector<Estimate>& estimates) {
  std::vector<ScoredObject> objects;
  for (const Estimate& estimate : estimates) {
    const auto& boxes = truth[static_cast<std::size_t>(findTask(truth, estimate))].boxes;
    ScoredObject object;
    object.score = estimate.cosines.maxCoeff();
    object.is_right = std::any_of(boxes.begin(), boxes.end(), [&](const RotatedBox& box) {
      return compareBoxes(estimate.box, box).is_strict;
    });
    objects.push_back(object);
  }
  return objects;
}

Calibration computeCalibration(const std::vector<ScoredObject>& objects, double bin_width) {
  if (!(bin_width > 0.0)) {
    throw std::invalid_argument("bin width " + std::to_string(bin_width) + ", expected above 0");
  }
  std::map<double, CalibrationBin> bins;
  for (const ScoredObject& object : objects) {
    const double index = findStep(object.score, bin_width);
    CalibrationBin& bin = bins[index];
    bin.low = index * bin_width;
    ++bin.num_objects;
    bin.num_right += object.is_right ? 1 : 0;
    bin.mean_score += object.score;
  }
  Calibration calibration;
  for (auto& [index, bin] : bins) {
    bin.mean_score /= static_cast<double>(bin.num_objects);
    calibration.bins.push_back(bin);
  }
  calibration.separation = computeSeparation(objects);
  return calibration;
}

std::vector<CurvePoint> computePrecisionRecall(const std::vector<TaskTruth>& truth,
                                               const std::vector<Estimate>& estimates,
                                               double step) {
  if (!(step > 0.0)) {
    throw std::invalid_argument("step " + std::to_string(step) + ", expected above 0");
  }
  const std::vector<ScoredObject> objects = judgeObjects(truth, estimates);
  const std::vector<double> things = scoreThings(truth, estimates);
  std::size_t num_true = 0;
  for (const TaskTruth& task : truth) num_true += task.boxes.size();
  const auto toShare = [](auto part, std::size_t whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  std::vector<CurvePoint> curve;
  if (objects.empty()) return curve;
  const auto [lowest, highest] = std::minmax_element(
      objects.begin(), objects.end(),
      [](const ScoredObject& a, const ScoredObject& b) { return a.score < b.score; });
  const double last = findStep(highest->score, step);
  for (double index = findStep(lowest->score, step); index <= last; index += 1.0) {
    const auto isLeft = [&](double score) { return findStep(score, step) >= index; };
    std::size_t num_left = 0;
    std::size_t num_right = 0;
    for (const ScoredObject& object : objects) {
      num_left += isLeft(object.score) ? 1 : 0;
      num_right += isLeft(object.score) && object.is_right ? 1 : 0;
    }
    CurvePoint point;
    point.min_score = index * step;
    point.precision = toShare(num_right, num_left);
    point.recall = toShare(std::count_if(things.begin(), things.end(), isLeft), num_true);
    curve.push_back(point);
  }
  return curve;
}

}  // namespace tsg::evaluation
