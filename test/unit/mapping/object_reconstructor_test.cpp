// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/object_reconstructor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "synthetic_scene.h"
#include "task_scene_graph/config/config.h"

namespace tsg::mapping {
namespace {

const CameraModel kCamera{320, 240, 262.0, 262.0, 159.5, 119.5};
constexpr std::uint16_t kLabel = 3;

struct SeenTrack {
  Track track;
  std::vector<SegmentedFrame> frames;
};

SeenTrack observe(const std::vector<test::Solid>& scene, const Eigen::Vector3d& center,
                  double distance_m, int views) {
  SeenTrack seen;
  seen.track.id = {5};
  seen.track.embedding = Embedding::Ones(4);
  for (int i = 0; i < views; ++i) {
    const double angle = 2.0 * M_PI * i / views;
    const Eigen::Vector3d eye =
        center + distance_m * Eigen::Vector3d(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.6);
    auto rendering = test::render(scene, kCamera, test::lookAt(eye, center));
    const Stamp stamp{1000 + i};
    rendering.frame.stamp = stamp;
    auto segmentation = std::make_shared<Segmentation>();
    segmentation->stamp = stamp;
    segmentation->labels = rendering.labels;
    seen.track.observations.push_back({stamp, kLabel});
    seen.frames.push_back({std::make_shared<RgbdFrame>(rendering.frame), segmentation});
  }
  seen.track.first_seen = {1000};
  seen.track.last_seen = {1000 + views - 1};
  return seen;
}

const Aabb kCrate = makeAabb({0.4, -0.2, 0.7}, {0.7, 0.3, 0.95});

/// A crate on a table on a floor.
std::vector<test::Solid> makeTable() {
  return {test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
          test::makeBox(makeAabb({-1, -1, 0.65}, {1.5, 1, 0.7}), {120, 80, 30}, 1),
          test::makeBox(kCrate, {200, 40, 20}, kLabel)};
}

TEST(ObjectReconstructor, BoxAndColorsOfAnObjectOnATableAreRight) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 12);
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {42});
  ASSERT_EQ(result.status, ReconstructionStatus::kReconstructed);
  const auto& primitive = *result.primitive;
  EXPECT_GE(computeIoU(primitive.box, kCrate), 0.85)
      << primitive.box.min().transpose() << " / " << primitive.box.max().transpose();
  EXPECT_EQ(primitive.id, PrimitiveId{42});
  EXPECT_EQ(primitive.track, TrackId{5});
  EXPECT_EQ(primitive.num_observations, 12U);
  EXPECT_EQ(primitive.embedding, seen.track.embedding);
  EXPECT_EQ(primitive.last_seen, seen.track.last_seen);
  int red = 0;
  double squares = 0.0;
  for (std::size_t i = 0; i < primitive.mesh.vertices.size(); ++i) {
    const auto p = primitive.mesh.vertices[i].cast<double>();
    squares += std::pow(test::makeBox(kCrate, {}).distance_m(p), 2);
    red += primitive.mesh.colors[i][0] > 180 ? 1 : 0;
  }
  const auto count = static_cast<double>(primitive.mesh.vertices.size());
  EXPECT_LE(std::sqrt(squares / count), 0.5 * 0.03 * 0.5);  // half a voxel
  EXPECT_GE(red, 0.9 * count);
}

/// A crate that is turned about the vertical, made of a box in its own frame.
test::Solid makeTurnedCrate(const OrientedBox& crate, std::uint16_t label) {
  Pose T_world_box = Pose::Identity();
  T_world_box.linear() = crate.rotation();
  T_world_box.translation() = crate.center_m;
  const Pose T_box_world = T_world_box.inverse();
  const Eigen::Vector3d half_m = 0.5 * crate.size_m;
  const auto aligned = test::makeBox(makeAabb(-half_m, half_m), {200, 40, 20}, label);
  test::Solid turned = aligned;
  turned.hit = [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    return aligned.hit(T_box_world * origin, T_box_world.linear() * direction);
  };
  turned.distance_m = [=](const Eigen::Vector3d& p) { return aligned.distance_m(T_box_world * p); };
  return turned;
}

TEST(ObjectReconstructor, OrientedBoxIsTheTurnedObjectsBox) {
  for (const double yaw_rad : {0.3, -0.6}) {
    const OrientedBox crate{{0.4, 0.1, 0.8}, {0.6, 0.2, 0.2}, yaw_rad};
    const std::vector<test::Solid> scene{test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
                                         makeTurnedCrate(crate, kLabel)};
    const auto seen = observe(scene, crate.center_m, 1.2, 12);
    const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
    ASSERT_TRUE(result.primitive);
    const OrientedBox& box = result.primitive->oriented_box;
    EXPECT_NEAR(box.yaw_rad, yaw_rad, 0.06);
    EXPECT_TRUE(box.center_m.isApprox(crate.center_m, 0.02));
    EXPECT_TRUE(((box.size_m - crate.size_m).array().abs() < 0.04).all()) << box.size_m.transpose();
    EXPECT_LT(box.volume(), 0.75 * computeVolume(result.primitive->box));
  }
}

