// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

/// Closed-set semantic segmentation of points, as ConceptGraphs' evaluation on Replica counts it,
/// [Clio24, Sec. V-B].
namespace tsg::evaluation {

constexpr int kNoClass = -1;

/// Points with a class each; kNoClass: of none, or of one that does not count.
struct LabelledPoints {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<int> classes;
};

/// Entry (t, p): points of the true class t that have the class p. There may be one more column:
/// points that have no class.
using ConfusionMatrix = Eigen::MatrixXd;

/// Shares in [0, 1].
struct ClassScores {
  double mean_accuracy = 0.0;   ///< mAcc: recall, averaged over the classes that have true points
  double mean_iou = 0.0;        ///< over the same classes
  double weighted_iou = 0.0;    ///< F-mIoU: IoU weighted by the classes' true points
  std::size_t num_classes = 0;  ///< that have true points
  std::vector<double> recalls;  ///< of each class; 0 without true points
  std::vector<double> ious;     ///< likewise
};

/// Recall C_cc / R_c and IoU C_cc / (R_c + P_c - C_cc) with the sums R of rows and P of columns.
/// O(classes^2). @throws std::invalid_argument if the matrix has not as many columns as rows, or
/// one more.
ClassScores computeClassScores(const ConfusionMatrix& confusion);

/// Each true point has the class of the nearest predicted point, or none if none is within
/// `max_distance_m` (last column). True points of kNoClass do not count. deviation: the released
/// evaluation asks at the points of a third cloud, at any distance; here the truth's own points are
/// asked, and what was not mapped is wrong. O(n log n + m n^(2/3)), see PointIndex.
/// @throws std::invalid_argument if a class is not below `num_classes`, or points and classes
/// differ in number.
ConfusionMatrix computeConfusion(const LabelledPoints& truth, const LabelledPoints& predicted,
                                 int num_classes, double max_distance_m);

/// Vertices of a PLY file (ascii or binary little-endian) with x, y, z and an integer property.
/// @throws std::runtime_error naming the file, what was found and what was expected.
LabelledPoints loadLabelledPoints(const std::string& path, const std::string& property);

}  // namespace tsg::evaluation
