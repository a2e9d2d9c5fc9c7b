// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <stdexcept>

#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/camera.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/core/stamp.h"

namespace tsg {
namespace {

const CameraModel kCamera{640, 480, 525.0, 520.0, 319.5, 239.5};

template <typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

RgbdFrame makeFrame() {
  RgbdFrame frame;
  frame.camera = {4, 3, 5.0, 5.0, 1.5, 1.0};
  frame.color.image = cv::Mat(3, 4, CV_8UC3, cv::Scalar::all(7));
  frame.depth.image = cv::Mat(3, 4, CV_16UC1, cv::Scalar(1500));
  return frame;
}

TEST(Box, TouchingBoxesDoNotOverlap) {
  const Aabb a = makeAabb({0, 0, 0}, {1, 1, 1});
  EXPECT_FALSE(hasOverlap(a, makeAabb({1, 0, 0}, {2, 1, 1})));
  EXPECT_TRUE(hasOverlap(a, makeAabb({0.999, 0, 0}, {2, 1, 1})));
}

TEST(Box, IoUOfConcentricCubesIsTheRatioOfVolumes) {
  const Aabb unit = makeAabb({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  const Aabb twice = makeAabb({-1, -1, -1}, {1, 1, 1});
  EXPECT_DOUBLE_EQ(computeIoU(unit, twice), 1.0 / 8.0);
  EXPECT_DOUBLE_EQ(computeIoU(unit, unit), 1.0);
  EXPECT_DOUBLE_EQ(computeIoU(unit, Aabb()), 0.0);
}

TEST(Camera, ProjectingUndoesUnprojecting) {
  const Eigen::Vector2d pixel = kCamera.project(kCamera.unproject(12.0, 400.0, 2.5));
  EXPECT_TRUE(pixel.isApprox(Eigen::Vector2d(12.0, 400.0)));
}

TEST(Camera, ErrorNamesTheBadIntrinsic) {
  CameraModel camera = kCamera;
  camera.fy_px = std::numeric_limits<double>::quiet_NaN();
  const std::string message = messageOf([&] { camera.validate(); });
  EXPECT_NE(message.find("fy (K[4]) is nan"), std::string::npos) << message;
}

TEST(Depth, InvalidReadingsAreZero) {
  DepthImage millimetres{cv::Mat(1, 3, CV_16UC1), 0.001, nullptr};
  millimetres.image.at<std::uint16_t>(0, 0) = 0;
  millimetres.image.at<std::uint16_t>(0, 1) = 65535;
  millimetres.image.at<std::uint16_t>(0, 2) = 1234;
  EXPECT_EQ(millimetres.at(0, 0), 0.0F);
  EXPECT_EQ(millimetres.at(1, 0), 0.0F);
  EXPECT_FLOAT_EQ(millimetres.at(2, 0), 1.234F);

  DepthImage metres{cv::Mat(1, 3, CV_32FC1), 1.0, nullptr};
  metres.image.at<float>(0, 0) = std::numeric_limits<float>::quiet_NaN();
  metres.image.at<float>(0, 1) = std::numeric_limits<float>::infinity();
  metres.image.at<float>(0, 2) = -1.0F;
  for (int u = 0; u < 3; ++u) EXPECT_EQ(metres.at(u, 0), 0.0F);
}

TEST(Frame, ErrorNamesTheImageOfAnotherSize) {
  RgbdFrame frame = makeFrame();
  EXPECT_NO_THROW(frame.validate());
  frame.depth.image = cv::Mat(2, 4, CV_16UC1);
  const std::string message = messageOf([&] { frame.validate(); });
  EXPECT_NE(message.find("depth image is 4x2, expected the camera's 4x3"), std::string::npos)
      << message;
}

TEST(Frame, PoseThatIsNoRotationIsRejected) {
  RgbdFrame frame = makeFrame();
  frame.T_world_camera.matrix()(0, 0) = 2.0;
  EXPECT_THROW(frame.validate(), std::invalid_argument);
}

TEST(SegmentationType, LabelBeyondTheSegmentsIsRejected) {
  Segmentation segmentation;
  segmentation.labels = cv::Mat(2, 2, CV_16UC1, cv::Scalar(3));
  segmentation.embeddings = EmbeddingMatrix::Ones(2, 4);
  segmentation.confidences = {0.5F, 0.5F};
  const std::string message = messageOf([&] { segmentation.validate(); });
  EXPECT_NE(message.find("label 3"), std::string::npos) << message;
}

TEST(MeshType, AppendedTrianglesPointAtAppendedVertices) {
  Mesh a;
  a.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  a.colors.resize(3);
  a.triangles = {{0, 1, 2}};
  Mesh both = a;
  both.append(a);
  ASSERT_EQ(both.triangles.size(), 2U);
  EXPECT_EQ(both.triangles[1], (std::array<std::uint32_t, 3>{3, 4, 5}));
  EXPECT_EQ(both.computeBounds().max(), Eigen::Vector3d(1, 1, 0));
}

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> visits(1000);
    parallelFor(visits.size(), threads, [&](std::size_t i) { ++visits[i]; });
    for (const auto& count : visits) ASSERT_EQ(count, 1);
  }
}

TEST(ParallelFor, RethrowsAnErrorOfABody) {
  const auto body = [](std::size_t i) {
    if (i == 7) throw std::runtime_error("seven");
  };
  EXPECT_THROW(parallelFor(100, 2, body), std::runtime_error);
}

TEST(StampType, SecondsRoundToNanoseconds) {
  EXPECT_EQ(Stamp::fromSeconds(1.5).ns, 1500000000);
  EXPECT_DOUBLE_EQ(secondsBetween(Stamp{500000000}, Stamp{2000000000}), 1.5);
}

}  // namespace
}  // namespace tsg