TEST(ObjectReconstructor, ThumbnailShowsTheBestView) {
  auto seen = observe(makeTable(), kCrate.center(), 1.2, 6);
  ObjectConfig config;
  config.thumbnail_px = 32;
  const ObjectReconstructor reconstructor(config);
  const auto without = reconstructor.reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(without.primitive);
  EXPECT_TRUE(without.primitive->thumbnail.image.empty());
  seen.track.views.best = seen.track.observations[4];
  const auto with = reconstructor.reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(with.primitive);
  const auto& thumbnail = with.primitive->thumbnail;
  EXPECT_EQ(thumbnail.stamp, seen.track.observations[4].stamp);
  EXPECT_EQ(std::max(thumbnail.image.cols, thumbnail.image.rows), 32);
  const cv::Vec3b middle =
      thumbnail.image.at<cv::Vec3b>(thumbnail.image.rows / 2, thumbnail.image.cols / 2);
  EXPECT_GT(middle[0], 150);  // red, in RGB order
  EXPECT_LT(middle[2], 60);
}

TEST(ObjectReconstructor, FlyingPixelsDoNotWidenTheBox) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 12);
  for (const auto& frame : seen.frames) {  // the left rim of the object mixes with the wall behind
    cv::Mat depth_m = frame.frame->depth.image;
    const cv::Mat& labels = frame.segmentation->labels;
    for (int v = 0; v < labels.rows; ++v) {
      for (int u = 1; u + 1 < labels.cols; ++u) {
        const auto* row = labels.ptr<std::uint16_t>(v);
        if (row[u] != kLabel || row[u - 1] == kLabel) continue;
        auto* z_m = depth_m.ptr<float>(v);
        z_m[u - 1] = 2.0F * z_m[u + 1];
        z_m[u] = 1.5F * z_m[u + 1];
      }
    }
  }
  ObjectConfig config;
  config.depth_filter.max_slope = 14.0;
  const auto filtered = ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1});
  config.depth_filter.reject_flying_pixels = false;
  config.depth_filter.min_support_px = 0;
  const auto raw = ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(filtered.primitive);
  const double iou = computeIoU(filtered.primitive->box, kCrate);
  EXPECT_GE(iou, 0.8);
  EXPECT_GT(iou, raw.primitive ? computeIoU(raw.primitive->box, kCrate) : 0.0);
}

TEST(ObjectReconstructor, BufferAndCollectedFramesGiveTheSameBits) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 8);
  FrameBuffer buffer({});
  for (const auto& frame : seen.frames) buffer.add(frame.frame, frame.segmentation);
  const ObjectReconstructor reconstructor({});
  const auto a = reconstructor.reconstruct(seen.track, buffer, {1});
  const auto b = reconstructor.reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(a.primitive && b.primitive);
  EXPECT_EQ(a.primitive->mesh.vertices, b.primitive->mesh.vertices);
  EXPECT_EQ(a.primitive->mesh.triangles, b.primitive->mesh.triangles);
  EXPECT_EQ(a.primitive->mesh.colors, b.primitive->mesh.colors);
}

TEST(ObjectReconstructor, DoesNotTouchTheFrames) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 5);
  const cv::Mat depth = seen.frames[0].frame->depth.image.clone();
  const cv::Mat color = seen.frames[0].frame->color.image.clone();
  ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  EXPECT_EQ(cv::norm(depth, seen.frames[0].frame->depth.image), 0.0);
  EXPECT_EQ(cv::norm(color, seen.frames[0].frame->color.image), 0.0);
}

TEST(ObjectReconstructor, ManyObservationsAreThinnedOut) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 24);
  ObjectConfig config;
  config.max_frames = 8;
  auto few = seen;
  few.track.observations.clear();
  few.frames.clear();
  for (const std::size_t i : {0U, 3U, 6U, 9U, 13U, 16U, 19U, 23U}) {
    few.track.observations.push_back(seen.track.observations[i]);
    few.frames.push_back(seen.frames[i]);
  }
  const auto thinned = ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1});
  const auto chosen = ObjectReconstructor(config).reconstruct(few.track, few.frames, {1});
  ASSERT_TRUE(thinned.primitive && chosen.primitive);
  EXPECT_EQ(thinned.primitive->mesh.vertices, chosen.primitive->mesh.vertices);
  EXPECT_EQ(thinned.primitive->num_observations, 24U);
}

