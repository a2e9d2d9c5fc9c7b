// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/grasp_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <random>
#include <string>

namespace tsg::tracking {
namespace {

constexpr int kWidth_px = 40;
constexpr int kHeight_px = 30;

/// A view of a wall 2 m away, and three segments with embeddings along the axes.
struct Scene {
  RgbdFrame frame;
  Segmentation segmentation;

  Scene() {
    frame.camera = {kWidth_px, kHeight_px, 50.0, 60.0, 19.5, 14.5};
    frame.T_world_camera = Eigen::Translation3d(1.0, 2.0, 3.0) *
                           Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
    frame.depth.image = cv::Mat(kHeight_px, kWidth_px, CV_32FC1, cv::Scalar(2.0F));
    frame.depth.metres_per_unit = 1.0;
    segmentation.labels = cv::Mat::zeros(kHeight_px, kWidth_px, CV_16UC1);
    segmentation.labels(cv::Rect(2, 3, 7, 9)).setTo(1);
    segmentation.labels(cv::Rect(20, 10, 11, 5)).setTo(2);
    segmentation.labels(cv::Rect(0, 25, 3, 3)).setTo(3);
    segmentation.embeddings = EmbeddingMatrix::Identity(3, 3);
  }
};

std::string explain(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

TEST(GraspPoint, IsTheMiddleOfTheSegmentThatFitsBestInSpace) {
  const Scene scene;
  const GraspPoint grasp =
      findGraspPoint(scene.frame, scene.segmentation, Embedding(Eigen::Vector3f(0.1F, 0.9F, 0.0F)));
  EXPECT_EQ(grasp.segment, 2);
  EXPECT_EQ(grasp.num_pixels, 55U);
  EXPECT_EQ(grasp.u_px, 25);
  EXPECT_EQ(grasp.v_px, 12);
  EXPECT_NEAR(grasp.score, 0.9 / std::hypot(0.1, 0.9), 1e-6);
  EXPECT_NEAR(grasp.margin, 0.8 / std::hypot(0.1, 0.9), 1e-6);
  EXPECT_TRUE(grasp.p_camera.isApprox(Eigen::Vector3d(5.5 / 50.0 * 2.0, -2.5 / 60.0 * 2.0, 2.0)));
  EXPECT_TRUE((scene.frame.T_world_camera.inverse() * grasp.p_world).isApprox(grasp.p_camera));
}

TEST(GraspPoint, LiesInTheSegmentAsNearToItsCentroidAsItCan) {
  std::mt19937 random(11);
  std::bernoulli_distribution is_in(0.2);
  for (int round = 0; round < 100; ++round) {
    Scene scene;
    Eigen::Vector2d sum(0.0, 0.0);
    std::vector<Eigen::Vector2d> pixels;
    scene.segmentation.labels.setTo(0);
    for (int v = 0; v < kHeight_px; ++v) {
      for (int u = 0; u < kWidth_px; ++u) {
        const bool is_on_ring = std::abs(std::hypot(u - 20.0, v - 15.0) - 10.0) < 2.0;
        if (!is_on_ring || !is_in(random)) continue;
        scene.segmentation.labels.at<std::uint16_t>(v, u) = 1;
        pixels.emplace_back(u, v);
        sum += pixels.back();
      }
    }
    ASSERT_FALSE(pixels.empty());
    const Eigen::Vector2d centroid = sum / static_cast<double>(pixels.size());
    double least = std::numeric_limits<double>::infinity();
    for (const auto& p : pixels) least = std::min(least, (p - centroid).norm());
    const GraspPoint grasp =
        findGraspPoint(scene.frame, scene.segmentation, Embedding(Eigen::Vector3f::UnitX()));
    EXPECT_EQ(scene.segmentation.labels.at<std::uint16_t>(grasp.v_px, grasp.u_px), 1);
    EXPECT_NEAR((Eigen::Vector2d(grasp.u_px, grasp.v_px) - centroid).norm(), least, 1e-9);
  }
}

TEST(GraspPoint, TakesTheDepthOfItsOwnSegmentWhereSinglePixelsHaveNone) {
  Scene scene;
  scene.frame.depth.image.setTo(5.0F);                           // what is behind
  scene.frame.depth.image(cv::Rect(20, 10, 11, 5)).setTo(1.5F);  // the segment
  scene.frame.depth.image.at<float>(12, 25) = std::nanf("");     // its middle
  scene.segmentation.labels(cv::Rect(20, 10, 11, 2)).setTo(0);   // near the edge
  scene.frame.depth.image.at<float>(13, 25) = std::nanf("");
  const GraspPoint grasp =
      findGraspPoint(scene.frame, scene.segmentation, Embedding(Eigen::Vector3f::UnitY()));
  EXPECT_EQ(grasp.p_camera.z(), 1.5);
}

TEST(GraspPoint, WithoutDepthItIsRefused) {
  Scene scene;
  scene.frame.depth.image(cv::Rect(20, 10, 11, 5)).setTo(0.0F);
  scene.frame.depth.image(cv::Rect(20, 10, 2, 5)).setTo(2.0F);
  const std::string text = explain([&] {
    findGraspPoint(scene.frame, scene.segmentation, Embedding(Eigen::Vector3f::UnitY()));
  });
  EXPECT_NE(text.find("no depth at pixel (25, 12)"), std::string::npos) << text;
  EXPECT_NE(text.find("10 of its 55 pixels"), std::string::npos) << text;
}

TEST(GraspPoint, SegmentsThatWereNotEmbeddedAreNoAnswer) {
  Scene scene;
  scene.segmentation.embeddings.row(1).setZero();
  const Embedding question = Eigen::Vector3f(0.1F, 0.9F, 0.0F);
  EXPECT_EQ(findGraspPoint(scene.frame, scene.segmentation, question).segment, 1);
  scene.segmentation.embeddings.setZero();
  const std::string text =
      explain([&] { findGraspPoint(scene.frame, scene.segmentation, question); });
  EXPECT_NE(text.find("none of the 3 segments"), std::string::npos) << text;
}

TEST(GraspPoint, WhatIsNoQuestionIsRefused) {
  Scene scene;
  const auto ask = [&](const Embedding& question) {
    return explain([&] { findGraspPoint(scene.frame, scene.segmentation, question); });
  };
  EXPECT_NE(ask(Embedding::Ones(4)).find("4 numbers, expected 3"), std::string::npos);
  EXPECT_NE(ask(Embedding()).find("0 numbers, expected 3"), std::string::npos);
  EXPECT_NE(ask(Embedding::Zero(3)).find("no direction"), std::string::npos);
  EXPECT_NE(ask(Embedding::Constant(3, std::nanf(""))).find("no direction"), std::string::npos);
  scene.segmentation.embeddings.resize(0, 3);
  EXPECT_NE(ask(Embedding::Ones(3)).find("has no segments"), std::string::npos);
}

}  // namespace
}  // namespace tsg::tracking
