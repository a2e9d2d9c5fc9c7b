// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/concept_graphs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "evaluation/point_cloud.h"
#include "task_scene_graph/config/config.h"

namespace tsg::evaluation {
namespace {

PointCloud makeCloud(unsigned seed, int count, float size_m,
                     const Eigen::Vector3f& center_m = Eigen::Vector3f::Zero()) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> side(-size_m / 2, size_m / 2);
  PointCloud points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(center_m + Eigen::Vector3f(side(random), side(random), side(random)));
  }
  return points;
}

TEST(PointCloud, DownsamplingKeepsTheMeanOfEachVoxel) {
  const PointCloud points{{0.1F, 0.1F, 0.1F}, {0.3F, 0.1F, 0.1F}, {1.5F, 0.0F, 0.0F}};
  const PointCloud means = downsample(points, 1.0);
  ASSERT_EQ(means.size(), 2U);
  EXPECT_TRUE(means[0].isApprox(Eigen::Vector3f(0.2F, 0.1F, 0.1F)));
  EXPECT_TRUE(means[1].isApprox(points[2]));
}

TEST(PointCloud, OverlapIsTheShareOfNearPointsAsBruteForceSays) {
  const PointCloud a = makeCloud(1, 400, 1.0F);
  const PointCloud b = makeCloud(2, 300, 1.0F, {0.5F, 0.2F, 0.0F});
  constexpr float kDistance = 0.08F;
  int near = 0;
  for (const auto& p : a) {
    bool is_near = false;
    for (const auto& q : b) is_near = is_near || (p - q).squaredNorm() < kDistance * kDistance;
    near += is_near ? 1 : 0;
  }
  ASSERT_GT(near, 10);
  EXPECT_DOUBLE_EQ(computeOverlap(a, b, 0.08F), near / 400.0);
  EXPECT_EQ(computeOverlap({}, b, 0.08), 0.0);
}

TEST(PointCloud, LargestClusterIsKeptWithoutItsOutliers) {
  PointCloud points = makeCloud(3, 300, 0.4F);
  const PointCloud small = makeCloud(4, 60, 0.2F, {3.0F, 0.0F, 0.0F});
  points.insert(points.end(), small.begin(), small.end());
  points.emplace_back(9.0F, 9.0F, 9.0F);
  const PointCloud kept = keepLargestCluster(points, 0.1, 5);
  EXPECT_GT(kept.size(), 280U);
  EXPECT_LE(kept.size(), 300U);
  for (const auto& p : kept) EXPECT_LT(p.norm(), 1.0F);
}

TEST(PointCloud, CloudWithoutClusterStaysWhole) {
  const PointCloud sparse{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_EQ(keepLargestCluster(sparse, 0.1, 2).size(), 3U);
}

/// A camera that looks at a wall 2 m away; things are rectangles on it, each nearer by 10 cm.
class Wall {
 public:
  explicit Wall(double seconds) {
    frame_.camera = {160, 120, 150.0, 150.0, 79.5, 59.5};
    frame_.depth.image = cv::Mat(120, 160, CV_16UC1, cv::Scalar(2000));
    frame_.stamp = segmentation_.stamp = Stamp::fromSeconds(seconds);
    segmentation_.labels = cv::Mat::zeros(120, 160, CV_16UC1);
    segmentation_.embeddings.resize(0, 4);
  }

  Wall& add(const cv::Rect& where, const Eigen::Vector4f& embedding) {
    const auto row = segmentation_.embeddings.rows();
    segmentation_.embeddings.conservativeResize(row + 1, 4);
    segmentation_.embeddings.row(row) = embedding.normalized().transpose();
    segmentation_.confidences.push_back(1.0F);
    segmentation_.labels(where).setTo(static_cast<double>(row + 1));
    // A slope, so that the box has a volume.
    for (int u = where.x; u < where.x + where.width; ++u) {
      frame_.depth.image(cv::Rect(u, where.y, 1, where.height)).setTo(1800 + 2 * (u - where.x));
    }
    return *this;
  }

  RgbdFrame frame_;
  Segmentation segmentation_;
};

const Eigen::Vector4f kCup(1, 0, 0, 0);
const Eigen::Vector4f kBook(0, 1, 0, 0);
const cv::Rect kLeft(10, 30, 50, 50);
const cv::Rect kRight(100, 30, 50, 50);

std::vector<ConceptObject> map(const std::vector<Wall>& views, ConceptGraphsConfig config = {}) {
  ConceptGraphs mapping(config);
  for (const Wall& view : views) mapping.add(view.frame_, view.segmentation_);
  return mapping.finish();
}

TEST(ConceptGraphs, ThingSeenAgainIsOneObject) {
  std::vector<Wall> views;
  for (int i = 0; i < 5; ++i) views.push_back(Wall(i).add(kLeft, kCup).add(kRight, kBook));
  const auto objects = map(views);
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].num_detections, 5U);
  EXPECT_NEAR(objects[0].embedding.dot(kCup), 1.0, 1e-5);
  EXPECT_NEAR(objects[0].box.center_m.z(), 1.85, 0.05);
  EXPECT_EQ(objects[0].last_seen, Stamp::fromSeconds(4.0));
}

