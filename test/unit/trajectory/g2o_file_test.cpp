// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/g2o_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "graph_worlds.h"
#include "support.h"

namespace tsg::trajectory {
namespace {

/// Upper triangle of an information that is w for translations and v for g2o's rotations.
std::string makeTriangle(double w, double v) {
  std::ostringstream text;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      text << ' ' << (row != column ? 0.0 : row < 3 ? w : v);
    }
  }
  return text.str();
}

class G2oFile : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    const std::string path = (folder_.path() / "graph.g2o").string();
    std::ofstream(path) << text;
    return path;
  }
  std::string errorOf(const std::string& text) {
    try {
      loadG2o(write(text));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
};

PoseGraphConfig makeTrustingConfig() {
  PoseGraphConfig config;
  config.max_loop_chi2 = 1e6;
  config.max_gate_chi2 = 1e12;
  return config;
}

// A square of 1 m that odometry walks with a turn of 94 degrees at each corner instead of 90, and
// no error of position: all three edges and the closing one share the 16 degrees. g2o's chi2 of an
// edge that is turned by x is v sin(x / 2)^2.
TEST_F(G2oFile, ASquareIsSolvedToItsKnownOptimum) {
  const double turn_rad = 94.0 * kPi / 180.0;
  std::ostringstream text;
  text << std::setprecision(17) << "# a square\n";
  Pose pose = Pose::Identity();
  const auto print = [&](const Pose& T) {
    const Eigen::Quaterniond q(T.linear());
    text << T.translation().transpose() << ' ' << q.coeffs().transpose();
  };
  const Pose step = makePose(0.0, 0.0, 0.0, turn_rad);
  for (int i = 0; i < 4; ++i) {
    text << "VERTEX_SE3:QUAT " << i << ' ';
    print(pose);
    text << '\n';
    pose = pose * step;
  }
  text << "FIX 0\n";
  for (int i = 0; i < 4; ++i) {
    text << "EDGE_SE3:QUAT " << i << ' ' << (i + 1) % 4 << ' ';
    print(step);
    text << makeTriangle(100.0, 50.0) << '\n';
  }
  PoseGraph graph = loadG2o(write(text.str()), makeTrustingConfig());
  ASSERT_EQ(graph.keyframes().size(), 4U);
  EXPECT_EQ(graph.edges()[2].kind, EdgeKind::kOdometry);
  EXPECT_EQ(graph.edges()[3].kind, EdgeKind::kLoop);
  const SolveReport report = graph.optimize();
  ASSERT_EQ(report.status, SolveStatus::kSolved) << report.message;
  const double half_rad = 16.0 * kPi / 180.0 / 2.0;
  EXPECT_NEAR(report.chi2_before, 50.0 * std::pow(std::sin(half_rad), 2), 1e-9);
  EXPECT_NEAR(report.chi2_after, 4.0 * 50.0 * std::pow(std::sin(half_rad / 4.0), 2), 1e-9);
  const Pose last = graph.find(KeyframeId{4})->T_world_keyframe;
  EXPECT_NEAR(toVector(last)(5), toVector(makePose(0.0, 0.0, 0.0, 1.5 * kPi))(5), 1e-6);
}

// Written by hand: three vertices on a line, 1 m by odometry from each to the next, and 2.3 m in
// one.
TEST_F(G2oFile, ALineIsSolvedToItsKnownOptimum) {
  const std::string text =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
      "VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
      "VERTEX_SE3:QUAT 2 2 0 0 0 0 0 1\n"
      "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 4 0 0 4 0 4\n"
      "EDGE_SE3:QUAT 1 2 1 0 0 0 0 0 1 4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 4 0 0 4 0 4\n"
      "EDGE_SE3:QUAT 0 2 2.3 0 0 0 0 0 1 2 0 0 0 0 0 2 0 0 0 0 2 0 0 0 2 0 0 2 0 2  # again\n";
  PoseGraph graph = loadG2o(write(text), makeTrustingConfig());
  EXPECT_NEAR(graph.computeChi2(), 0.0, 1e-12);  // of odometry
  const SolveReport report = graph.optimize();
  EXPECT_NEAR(report.chi2_after, 0.09 / (0.25 + 0.25 + 0.5), 1e-10);
  EXPECT_NEAR(graph.find(KeyframeId{3})->T_world_keyframe.translation().x(), 2.15, 1e-7);
}

TEST_F(G2oFile, InformationBetweenRotationAndTranslationIsHalved) {
  const std::string text =
      "VERTEX_SE3:QUAT 3 0 0 0 0 0 0 1\n"
      "VERTEX_SE3:QUAT 7 1 0 0 0 0 0 1\n"
      "EDGE_SE3:QUAT 3 7 1 0 0 0 0 0 2 9 1 2 3 4 5 9 1 2 3 4 9 1 2 3 9 1 2 9 1 9\n";
  const PoseGraph graph = loadG2o(write(text));
  const PoseEdge& edge = graph.edges().at(0);
  EXPECT_EQ(edge.a, KeyframeId{4});
  EXPECT_EQ(edge.information(0, 2), 2.0);
  EXPECT_EQ(edge.information(0, 3), 1.5);
  EXPECT_EQ(edge.information(4, 1), 1.5);
  EXPECT_EQ(edge.information(5, 5), 2.25);
  EXPECT_TRUE(edge.T_a_b.linear().isIdentity());
}

TEST_F(G2oFile, ErrorsNameTheLineAndWhatWasExpected) {
  const std::string vertex = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  EXPECT_NE(errorOf(vertex + "VERTEX_SE2 1 0 0 0\n").find("line 2: 'VERTEX_SE2' is not known"),
            std::string::npos);
  EXPECT_NE(errorOf("VERTEX_SE3:QUAT -1 0 0 0 0 0 0 1\n").find("line 1: '-1' is no id"),
            std::string::npos);
  EXPECT_NE(errorOf("VERTEX_SE3:QUAT 1 0 0 x 0 0 0 1\n").find("'x' where a number was expected"),
            std::string::npos);
  EXPECT_NE(errorOf("VERTEX_SE3:QUAT 1 0 0 nan 0 0 0 1\n").find("line 1: keyframe 2 has the pose"),
            std::string::npos);
  EXPECT_NE(errorOf("VERTEX_SE3:QUAT 1 0 0 0 0 0 0 0\n").find("has no length"), std::string::npos);
  EXPECT_NE(errorOf("VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1 9\n").find("'9' where the line should end"),
            std::string::npos);
  EXPECT_NE(errorOf(vertex + "\n" + "EDGE_SE3:QUAT 0 5 0 0 0 0 0 0 1" + makeTriangle(1, 1))
                .find("line 3: the edge from keyframe 1 to keyframe 6 names keyframe 6"),
            std::string::npos);
  EXPECT_NE(errorOf("# nothing\n").find("holds no VERTEX_SE3:QUAT"), std::string::npos);
  EXPECT_THROW(loadG2o((folder_.path() / "none").string()), std::runtime_error);
}

}  // namespace
}  // namespace tsg::trajectory
