// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "task_scene_graph/evaluation/object_scores.h"

namespace tsg::evaluation {

/// An object's cosine with its own task, the nearest, and whether it is one of that task's things.
struct ScoredObject {
  double score = 0.0;
  bool is_right = false;
};

struct CalibrationBin {
  double low = 0.0;  ///< scores from here on, below low + the width
  std::size_t num_objects = 0;
  std::size_t num_right = 0;
  double mean_score = 0.0;
};

/// What a score is worth.
struct Calibration {
  std::vector<CalibrationBin> bins;  ///< ascending, those with objects
  /// Probability that a right object's score is higher than a wrong one's, ties half (the area
  /// under the ROC curve); 0.5 if all are right or all wrong.
  double separation = 0.5;
};

/// What is left of a map without the objects of a lower score.
struct CurvePoint {
  double min_score = 0.0;
  double precision = 0.0;  ///< share of the objects left that are right
  double recall = 0.0;     ///< share of all things for which a right object is left
};

/// An object is right if the box of one of its task's things and its own hold each other's centres;
/// several objects may be right about one thing. O(objects * tasks + objects * boxes).
/// @throws std::invalid_argument if an estimate has not a cosine for each task.
std::vector<ScoredObject> judgeObjects(const std::vector<TaskTruth>& truth,
                                       const std::vector<Estimate>& estimates);

/// Bins start at multiples of the width. O(n log n). @throws std::invalid_argument unless the width
/// is positive.
Calibration computeCalibration(const std::vector<ScoredObject>& objects, double bin_width);

/// Precision and recall at each multiple of the step from the lowest to the highest score, right as
/// judgeObjects() has it. Recall is 0 where nothing is true.
/// O(objects * (tasks + all boxes + points)). @throws std::invalid_argument as judgeObjects(), and
/// unless the step is positive.
std::vector<CurvePoint> computePrecisionRecall(const std::vector<TaskTruth>& truth,
                                               const std::vector<Estimate>& estimates, double step);

}  // namespace tsg::evaluation