TEST(ConceptGraphs, SimilarityIsOverlapPlusCosineAndAtTheThresholdEnough) {
  // Same place: overlap 1. Cosine 0.2 reaches 1.2, a little less does not.
  const float above = 0.21F;
  const float below = 0.19F;
  const auto other = [](float cosine) {
    return Eigen::Vector4f(cosine, std::sqrt(1.0F - cosine * cosine), 0, 0);
  };
  ConceptGraphsConfig config;
  config.min_detections = 1;
  config.merge_overlap = 1.0;
  EXPECT_EQ(map({Wall(0).add(kLeft, kCup), Wall(1).add(kLeft, other(above))}, config).size(), 1U);
  EXPECT_EQ(map({Wall(0).add(kLeft, kCup), Wall(1).add(kLeft, other(below))}, config).size(), 2U);
}

TEST(ConceptGraphs, SameEmbeddingElsewhereIsAnotherObject) {
  ConceptGraphsConfig config;
  config.min_detections = 1;
  EXPECT_EQ(map({Wall(0).add(kLeft, kCup), Wall(1).add(kRight, kCup)}, config).size(), 2U);
}

TEST(ConceptGraphs, RarelySeenThingsAreLeftOut) {
  const std::vector<Wall> views{Wall(0).add(kLeft, kCup).add(kRight, kBook),
                                Wall(1).add(kLeft, kCup), Wall(2).add(kLeft, kCup)};
  ASSERT_EQ(map(views).size(), 1U);
}

TEST(ConceptGraphs, SmallAndLargeMasksAreNoDetections) {
  ConceptGraphsConfig config;
  config.min_detections = 1;
  EXPECT_TRUE(map({Wall(0).add(cv::Rect(10, 10, 4, 6), kCup)}, config).empty());
  EXPECT_TRUE(map({Wall(0).add(cv::Rect(0, 0, 160, 110), kCup)}, config).empty());
}

TEST(ConceptGraphs, ObjectsThatOverlapAndLookAlikeAreMergedAtTheEnd) {
  ConceptGraphsConfig config;
  config.min_similarity = 2.0;  // nothing is associated
  config.min_detections = 1;
  config.merge_interval = 0;
  const std::vector<Wall> alike{Wall(0).add(kLeft, kCup), Wall(1).add(kLeft, kCup)};
  EXPECT_EQ(map(alike, config).size(), 1U);
  const std::vector<Wall> different{Wall(0).add(kLeft, kCup), Wall(1).add(kLeft, kBook)};
  EXPECT_EQ(map(different, config).size(), 2U);
}

TEST(ConceptGraphs, OutOfRangeIsRefused) {
  ConceptGraphsConfig config;
  config.voxel_size_m = 0.0;
  EXPECT_THROW(ConceptGraphs{config}, config::ConfigError);
}

}  // namespace
}  // namespace tsg::evaluation
