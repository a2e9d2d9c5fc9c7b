// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/constellation.h"

#include <gtest/gtest.h>

#include <random>

#include "task_scene_graph/config/config.h"

namespace tsg::loops {
namespace {

class Draw {
 public:
  explicit Draw(std::uint32_t seed) : engine_(seed) {}
  Eigen::Vector3d position() {
    return {4.0 * uniform_(engine_), 4.0 * uniform_(engine_), uniform_(engine_)};
  }
  Embedding embedding() {
    Embedding e(32);
    for (Eigen::Index i = 0; i < e.size(); ++i) e(i) = static_cast<float>(uniform_(engine_));
    return e;
  }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

Pose makeMotion() {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(3.0, -2.0, 0.4);
  T.linear() = Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()).matrix();
  return T;
}

class Constellations : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Constellations, testing::Range(0U, 10U));

TEST_P(Constellations, AreFoundAmongThingsThatAreElsewhereAndLookAlike) {
  Draw draw(GetParam());
  const Pose T_a_b = makeMotion();
  std::vector<Landmark> a;
  std::vector<Landmark> b;
  for (int i = 0; i < 8; ++i) {
    const Landmark landmark{draw.position(), draw.embedding()};
    a.push_back({T_a_b * landmark.position_m, landmark.embedding});
    b.push_back(landmark);
  }
  for (int i = 0; i < 8; ++i) {  // the same chairs at other places
    a.push_back({draw.position(), a[static_cast<std::size_t>(i)].embedding});
    b.push_back({draw.position(), b[static_cast<std::size_t>(i)].embedding});
  }
  const Constellation found = matchConstellation(a, b, {});
  EXPECT_GE(found.pairs.size(), 8U);
  EXPECT_LT((found.T_a_b.inverse() * T_a_b).translation().norm(), 0.2);
  std::size_t num_true = 0;
  for (const auto& [in_a, in_b] : found.pairs) num_true += in_a == in_b && in_a < 8 ? 1 : 0;
  EXPECT_GE(num_true, 7U);
}

TEST_P(Constellations, OfDifferentPlacesAreNone) {
  Draw draw(GetParam());
  std::vector<Landmark> a;
  std::vector<Landmark> b;
  for (int i = 0; i < 10; ++i) {
    a.push_back({draw.position(), draw.embedding()});
    b.push_back({draw.position(), draw.embedding()});
  }
  EXPECT_TRUE(matchConstellation(a, b, {}).pairs.empty());
}

TEST(Constellation, OnALineFixesNoMotion) {
  Draw draw(1);
  std::vector<Landmark> a;
  for (int i = 0; i < 8; ++i) a.push_back({{0.7 * i, 0.05 * (i % 2), 0.0}, draw.embedding()});
  EXPECT_TRUE(matchConstellation(a, a, {}).pairs.empty());
}

TEST(Constellation, OfFewerThanAskedForIsNone) {
  Draw draw(1);
  std::vector<Landmark> a;
  for (int i = 0; i < 3; ++i) a.push_back({draw.position(), draw.embedding()});
  EXPECT_TRUE(matchConstellation(a, a, {}).pairs.empty());
  EXPECT_TRUE(matchConstellation({}, {}, {}).pairs.empty());
  ConstellationConfig config;
  config.min_landmarks = 2;
  EXPECT_THROW(matchConstellation(a, a, config), config::ConfigError);
}

TEST(Landmarks, ThatAreNearAndAlikeAreJoinedOthersNot) {
  Draw draw(3);
  const Embedding cup = draw.embedding();
  std::vector<Landmark> landmarks = {{{0.0, 0.0, 0.0}, cup}};
  joinLandmarks({{{0.2, 0.0, 0.0}, cup}}, 0.3, 0.8, landmarks);
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_NEAR(landmarks[0].position_m.x(), 0.1, 1e-12);
  joinLandmarks({{{0.6, 0.0, 0.0}, cup}, {{0.1, 0.0, 0.0}, draw.embedding()}}, 0.3, 0.8, landmarks);
  EXPECT_EQ(landmarks.size(), 3U);
}

}  // namespace
}  // namespace tsg::loops
