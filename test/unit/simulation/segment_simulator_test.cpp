// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/segment_simulator.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <set>

#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

const CameraModel kCamera{320, 240, 262.5, 262.5, 159.5, 119.5};

class SegmentSimulatorTest : public ::testing::Test {
 protected:
  RenderedView renderAt(double share) const {
    const auto index = static_cast<std::size_t>(share * static_cast<double>(walk_.size()));
    return Renderer(apartment_, 2).render(kCamera, walk_[index].T_world_camera);
  }

  Apartment apartment_ = buildApartment({1, 6});
  std::vector<WalkPose> walk_ = planWalk(apartment_, WalkConfig{});
};

TEST_F(SegmentSimulatorTest, SegmentsAreThePartsThatAreLargeEnough) {
  SegmentConfig config;
  config.dropout = 0.0;
  const SegmentSimulator simulator(apartment_, config);
  for (const double share : {0.2, 0.4, 0.6, 0.8}) {
    const RenderedView view = renderAt(share);
    const Segmentation result = simulator.segment(view, Stamp{5}, 9);
    result.validate();
    EXPECT_EQ(result.stamp.ns, 5);
    std::map<std::uint16_t, int> pixels;
    std::map<std::uint16_t, std::uint16_t> part_of_segment;
    for (int v = 0; v < kCamera.height_px; ++v) {
      for (int u = 0; u < kCamera.width_px; ++u) {
        const std::uint16_t part = view.parts.at<std::uint16_t>(v, u);
        const std::uint16_t segment = result.labels.at<std::uint16_t>(v, u);
        if (part > 0) ++pixels[part];
        if (segment > 0) {
          EXPECT_EQ(part_of_segment.emplace(segment, part).first->second, part);
        }
      }
    }
    std::uint16_t expected = 0;
    for (const auto& [part, count] : pixels) {
      if (count < config.min_pixels) continue;
      ++expected;
      EXPECT_EQ(part_of_segment.at(expected), part);
      const Embedding row = result.embeddings.row(expected - 1).transpose();
      EXPECT_EQ(row, simulator.embedPart(part, 9));
    }
    EXPECT_EQ(result.numSegments(), expected);
  }
}

TEST_F(SegmentSimulatorTest, FurnitureFallsIntoPartsAndSmallThingsDoNot) {
  std::map<std::string, std::set<std::uint16_t>> parts;
  for (std::size_t i = 0; i < apartment_.parts.size(); ++i) {
    const Instance& thing = apartment_.instances[apartment_.parts[i].instance - 1U];
    if (thing.phrase == "sofa" || thing.phrase == "laptop") {
      parts[thing.phrase].insert(static_cast<std::uint16_t>(i + 1));
    }
  }
  EXPECT_GE(parts["sofa"].size(), 4U);
  EXPECT_EQ(parts["laptop"].size(), 1U);
}

TEST_F(SegmentSimulatorTest, DropoutLeavesOutTheAskedShareDifferentlyInEachFrame) {
  SegmentConfig config;
  const RenderedView view = renderAt(0.5);
  config.dropout = 0.0;
  const std::size_t all = SegmentSimulator(apartment_, config).segment(view, {}, 0).numSegments();
  config.dropout = 0.2;
  const SegmentSimulator simulator(apartment_, config);
  double found = 0.0;
  constexpr int kFrames = 60;
  for (int frame = 0; frame < kFrames; ++frame) {
    found += static_cast<double>(simulator.segment(view, {}, frame).numSegments());
  }
  EXPECT_NEAR(found / (kFrames * static_cast<double>(all)), 0.8, 0.05);
}

TEST_F(SegmentSimulatorTest, FollowsFromTheFrameNumber) {
  const SegmentSimulator simulator(apartment_, SegmentConfig{});
  const RenderedView view = renderAt(0.3);
  const Segmentation a = simulator.segment(view, {}, 4);
  const Segmentation b = simulator.segment(view, {}, 4);
  EXPECT_EQ(a.embeddings, b.embeddings);
  EXPECT_EQ(a.image_embedding, b.image_embedding);
  EXPECT_EQ(std::memcmp(a.labels.data, b.labels.data, a.labels.total() * 2), 0);
}

TEST_F(SegmentSimulatorTest, ImageEmbeddingsFitTheRoomThatFillsTheView) {
  const SegmentSimulator simulator(apartment_, SegmentConfig{});
  const EmbeddingSpace space;
  RenderedView view = renderAt(0.5);
  for (std::size_t room = 1; room < view.room_pixels.size(); ++room) {
    std::fill(view.room_pixels.begin(), view.room_pixels.end(), 0);
    view.room_pixels[room] = 1000;
    const Embedding image = simulator.segment(view, {}, 1).image_embedding;
    for (const Room& other : apartment_.rooms) {
      const double cosine = computeCosine(image, space.encodeText(other.phrase));
      if (other.id == static_cast<int>(room)) {
        EXPECT_GT(cosine, 0.24);
      } else {
        EXPECT_LT(cosine, 0.235) << other.phrase;
      }
    }
  }
}

}  // namespace
}  // namespace tsg::simulation
