// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

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

}  // namespace

std::vector<ScoredObject> judgeObjects(const std::vector<TaskTruth>& truth,
                                       const std::vector<Estimate>& estimates) {
  std::vector<ScoredObject> objects;
  for (const Estimate& estimate : estimates) {
    if (truth.empty() || static_cast<std::size_t>(estimate.cosines.size()) != truth.size()) {
      throw std::invalid_argument("an object has " + std::to_string(estimate.cosines.size()) +
                                  " cosines, expected one for each of the " +
                                  std::to_string(truth.size()) + " tasks");
    }
    Eigen::Index task = 0;
    ScoredObject object;
    object.score = estimate.cosines.maxCoeff(&task);
    const auto& boxes = truth[static_cast<std::size_t>(task)].boxes;
    object.is_right = std::any_of(boxes.begin(), boxes.end(), [&](const RotatedBox& box) {
      return box.contains(estimate.box.center_m) && estimate.box.contains(box.center_m);
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
    const double index = std::floor(object.score / bin_width + 1e-9);
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

}  // namespace tsg::evaluation