TEST(ObjectReconstructor, TracksWithTooFewObservationsGiveNothing) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 3);
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  EXPECT_EQ(result.status, ReconstructionStatus::kTooFewObservations);
  EXPECT_EQ(result.primitive, nullptr);
}

TEST(ObjectReconstructor, TracksWhoseFramesAreGoneGiveNothing) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 5);
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, FrameBuffer({}), {1});
  EXPECT_EQ(result.status, ReconstructionStatus::kNoFrames);
}

TEST(ObjectReconstructor, ObjectsWithoutDepthGiveNothing) {
  auto seen = observe(makeTable(), kCrate.center(), 1.2, 5);
  ObjectConfig config;
  config.max_range_m = 0.5;
  EXPECT_EQ(ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1}).status,
            ReconstructionStatus::kNoDepth);
  for (auto& observation : seen.track.observations) observation.segment = 77;
  EXPECT_EQ(ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1}).status,
            ReconstructionStatus::kNoDepth);
}

TEST(ObjectReconstructor, ObjectOfOnePixelIsSmallOrNothing) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 6);
  for (const auto& frame : seen.frames) {
    cv::Mat labels = frame.segmentation->labels;  // shares the pixels
    labels.setTo(0);
    labels.at<std::uint16_t>(120, 160) = kLabel;
  }
  EXPECT_EQ(ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1}).status,
            ReconstructionStatus::kNoDepth);
  ObjectConfig config;
  config.min_pixels = 1;
  const auto result = ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1});
  if (result.primitive) {
    EXPECT_LE(result.primitive->box.sizes().maxCoeff(), 0.3);
  } else {
    EXPECT_EQ(result.status, ReconstructionStatus::kEmptyMesh);
  }
}

TEST(ObjectReconstructor, VolumeLimitsAreEnforced) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 8);
  ObjectConfig config;
  config.max_volume_m3 = 0.02;
  EXPECT_EQ(ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1}).status,
            ReconstructionStatus::kTooLarge);
  config = {};
  config.min_volume_m3 = 0.5;
  EXPECT_EQ(ObjectReconstructor(config).reconstruct(seen.track, seen.frames, {1}).status,
            ReconstructionStatus::kTooSmall);
}

/// The crate hangs in front of a wall 0.8 m behind; every mask spills over by some pixels.
SeenTrack observeWithSpilling(double wall_x_m, int spilled_px) {
  const std::vector<test::Solid> scene{test::makePlane({wall_x_m, 0, 0}, {-1, 0, 0}, {90, 90, 90}),
                                       test::makeBox(kCrate, {200, 40, 20}, kLabel)};
  SeenTrack seen;
  seen.track.id = {5};
  seen.track.embedding = Embedding::Ones(4);
  for (int i = 0; i < 12; ++i) {
    // Nearly the same place: the strip of wall beside the crate is the same in all views.
    const Eigen::Vector3d eye = kCrate.center() + Eigen::Vector3d(-1.5, 0.01 * i, 0.1);
    auto rendering = test::render(scene, kCamera, test::lookAt(eye, kCrate.center()));
    rendering.frame.stamp = Stamp{1000 + i};
    auto segmentation = std::make_shared<Segmentation>();
    segmentation->stamp = rendering.frame.stamp;
    const cv::Mat disk = cv::getStructuringElement(
        cv::MORPH_ELLIPSE, cv::Size(2 * spilled_px + 1, 2 * spilled_px + 1));
    cv::dilate(rendering.labels, segmentation->labels, disk);
    seen.track.observations.push_back({rendering.frame.stamp, kLabel});
    seen.frames.push_back({std::make_shared<RgbdFrame>(rendering.frame), segmentation});
  }
  return seen;
}

TEST(ObjectReconstructor, StripOfWallBehindASpillingMaskIsNotOfTheObject) {
  const auto seen = observeWithSpilling(1.6, 4);
  ObjectConfig all;
  all.min_part_share = 0.0;
  const auto with_wall = ObjectReconstructor(all).reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(with_wall.primitive);
  EXPECT_GT(with_wall.primitive->box.max().x(), 1.5);
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(result.primitive);
  EXPECT_LT(result.primitive->box.max().x(), kCrate.max().x() + 0.05);
  EXPECT_GT(result.primitive->box.sizes().y(), 0.9 * kCrate.sizes().y());
  EXPECT_LT(result.primitive->box.sizes().y(), 1.1 * kCrate.sizes().y());
}

