// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/class_scores.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "support.h"
#include "task_scene_graph/mapping/ply.h"

namespace tsg::evaluation {
namespace {

constexpr double kTolerance = 1e-6;

ConfusionMatrix makeWorkedCase() {
  ConfusionMatrix confusion(3, 3);
  confusion << 8, 2, 0, 1, 3, 0, 0, 4, 2;
  return confusion;
}

TEST(ClassScores, WorkedCase) {
  const ClassScores scores = computeClassScores(makeWorkedCase());
  EXPECT_NEAR(scores.mean_accuracy, .627778, kTolerance);
  EXPECT_NEAR(scores.ious[0], .727273, kTolerance);
  EXPECT_NEAR(scores.ious[1], .3, kTolerance);
  EXPECT_NEAR(scores.ious[2], .333333, kTolerance);
  EXPECT_NEAR(scores.mean_iou, .453535, kTolerance);
  EXPECT_NEAR(scores.weighted_iou, .523636, kTolerance);
  EXPECT_EQ(scores.num_classes, 3U);
}

TEST(ClassScores, ClassesWithoutTruePointsCountOnlyAsMistakesOfOthers) {
  ConfusionMatrix confusion = ConfusionMatrix::Zero(4, 4);
  confusion.topLeftCorner(3, 3) = makeWorkedCase();
  EXPECT_NEAR(computeClassScores(confusion).mean_accuracy, .627778, kTolerance);
  EXPECT_NEAR(computeClassScores(confusion).weighted_iou, .523636, kTolerance);
  EXPECT_EQ(computeClassScores(confusion).num_classes, 3U);
  EXPECT_EQ(computeClassScores(confusion).ious[3], 0.0);
  confusion(0, 3) = 10;  // half of the first class is taken for the unseen one
  EXPECT_NEAR(computeClassScores(confusion).recalls[0], .4, kTolerance);
}

TEST(ClassScores, PointsWithoutAClassAreMissedAndNoOnesMistake) {
  ConfusionMatrix confusion = ConfusionMatrix::Zero(2, 3);
  confusion << 3, 0, 1, 0, 2, 2;
  const ClassScores scores = computeClassScores(confusion);
  EXPECT_NEAR(scores.mean_accuracy, .625, kTolerance);
  EXPECT_NEAR(scores.ious[0], .75, kTolerance);
  EXPECT_NEAR(scores.ious[1], .5, kTolerance);
}

TEST(ClassScores, AreZeroOfNothingAndRefuseOtherShapes) {
  EXPECT_EQ(computeClassScores(ConfusionMatrix::Zero(2, 2)).mean_iou, 0.0);
  EXPECT_EQ(computeClassScores(ConfusionMatrix(0, 0)).weighted_iou, 0.0);
  EXPECT_THROW(computeClassScores(ConfusionMatrix::Zero(2, 4)), std::invalid_argument);
}

TEST(Confusion, TakesTheNearestPredictedPointWithinTheDistance) {
  const LabelledPoints truth{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {9, 0, 0}, {0, 1, 0}},
                             {0, 1, 1, 0, kNoClass}};
  const LabelledPoints predicted{{{0.01, 0, 0}, {1, 0.02, 0}, {2, 0, 0.03}, {0, 1, 0}},
                                 {0, 0, kNoClass, 1}};
  ConfusionMatrix expected(2, 3);
  expected << 1, 0, 1, 1, 0, 1;  // one too far away, one near a point without a class
  EXPECT_EQ(computeConfusion(truth, predicted, 2, 0.1), expected);
  expected << 0, 0, 2, 0, 0, 2;
  EXPECT_EQ(computeConfusion(truth, {}, 2, 0.1), expected);
}

TEST(Confusion, RefusesClassesThatAreNone) {
  const LabelledPoints points{{{0, 0, 0}}, {2}};
  EXPECT_THROW(computeConfusion(points, {}, 2, 0.1), std::invalid_argument);
  EXPECT_THROW(computeConfusion({{{0, 0, 0}}, {}}, {}, 2, 0.1), std::invalid_argument);
}

class LabelledFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(path_) << text;
    return path_;
  }

  std::string failOf(const std::string& text) const {
    try {
      loadLabelledPoints(write(text), "label");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  test::TemporaryFolder folder_;
  std::string path_ = (folder_.path() / "labels.ply").string();
};

TEST_F(LabelledFile, AsciiIsReadInAnyOrderOfProperties) {
  const LabelledPoints points = loadLabelledPoints(
      write("ply\nformat ascii 1.0\nelement vertex 2\nproperty int label\nproperty float x\n"
            "property float y\nproperty float z\nelement face 1\nproperty list uchar int "
            "vertex_indices\nend_header\n3 1 2 3\n-1 0 0 0.5\n3 0 1 1\n"),
      "label");
  EXPECT_EQ(points.classes, (std::vector<int>{3, kNoClass}));
  EXPECT_EQ(points.points_m[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(points.points_m[1], Eigen::Vector3d(0, 0, 0.5));
}

TEST_F(LabelledFile, MapsOfThisPackageAreRead) {
  Mesh mesh;
  mesh.vertices = {{1.0F, 2.0F, 3.0F}, {4.0F, 5.0F, 6.0F}, {0.5F, 0.0F, 0.0F}};
  mesh.colors.resize(3);
  mapping::writePly(path_, mesh, {7, 0, 2});
  const LabelledPoints points = loadLabelledPoints(path_, "object_id");
  EXPECT_EQ(points.classes, (std::vector<int>{7, 0, 2}));
  EXPECT_EQ(points.points_m[1], Eigen::Vector3d(4, 5, 6));
}

TEST_F(LabelledFile, ErrorsNameTheFileAndWhatIsWrong) {
  const std::string start = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n";
  const std::string rest = "property float y\nproperty float z\nproperty int label\nend_header\n";
  EXPECT_NE(failOf(start + rest + "1 2 3 0\n").find("ends at vertex 1"), std::string::npos);
  EXPECT_NE(failOf(start + "end_header\n").find("no 'y'"), std::string::npos);
  EXPECT_NE(failOf(start).find("no end"), std::string::npos);
  EXPECT_NE(failOf("solid\n").find("expected a PLY file"), std::string::npos);
  EXPECT_NE(failOf("ply\nformat binary_big_endian 1.0\n").find("big_endian"), std::string::npos);
  EXPECT_NE(failOf(start + rest + "1 2 3 -4\n0 0 0 0\n").find("vertex 0"), std::string::npos);
  EXPECT_NE(failOf("ply\nformat ascii 1.0\nelement face 2\n").find("'face'"), std::string::npos);
}

}  // namespace
}  // namespace tsg::evaluation
