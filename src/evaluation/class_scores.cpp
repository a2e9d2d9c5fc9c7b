// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/class_scores.h"

#include <stdexcept>

#include "task_scene_graph/core/point_index.h"

namespace tsg::evaluation {
namespace {

void check(const LabelledPoints& points, int num_classes) {
  if (points.points_m.size() != points.classes.size()) {
    throw std::invalid_argument(std::to_string(points.points_m.size()) + " points and " +
                                std::to_string(points.classes.size()) + " classes, expected equal");
  }
  for (const int label : points.classes) {
    if (label >= num_classes || label < kNoClass) {
      throw std::invalid_argument("class " + std::to_string(label) + ", expected -1 to " +
                                  std::to_string(num_classes - 1));
    }
  }
}

double divide(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

}  // namespace

ClassScores computeClassScores(const ConfusionMatrix& confusion) {
  const Eigen::Index count = confusion.rows();
  if (confusion.cols() != count && confusion.cols() != count + 1) {
    throw std::invalid_argument("confusion of " + std::to_string(count) + " rows and " +
                                std::to_string(confusion.cols()) +
                                " columns, expected as many columns or one more");
  }
  ClassScores scores;
  double num_points = 0.0;
  for (Eigen::Index c = 0; c < count; ++c) {
    const double right = confusion(c, c);
    const double num_true = confusion.row(c).sum();
    const double recall = divide(right, num_true);
    const double iou = divide(right, num_true + confusion.col(c).sum() - right);
    scores.recalls.push_back(recall);
    scores.ious.push_back(iou);
    if (num_true <= 0.0) continue;
    ++scores.num_classes;
    num_points += num_true;
    scores.mean_accuracy += recall;
    scores.mean_iou += iou;
    scores.weighted_iou += num_true * iou;
  }
  const auto num_classes = static_cast<double>(scores.num_classes);
  scores.mean_accuracy = divide(scores.mean_accuracy, num_classes);
  scores.mean_iou = divide(scores.mean_iou, num_classes);
  scores.weighted_iou = divide(scores.weighted_iou, num_points);
  return scores;
}

ConfusionMatrix computeConfusion(const LabelledPoints& truth, const LabelledPoints& predicted,
                                 int num_classes, double max_distance_m) {
  check(truth, num_classes);
  check(predicted, num_classes);
  ConfusionMatrix confusion = ConfusionMatrix::Zero(num_classes, num_classes + 1);
  const PointIndex index(predicted.points_m);
  for (std::size_t i = 0; i < truth.points_m.size(); ++i) {
    if (truth.classes[i] == kNoClass) continue;
    int found = kNoClass;
    if (!index.isEmpty()) {
      const std::size_t nearest = index.findNearest(truth.points_m[i]);
      const double distance_m = (predicted.points_m[nearest] - truth.points_m[i]).norm();
      if (distance_m <= max_distance_m) found = predicted.classes[nearest];
    }
    confusion(truth.classes[i], found == kNoClass ? num_classes : found) += 1.0;
  }
  return confusion;
}

}  // namespace tsg::evaluation
