// SPDX-License-Identifier: BSD-3-Clause
// The background stage with real subscribers; frames are given to it without topics.
#include <gtest/gtest.h>
#include <nav_msgs/Path.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <map>
#include <set>
#include <thread>

#include "background_stage.h"
#include "places_stage.h"
#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/mapping/marching_cubes.h"
#include "task_scene_graph/mapping/occupancy_map.h"
#include "task_scene_graph/ros/late_subscribers.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"
#include "task_scene_graph/ros/occupancy_publisher.h"
#include "task_scene_graph/ros/state_publisher.h"

namespace tsg::test {
namespace {

using nodelets::BackgroundStage;
using nodelets::BackgroundStageOptions;
using ros_interface::MeshUpdateReader;

std::chrono::steady_clock::time_point soon() {
  return std::chrono::steady_clock::now() + std::chrono::seconds(60);
}

RgbdFramePtr makeFrame(int index) {
  auto frame = std::make_shared<RgbdFrame>(
      render(makeRoom(), {96, 72, 75.0, 75.0, 47.5, 35.5}, computePose(index)).frame);
  frame->stamp = Stamp::fromSeconds(100.0 + 0.1 * index);
  return frame;
}

BackgroundStageOptions makeOptions() {
  BackgroundStageOptions options;
  options.world_frame = "world";
  options.mesh_period_s = options.octomap_period_s = 0.2;
  options.fusion.places_period_s = 0.2;
  options.fusion.occupancy.enabled = true;
  return options;
}

/// A stage with topics of its own.
struct Fixture {
  explicit Fixture(const std::string& ns, const BackgroundStageOptions& options = makeOptions())
      : handle(ns), stage(handle, options, report) {}
  void addFrames(int first, int last) {
    for (int i = first; i < last; ++i) stage.addFrame(makeFrame(i));
  }
  ros::NodeHandle handle;
  ros_interface::StageReport report{"background"};
  BackgroundStage stage;
};

/// The mesh as somebody has it who was sent these messages.
MeshUpdateReader follow(const Recorder<msg::MeshUpdate>& recorder) {
  MeshUpdateReader reader;
  for (const auto& message : recorder.messages()) {
    EXPECT_NE(reader.apply(*message).status, MeshUpdateReader::Status::kLost);
  }
  return reader;
}

/// Of the whole mesh, in words.
std::string countVertices(const MeshUpdateReader& reader) {
  Mesh all;
  for (const auto& [block, mesh] : reader.blocks()) all.append(*mesh);
  return std::to_string(mapping::weldVertices(all).vertices.size()) + " vertices";
}

std::string countVertices(BackgroundStage& stage) {
  return std::to_string(map::computeMesh(stage.makeMap()).vertices.size()) + " vertices";
}

using Voxels = std::set<std::array<int, 4>>;

/// Index and state of each voxel.
Voxels follow(const Recorder<msg::OctomapChanges>& recorder) {
  std::map<std::array<int, 3>, int> state;
  for (const auto& message : recorder.messages()) {
    if (message->is_complete != 0) state.clear();
    for (std::size_t i = 0; i < message->occupied.size(); ++i) {
      state[{message->indices[3 * i], message->indices[3 * i + 1], message->indices[3 * i + 2]}] =
          message->occupied[i];
    }
  }
  Voxels voxels;
  for (const auto& [index, is_occupied] : state) {
    voxels.insert({index[0], index[1], index[2], is_occupied});
  }
  return voxels;
}

Voxels toVoxels(const mapping::OccupancyMap& map) {
  Voxels voxels;
  for (const auto& voxel : map.voxels()) {
    voxels.insert({voxel.index.x(), voxel.index.y(), voxel.index.z(), voxel.is_occupied ? 1 : 0});
  }
  return voxels;
}

/// What the occupancy map of these frames is.
Voxels computeVoxels(int num_frames) {
  pipeline::BackgroundFusion fusion(makeOptions().fusion);
  mapping::OccupancyMap map(makeOptions().fusion.occupancy);
  for (int i = 0; i < num_frames; ++i) map.integrate(*fusion.filter(*makeFrame(i)));
  return toVoxels(map);
}

/// Has everything sent that the stage has. Subscribers of one process share a connection, so there
/// is one at a time.
void expectAllIsSent(Fixture& fixture, const Voxels& expected, const std::string& vertices) {
  Recorder<msg::MeshUpdate> mesh("late/mesh_blocks");
  Recorder<msg::OctomapChanges> voxels("late/octomap_changes");
  Recorder<visualization_msgs::MarkerArray> markers("late/mesh");
  Recorder<msg::PlaceGraph> places("late/place_graph");
  EXPECT_TRUE(waitUntil([&] { return follow(mesh).hasWholeMesh(); }));
  EXPECT_TRUE(waitUntil([&] { return countVertices(follow(mesh)) == vertices; }));
  EXPECT_TRUE(waitUntil([&] { return follow(voxels) == expected; }));
  EXPECT_TRUE(markers.waitFor([](const auto& message) { return !message.markers.empty(); }));
  EXPECT_TRUE(places.waitFor([](const auto& message) { return !message.places.empty(); }));
  EXPECT_EQ(fixture.report.processed(), 60U);
}

TEST(BackgroundStage, SubscribersWhoComeInTheMiddleOrLateAreSentAllAndNoFrameIsLost) {
  Fixture fixture("late");
  fixture.addFrames(0, 20);
  Recorder<msg::MeshUpdate> mesh("late/mesh_blocks");
  Recorder<msg::OctomapChanges> voxels("late/octomap_changes");
  fixture.addFrames(20, 60);
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  const std::string vertices = countVertices(fixture.stage);
  const Voxels expected = computeVoxels(60);
  ASSERT_GT(expected.size(), 1000U);
  EXPECT_TRUE(waitUntil([&] { return countVertices(follow(mesh)) == vertices; }));
  EXPECT_TRUE(waitUntil([&] { return follow(voxels) == expected; }));
  mesh.stop();
  voxels.stop();
  expectAllIsSent(fixture, expected, vertices);
}

/// A wall, square to the camera, at this distance.
RgbdFrame makeWall(float distance_m) {
  RgbdFrame frame = *makeFrame(0);
  frame.T_world_camera = Pose::Identity();
  frame.depth.image = cv::Mat(72, 96, CV_32FC1, cv::Scalar(distance_m));
  return frame;
}

TEST(OccupancyPublisher, WhatChangesAndChangesBackAroundTheComingOfASubscriberIsRightForIt) {
  ros::NodeHandle handle("flip");
  ros_interface::StageReport report("flip");
  mapping::OccupancyMap map(makeOptions().fusion.occupancy);
  std::mutex mutex;
  ros_interface::LateSubscribers late(report);
  ros_interface::OccupancyPublisher publisher(handle, late, {"world", 1.0}, map, mutex);
  const mapping::GridIndex at_one_metre(0, 0, 10);

  std::unique_lock<std::mutex> lock(mutex);
  ASSERT_TRUE(map.integrate(makeWall(1.05F)));
  ASSERT_EQ(map.atVoxel(at_one_metre), mapping::Occupancy::kOccupied);
  publisher.publish(Stamp::fromSeconds(1.0), true);
  for (int i = 0; i < 5; ++i) map.integrate(makeWall(2.05F));
  ASSERT_EQ(map.atVoxel(at_one_metre), mapping::Occupancy::kFree);
  lock.unlock();

  Recorder<msg::OctomapChanges> voxels("flip/octomap_changes");
  ASSERT_TRUE(waitUntil([&] { return follow(voxels) == toVoxels(map); }));
  lock.lock();
  for (int i = 0; i < 5; ++i) map.integrate(makeWall(1.05F));
  ASSERT_EQ(map.atVoxel(at_one_metre), mapping::Occupancy::kOccupied);
  publisher.publish(Stamp::fromSeconds(2.0), true);
  lock.unlock();
  EXPECT_TRUE(waitUntil([&] { return follow(voxels) == toVoxels(map); }, 10.0));
}

TEST(BackgroundStage, AfterAFlushMeshAndPlacesAreThoseOfTheNewestFrame) {
  Fixture fixture("flush");
  fixture.addFrames(40, 60);
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  EXPECT_EQ(fixture.stage.newestFrame(), makeFrame(59)->stamp);
  EXPECT_GT(fixture.stage.placeSequence(), 0U);
}

TEST(BackgroundStage, ResetClearsAllAndTellsSubscribersAndANewMapFollows) {
  Fixture fixture("reset");
  Recorder<msg::MeshUpdate> mesh("reset/mesh_blocks");
  Recorder<visualization_msgs::MarkerArray> markers("reset/mesh");
  Recorder<msg::OctomapChanges> voxels("reset/octomap_changes");
  Recorder<msg::PlaceGraph> places("reset/place_graph");
  ASSERT_TRUE(mesh.waitForPublisher() && markers.waitForPublisher() && voxels.waitForPublisher() &&
              places.waitForPublisher());
  fixture.addFrames(0, 60);
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  ASSERT_TRUE(waitUntil([&] { return !follow(mesh).blocks().empty(); }));
  ASSERT_TRUE(waitUntil([&] { return !follow(voxels).empty(); }));
  ASSERT_TRUE(places.waitFor([](const auto& message) { return !message.places.empty(); }));

  fixture.stage.reset();
  EXPECT_EQ(fixture.stage.newestFrame(), Stamp{});
  EXPECT_TRUE(waitUntil([&] {
    const auto reader = follow(mesh);
    return reader.hasWholeMesh() && reader.blocks().empty();
  }));
  EXPECT_TRUE(markers.waitFor([](const auto& message) {
    return message.markers[0].action == visualization_msgs::Marker::DELETEALL;
  }));
  EXPECT_TRUE(waitUntil([&] { return follow(voxels).empty(); }));
  EXPECT_TRUE(waitUntil([&] { return places.messages().back()->places.empty(); }));

  fixture.addFrames(0, 3);
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  const std::string vertices = countVertices(fixture.stage);
  EXPECT_TRUE(waitUntil([&] { return countVertices(follow(mesh)) == vertices; }));
  mesh.stop();
  Recorder<msg::MeshUpdate> late("reset/mesh_blocks");
  EXPECT_TRUE(waitUntil([&] { return countVertices(follow(late)) == vertices; }));
  EXPECT_NE(vertices, "0 vertices");
}

/// Whether a frustum is drawn with its tip where the camera of this frame is.
bool showsCamera(const visualization_msgs::MarkerArray& array, const RgbdFrame& frame) {
  return std::any_of(array.markers.begin(), array.markers.end(), [&](const auto& marker) {
    return marker.ns == "camera_frustum" && ros_interface::toVector(marker.points.front())
                                                .isApprox(frame.T_world_camera.translation(), 1e-9);
  });
}

TEST(BackgroundStage, TheCameraAndItsWayAreShownAlsoToThoseWhoComeLateAndForgottenByAReset) {
  Fixture fixture("camera");
  Recorder<visualization_msgs::MarkerArray> live("camera/camera_markers");
  ASSERT_TRUE(live.waitForPublisher());
  fixture.addFrames(0, 1);
  EXPECT_TRUE(live.waitFor([](const auto& array) { return showsCamera(array, *makeFrame(0)); }));
  live.stop();
  Recorder<visualization_msgs::MarkerArray> late("camera/camera_markers");
  EXPECT_TRUE(late.waitFor([](const auto& array) {
    return array.markers.front().action == visualization_msgs::Marker::DELETEALL &&
           showsCamera(array, *makeFrame(0));
  }));
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  fixture.stage.reset();
  EXPECT_TRUE(late.waitFor([](const auto& array) {
    return array.markers.size() == 1 &&
           array.markers.front().action == visualization_msgs::Marker::DELETEALL;
  }));
}

TEST(BackgroundStage, FramesThatWaitWhenItIsResetAreNotOfTheNewMap) {
  Fixture fixture("reset_queue");
  fixture.addFrames(0, 40);
  fixture.stage.reset();
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  EXPECT_EQ(fixture.stage.newestFrame(), Stamp{});
}

TEST(BackgroundStage, ARefusedFrameIsDroppedByReasonAndNotProcessed) {
  Fixture fixture("refused");
  auto blind = std::make_shared<RgbdFrame>(*makeFrame(0));
  blind->depth.image = cv::Mat(72, 96, CV_32FC1, cv::Scalar(0));
  auto far = std::make_shared<RgbdFrame>(*makeFrame(1));
  far->T_world_camera.translation().x() = 2e6;
  for (const auto& frame : {RgbdFramePtr(blind), RgbdFramePtr(far), makeFrame(2)}) {
    fixture.stage.addFrame(frame);
  }
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  EXPECT_EQ(fixture.report.processed(), 1U);
  EXPECT_EQ(fixture.report.dropped("no depth in range"), 1U);
  EXPECT_EQ(fixture.report.dropped("pose farther than 1000 km from the origin"), 1U);
}

TEST(BackgroundStage, FramesBeyondTheBytesOfItsQueueAreDroppedAndCounted) {
  BackgroundStageOptions options = makeOptions();
  options.fusion.occupancy.enabled = false;
  options.fusion.background.tsdf.voxel_size_m = 0.02;
  options.fusion.background.tsdf.truncation_m = 0.2;
  options.max_queue_bytes = 3 * ros_interface::countBytes(*makeFrame(0));
  Fixture fixture("bytes", options);
  std::vector<RgbdFramePtr> frames;
  for (int i = 0; i < 60; ++i) frames.push_back(makeFrame(i));
  for (const auto& frame : frames) fixture.stage.addFrame(frame);
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  const auto dropped = fixture.report.dropped("integration queue full (bytes)");
  EXPECT_GT(dropped, 0U);
  EXPECT_EQ(fixture.report.processed() + dropped, 60U);
}

/// Voxels of two centimetres along every ray.
TEST(BackgroundStage, AnOccupancyMapThatCannotKeepUpDropsItsOwnFramesOnly) {
  BackgroundStageOptions options = makeOptions();
  options.fusion.occupancy.resolution_m = 0.02;
  options.fusion.occupancy.pixel_stride = 1;
  options.queue_size = 1;
  Fixture fixture("occupancy", options);
  for (std::uint64_t i = 0; i < 12; ++i) {
    fixture.stage.addFrame(makeFrame(static_cast<int>(i)));
    ASSERT_TRUE(waitUntil([&] { return fixture.report.processed() == i + 1; }));
  }
  EXPECT_GT(fixture.report.dropped("occupancy: queue full"), 0U);
  EXPECT_EQ(fixture.report.dropped("integration queue full"), 0U);
}

TEST(BackgroundStage, SavingWhileFramesComeLosesNone) {
  Fixture fixture("save");
  const TemporaryFolder folder;
  fixture.addFrames(0, 5);
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  std::thread saver([&] {
    for (int i = 0; i < 5; ++i) {
      map::writeBackgroundPart(folder.path(), fixture.stage.makeMap(), {}, {});
    }
  });
  fixture.addFrames(5, 60);
  saver.join();
  ASSERT_TRUE(fixture.stage.flush({soon()}).empty());
  EXPECT_EQ(fixture.report.processed(), 60U);
  for (const auto* name : {"mesh.ply", "map.bt", "map.ot"}) {
    EXPECT_GT(std::filesystem::file_size(folder.path() / name), 100U) << name;
  }
}

TEST(Background, WhoComesDuringAPublishHasTheNewestPlacesInTheEnd) {
  ros::NodeHandle handle("newest_places");
  ros_interface::StageReport report("places");
  ros_interface::LateSubscribers late(report);
  nodelets::PlacesStage stage(handle, late, {{}, "world", 10, 1 << 20, {}}, report);
  for (int round = 0; round < 50; ++round) {
    std::atomic<std::uint64_t> newest{0};
    stage.clear(Stamp::fromSeconds(100.0 + round));
    const ros::Subscriber subscriber = handle.subscribe<msg::PlaceGraph>(
        "place_graph", 10,
        [&](const msg::PlaceGraphConstPtr& message) { newest = message->sequence; });
    stage.clear(Stamp::fromSeconds(100.5 + round));
    ASSERT_TRUE(stage.waitIdle(soon()));
    EXPECT_TRUE(waitUntil([&] { return newest == stage.sequence(); }, 10.0))
        << round << ": " << newest << " of " << stage.sequence();
  }
  late.stop();
}

TEST(StatePublisher, WhoComesDuringAPublishHasTheNewestInTheEnd) {
  ros::NodeHandle handle("newest_state");
  const ros_interface::StatePublisher<nav_msgs::Path> publisher(handle, "path");
  for (std::uint32_t round = 1; round <= 200; ++round) {
    std::atomic<std::uint32_t> newest{0};
    std::thread other([&] {
      nav_msgs::Path path;
      path.header.stamp.sec = round;
      publisher.publish(path);
    });
    const ros::Subscriber subscriber = handle.subscribe<nav_msgs::Path>(
        "path", 10, [&](const nav_msgs::PathConstPtr& path) { newest = path->header.stamp.sec; });
    other.join();
    EXPECT_TRUE(waitUntil([&] { return newest == round; }, 10.0)) << round << ": " << newest;
  }
}

TEST(StatePublisher, WhoComesLateIsSentTheNewestOnlyAndNothingBeforeThereIsAny) {
  ros::NodeHandle handle("late_state");
  const ros_interface::StatePublisher<nav_msgs::Path> publisher(handle, "path");
  Recorder<nav_msgs::Path> early("late_state/path");
  ASSERT_TRUE(waitUntil([&] { return publisher.numSubscribers() == 1; }));
  nav_msgs::Path path;
  for (std::uint32_t i = 1; i <= 3; ++i) {
    path.header.stamp.sec = i;
    publisher.publish(path);
  }
  ASSERT_TRUE(early.waitFor([](const auto& message) { return message.header.stamp.sec == 3; }));
  Recorder<nav_msgs::Path> late("late_state/path");
  ASSERT_TRUE(waitUntil([&] { return !late.messages().empty(); }));
  EXPECT_EQ(late.messages().front()->header.stamp.sec, 3U);
  EXPECT_EQ(early.messages().front()->header.stamp.sec, 1U);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "background_test"); }
