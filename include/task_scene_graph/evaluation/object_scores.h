// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "task_scene_graph/core/rotated_box.h"

/// How well objects agree with the things that tasks are about, [Clio24, Sec. V-A and Table I].
namespace tsg::evaluation {

/// Of two ways to count, which differ in what a box contains and in which objects are kept.
enum class ScoreMode {
  /// As [Clio24] words it: boxes as they are turned; relaxed: either centre in the other box; kept:
  /// at least 90 % of the best cosine.
  kPaper,
  /// As the authors' released code counts: boxes taken as not turned and twice as long on every
  /// side; relaxed: the truth's centre in the object's box; kept: more than 90 %.
  kAsReleased
};

/// A task and the things that it is about.
struct TaskTruth {
  std::string task;
  std::vector<RotatedBox> boxes;  ///< may be empty: nothing in this world serves the task
};

/// An object of a map.
struct Estimate {
  RotatedBox box;
  Eigen::VectorXd cosines;  ///< with the embedding of each task, in the order of the truth
};

/// Shares in [0, 1].
struct DetectionScores {
  double recall = 0.0;     ///< osR
  double precision = 0.0;  ///< osP
  double f1 = 0.0;         ///< harmonic mean of both, 0 if both are 0
};

/// What one task adds to the sums.
struct TaskCounts {
  std::string task;
  std::size_t num_true = 0;         ///< boxes of the truth, n
  std::size_t found_strict = 0;     ///< of the n objects of highest cosine, see below
  std::size_t found_relaxed = 0;    ///< likewise
  double iou_sum = 0.0;             ///< over the pairs of these n and the truth
  std::size_t num_kept = 0;         ///< objects of this task that count for precision
  std::size_t correct_strict = 0;   ///< of them
  std::size_t correct_relaxed = 0;  ///< of them
};

struct ObjectScores {
  DetectionScores strict;
  DetectionScores relaxed;
  double iou = 0.0;  ///< sum over the tasks over `num_true`
  /// How far the nearest of the n objects of highest cosine with its task (those that recall looks
  /// at, whatever is nearest to them) is from each thing, middle to middle; the median. None where
  /// the map has no object.
  std::optional<double> center_error_m;
  std::size_t num_objects = 0;  ///< all estimates
  std::size_t num_true = 0;     ///< denominator of recall and IoU
  std::size_t num_kept = 0;     ///< denominator of precision
  std::vector<TaskCounts> tasks;
};

/// Recall: of each task with n true boxes, the n estimates of highest cosine (the first ones among
/// equals) are paired with the boxes one to one, always the pair of largest IoU first, as long as
/// that is above 0. A pair counts where the boxes contain each other's centres (strict), or one of
/// them does (relaxed). One estimate may stand in the lists of several tasks.
///
/// Precision: each estimate belongs to the task of its highest cosine (the first among equals); of
/// those of a task the ones near the task's best, and none if that is not above 0, are kept and
/// paired in the same way.
///
/// deviation: where the paper does not say how estimates and boxes are paired, and that a missing
/// pair's IoU is 0, both modes follow the released code. Its F1 is the relaxed one.
/// @throws std::invalid_argument if no task has a box, or an estimate not a cosine for each task.
/// O(estimates * tasks + pairs^2 of a task).
ObjectScores computeObjectScores(const std::vector<TaskTruth>& truth,
                                 const std::vector<Estimate>& estimates, ScoreMode mode);

}  // namespace tsg::evaluation
