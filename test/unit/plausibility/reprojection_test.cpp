// SPDX-License-Identifier: BSD-3-Clause
#include "plausibility/reprojection.h"

#include <gtest/gtest.h>

#include <set>

#include "rgbd_faults.h"
#include "synthetic_scene.h"

namespace tsg::plausibility {
namespace {

using Kind = Hypothesis::Kind;

struct TwoViews {
  Pose T_world_source = test::lookAt({-1.0, 0.2, 1.3}, {1.5, 0.4, 0.8});
  Pose T_world_target = test::lookAt({-0.8, 0.0, 1.2}, {1.5, 0.3, 0.7});
  DepthGrid source;
  DepthGrid target;

  TwoViews() {
    const std::vector<test::Solid> scene{test::makePlane({0, 0, 0}, {0, 0, 1}, {100, 100, 100}),
                                         test::makePlane({3, 0, 0}, {-1, 0, 0}, {200, 100, 100}),
                                         test::makePlane({0, 2, 0}, {0, -1, 0}, {100, 200, 100}),
                                         test::makePlane({0, -2, 0}, {0, 1, 0}, {100, 100, 200}),
                                         test::makeSphere({1.5, 0.3, 0.7}, 0.5, {250, 250, 0})};
    const CameraModel camera{160, 120, 131.0, 131.0, 79.5, 59.5};
    source = sampleDepth(test::render(scene, camera, T_world_source).frame, 160);
    target = sampleDepth(test::render(scene, camera, T_world_target).frame, 160);
  }

  Disagreement compare(const Hypothesis& hypothesis) const {
    return computeDisagreement(hypothesis, pickPixels(source, 400), target,
                               computeRelativePose(hypothesis, T_world_target, T_world_source));
  }
};

TEST(Reprojection, TrueViewsAgreeButForWhatIsHidden) {
  const Disagreement result = TwoViews().compare({});
  EXPECT_GT(result.num_points, 300U);
  EXPECT_LT(result.in_view_cost, 0.05);
  EXPECT_GT(result.in_view_share, 0.7);
}

TEST(Reprojection, StandingStillDoesNotExplainAMotion) {
  Hypothesis hypothesis;
  hypothesis.kind = Kind::kStandstill;
  const TwoViews views;
  EXPECT_GT(views.compare(hypothesis).in_view_cost, 5.0 * views.compare({}).in_view_cost);
  EXPECT_GT(views.compare(hypothesis).in_view_share, 0.9);  // the border is lost
}

TEST(Reprojection, ACommonScaleOfDepthAndTranslationChangesNothing) {
  TwoViews views;
  const double before = views.compare({}).cost;
  for (DepthGrid* grid : {&views.source, &views.target}) {
    for (float& z_m : grid->z_m) z_m *= 7.0F;
  }
  views.T_world_source.translation() *= 7.0;
  views.T_world_target.translation() *= 7.0;
  EXPECT_NEAR(views.compare({}).cost, before, 1e-3);
}

TEST(Reprojection, AFactorOfDepthUndoesAWrongUnit) {
  TwoViews views;
  const double right = views.compare({}).cost;
  for (DepthGrid* grid : {&views.source, &views.target}) {
    for (float& z_m : grid->z_m) z_m *= 0.2F;
  }
  Hypothesis five;
  five.kind = Kind::kDepthScale;
  five.depth_factor = 5.0;
  EXPECT_NEAR(views.compare(five).cost, right, 1e-3);
  EXPECT_GT(views.compare({}).cost, right + 0.2);
}

TEST(Reprojection, PointsOutOfTheImageCostHalf) {
  TwoViews views;
  views.T_world_target.translation() += Eigen::Vector3d(0.0, 100.0, 0.0);
  const Disagreement result = views.compare({});
  EXPECT_DOUBLE_EQ(result.cost, 0.5);
  EXPECT_DOUBLE_EQ(result.in_view_share, 0.0);
}

TEST(Reprojection, PointsOnInvalidReadingsAreLeftOut) {
  TwoViews views;
  const std::size_t all = views.compare({}).num_points;
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 160; ++u) views.target.at(u, v) = 0.0F;
  }
  const Disagreement result = views.compare({});
  EXPECT_LT(result.num_points, all);
  EXPECT_LT(result.in_view_cost, 0.05);
}

TEST(Reprojection, OnlyTheSameReadingIsUnchanged) {
  const TwoViews views;
  const auto pixels = pickPixels(views.source, 400);
  EXPECT_DOUBLE_EQ(computeUnchangedShare(pixels, views.source), 1.0);
  EXPECT_LT(computeUnchangedShare(pixels, views.target), 0.2);
  EXPECT_DOUBLE_EQ(computeUnchangedShare({}, views.source), 0.0);
}

TEST(Hypotheses, HoldTheGivenReadingAndTwentyFourAxesWithPosesEitherWay) {
  std::set<std::string> rotations;
  int inverse = 0;
  const auto hypotheses = makeSingleHypotheses();
  EXPECT_EQ(hypotheses[0].kind, Kind::kGiven);
  EXPECT_EQ(hypotheses[1].kind, Kind::kStandstill);
  for (const Hypothesis& hypothesis : hypotheses) {
    const bool is_axes = hypothesis.kind == Kind::kGiven || hypothesis.kind == Kind::kAxes ||
                         hypothesis.kind == Kind::kInverse || hypothesis.kind == Kind::kInverseAxes;
    if (!is_axes) continue;
    EXPECT_NEAR(hypothesis.R_given_true.determinant(), 1.0, 1e-12);
    std::ostringstream text;
    text << hypothesis.is_inverse << hypothesis.R_given_true;
    EXPECT_TRUE(rotations.insert(text.str()).second);
    inverse += hypothesis.is_inverse ? 1 : 0;
  }
  EXPECT_EQ(rotations.size(), 48U);
  EXPECT_EQ(inverse, 24);
}

TEST(Hypotheses, UndoEachConventionExactly) {
  const Pose T_world_a = test::lookAt({0, 0, 1}, {2, 1, 1});
  const Pose T_world_b = test::lookAt({0.3, -0.2, 1.2}, {2, 0, 1});
  const Pose truth = T_world_b.inverse() * T_world_a;
  test::RgbdWalk walk(2);
  walk[0].T_world_camera = T_world_a;
  walk[1].T_world_camera = T_world_b;
  const auto expectUndone = [&](const test::RgbdWalk& given, const Eigen::Matrix3d& R,
                                bool is_inverse) {
    Hypothesis hypothesis;
    hypothesis.R_given_true = R;
    hypothesis.is_inverse = is_inverse;
    const Pose T =
        computeRelativePose(hypothesis, given[1].T_world_camera, given[0].T_world_camera);
    EXPECT_TRUE(T.isApprox(truth, 1e-9));
  };
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  expectUndone(test::withInversePoses(walk), I, true);
  expectUndone(test::withOpenglAxes(walk), openglAxes(), false);
  expectUndone(test::withBodyAxes(walk), bodyAxes(), false);
  expectUndone(test::withInversePoses(test::withBodyAxes(walk)), bodyAxes(), true);
  expectUndone(test::withMirroredWorld(walk), Eigen::Vector3d(1, -1, 1).asDiagonal(), false);
}

}  // namespace
}  // namespace tsg::plausibility