TEST(ObjectReconstructor, MaskThatNoSampledPixelMeetsIsKeptWhole) {
  // A near, wide wall is looked at in every fourth pixel; this mask's columns lie in between.
  const std::vector<test::Solid> wall{test::makePlane({1.0, 0, 0}, {-1, 0, 0}, {90, 90, 90})};
  auto rendering = test::render(wall, kCamera, test::lookAt({0, 0, 1}, {1, 0, 1}));
  SeenTrack seen;
  seen.track.id = {5};
  seen.track.embedding = Embedding::Ones(4);
  auto segmentation = std::make_shared<Segmentation>();
  segmentation->labels = cv::Mat::zeros(kCamera.height_px, kCamera.width_px, CV_16UC1);
  // The box of the mask begins at column 0: sampled are columns 0, 4, ..., and only row 1 has 0.
  for (int v = 1; v < segmentation->labels.rows; v += 4) {
    for (int u = 1; u < segmentation->labels.cols; u += 4) {
      segmentation->labels.at<std::uint16_t>(v, u) = kLabel;
    }
  }
  segmentation->labels.at<std::uint16_t>(0, 1) = kLabel;
  segmentation->labels.at<std::uint16_t>(1, 0) = kLabel;
  for (int i = 0; i < 12; ++i) {
    rendering.frame.stamp = segmentation->stamp = Stamp{1000 + i};
    seen.track.observations.push_back({rendering.frame.stamp, kLabel});
    seen.frames.push_back({std::make_shared<RgbdFrame>(rendering.frame),
                           std::make_shared<Segmentation>(*segmentation)});
  }
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  EXPECT_TRUE(result.primitive) << mapping::toString(result.status);
}

TEST(ObjectReconstructor, MasksOfOtherObjectsStayAsTheyWere) {
  const auto seen = observeWithSpilling(1.6, 4);
  const cv::Mat before = seen.frames[0].segmentation->labels.clone();
  ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  EXPECT_EQ(cv::countNonZero(before != seen.frames[0].segmentation->labels), 0);
}

TEST(ObjectReconstructor, TwoPartsOfLikeSizeAreBothKept) {
  // Two legs half a metre apart under one label, as a table whose top no view shows.
  const Aabb left = makeAabb({0.4, -0.3, 0.0}, {0.5, -0.2, 0.7});
  const Aabb right = makeAabb({0.4, 0.2, 0.0}, {0.5, 0.3, 0.7});
  const std::vector<test::Solid> scene{test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
                                       test::makeBox(left, {200, 40, 20}, kLabel),
                                       test::makeBox(right, {200, 40, 20}, kLabel)};
  const auto seen = observe(scene, {0.45, 0.0, 0.35}, 1.5, 12);
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(result.primitive);
  EXPECT_NEAR(result.primitive->box.sizes().y(), 0.6, 0.06);
}

TEST(ObjectReconstructor, SmallPartTouchingTheLargeOneIsKept) {
  const Aabb handle = makeAabb({0.7, 0.0, 0.8}, {0.76, 0.04, 0.84});
  auto scene = makeTable();
  scene.push_back(test::makeBox(handle, {200, 40, 20}, kLabel));
  const auto seen = observe(scene, kCrate.center(), 1.2, 12);
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  ASSERT_TRUE(result.primitive);
  EXPECT_GT(result.primitive->box.max().x(), 0.74);
}

TEST(ObjectReconstructor, WrongLabelsInAMinorityOfFramesAreOutvoted) {
  const auto seen = observe(makeTable(), kCrate.center(), 1.2, 12);
  for (std::size_t i = 0; i < 3; ++i) {
    cv::Mat labels = seen.frames[4 * i].segmentation->labels;
    cv::Mat grown;  // the mask spills over the table
    cv::dilate(labels == kLabel, grown, cv::Mat::ones(21, 21, CV_8U));
    labels.setTo(kLabel, grown);
  }
  const auto result = ObjectReconstructor({}).reconstruct(seen.track, seen.frames, {1});
  ASSERT_EQ(result.status, ReconstructionStatus::kReconstructed);
  EXPECT_GE(computeIoU(result.primitive->box, kCrate), 0.6);
}

TEST(ObjectReconstructor, BadInputIsRejected) {
  auto seen = observe(makeTable(), kCrate.center(), 1.2, 5);
  const ObjectReconstructor reconstructor({});
  auto frames = seen.frames;
  frames.pop_back();
  EXPECT_THROW(reconstructor.reconstruct(seen.track, frames, {1}), std::invalid_argument);
  auto small = std::make_shared<Segmentation>();
  small->labels = cv::Mat::zeros(12, 10, CV_16UC1);
  seen.frames[0].segmentation = small;
  EXPECT_THROW(reconstructor.reconstruct(seen.track, seen.frames, {1}), std::invalid_argument);
  ObjectConfig config;
  config.min_range_m = config.max_range_m;
  EXPECT_THROW(ObjectReconstructor bad(config), config::ConfigError);
}

}  // namespace
}  // namespace tsg::mapping
