// SPDX-License-Identifier: BSD-3-Clause
#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>
#include <octomap/OcTree.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/GetMesh.h>
#include <task_scene_graph/PlanPath.h>
#include <visualization_msgs/MarkerArray.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/ros/client.h"
#include "task_scene_graph/ros/occupancy_conversions.h"

namespace tsg::test {
namespace {

constexpr int kNumFrames = 80;

/// Vertices of a mesh file and the object that each names.
std::vector<std::pair<Eigen::Vector3f, std::int32_t>> readPlyVertices(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::size_t count = 0;
  for (std::string line; line != "end_header" && std::getline(file, line);) {
    if (line.rfind("element vertex ", 0) == 0) count = std::stoul(line.substr(15));
  }
  std::vector<std::pair<Eigen::Vector3f, std::int32_t>> vertices(count);
  for (auto& [position, id] : vertices) {
    std::array<char, 19> bytes{};  // x y z, red green blue, object_id
    file.read(bytes.data(), bytes.size());
    std::memcpy(position.data(), bytes.data(), 12);
    std::memcpy(&id, bytes.data() + 15, 4);
  }
  return vertices;
}

/// The whole chain runs once in this process; the tests look at what came of it.
class Chain : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    state_ = new State;
    const std::string folder = state_->folder.path().string();
    writeTaskFile(folder + "/objects.yaml", {"red box", "blue box"}, 0);
    writeTaskFile(folder + "/places.yaml", {"room"}, 2);
    ros::param::set("/scene_graph/object_tasks", folder + "/objects.yaml");
    ros::param::set("/scene_graph/place_tasks", folder + "/places.yaml");
    ros::param::set("/scene_graph/output", folder + "/map");
    ros::param::set("/mesh_fusion/output", folder + "/map");
    ASSERT_TRUE(load(state_->loader, "tracker", "Tracker"));
    ASSERT_TRUE(load(state_->loader, "mesh_fusion", "MeshFusion"));
    ASSERT_TRUE(load(state_->loader, "scene_graph", "SceneGraph"));
    ASSERT_TRUE(state_->robot.waitForSubscribers(1));
    ASSERT_TRUE(state_->robot.waitForSegmentationSubscribers(1));
    ASSERT_TRUE(state_->tracks.waitForPublisher());
    state_->grasp_before = findGraspPixel(makeUnit(0));
    ASSERT_NO_FATAL_FAILURE(play());
    ASSERT_TRUE(callTrigger("/scene_graph/save_map", state_->save));
  }
  static void TearDownTestSuite() {
    delete state_;
    state_ = nullptr;
  }

  /// One frame after the other, each once the tracker has dealt with the one before.
  static void play() {
    for (int i = 0; i < kNumFrames; ++i) {
      const RobotMessages messages = makeMessages(i);
      state_->robot.publish(messages);
      state_->last = messages;
      ASSERT_TRUE(waitForTracks(state_->tracks, messages)) << "no tracks for frame " << i;
    }
  }
  static bool callTrigger(const std::string& service, std_srvs::Trigger& call) {
    return ros::service::waitForService(service, ros::Duration(30.0)) &&
           ros::service::call(service, call);
  }
  static msg::GraspPixelResponse findGraspPixel(const Embedding& embedding,
                                                float max_age_s = 0.0F) {
    msg::GraspPixel call;
    call.request.embedding = ros_interface::toFloats(embedding);
    call.request.max_age_s = max_age_s;
    EXPECT_TRUE(ros::service::waitForService("/scene_graph/grasp_pixel", ros::Duration(30.0)));
    EXPECT_TRUE(ros::service::call("/scene_graph/grasp_pixel", call));
    return call.response;
  }
  static std::string outputPath(const std::string& name) {
    return (state_->folder.path() / "map" / name).string();
  }
  static msg::SceneGraphConstPtr newestGraph() { return state_->graphs.messages().back(); }

  struct State {
    TemporaryFolder folder;
    Robot robot;
    Recorder<msg::Tracks> tracks{"tracks"};
    Recorder<msg::SceneGraph> graphs{"scene_graph"};
    Recorder<visualization_msgs::MarkerArray> markers{"scene_graph_markers"};
    Recorder<ros_interface::OctomapMessage> octomaps{"octomap"};
    Recorder<msg::OctomapChanges> octomap_changes{"octomap_changes"};
    Recorder<nav_msgs::OccupancyGrid> floors{"floor_0/map"};
    Recorder<nav_msgs::Path> paths{"path"};
    Recorder<diagnostic_msgs::DiagnosticArray> diagnostics{"/diagnostics"};
    nodelet::Loader loader{false};
    RobotMessages last;
    std_srvs::Trigger save;
    msg::GraspPixelResponse grasp_before;  ///< of any frame
  };
  static State* state_;
};
Chain::State* Chain::state_ = nullptr;

TEST_F(Chain, SaveMapAnswersWithTheFolderThatHoldsTheMap) {
  EXPECT_TRUE(state_->save.response.success) << state_->save.response.message;
  const std::string& message = state_->save.response.message;
  EXPECT_EQ(message.substr(0, message.find('\n')), (state_->folder.path() / "map").string());
  const auto summary = nlohmann::json::parse(std::ifstream(outputPath("summary.json")));
  EXPECT_NE(summary.dump().find("red box"), std::string::npos);
  const auto spark = nlohmann::json::parse(std::ifstream(outputPath("scene_graph.json")));
  EXPECT_GT(spark.at("nodes").size(), 2U);
  std::ifstream ply(outputPath("mesh.ply"), std::ios::binary);
  std::string first_line;
  std::getline(ply, first_line);
  EXPECT_EQ(first_line, "ply");
}

TEST_F(Chain, SaveMapWritesTheSettingsOfAllStages) {
  const YAML::Node settings = YAML::LoadFile(outputPath("settings.yaml"));
  EXPECT_EQ(settings["tracker"]["window_s"].as<double>(), 1.0);
  EXPECT_TRUE(settings["mesh_fusion"]["occupancy"]["enabled"].as<bool>());
  EXPECT_EQ(settings["input"]["tf_timeout_s"].as<double>(), 5.0);
  EXPECT_EQ(settings["scene_graph"]["object_tasks"].as<std::string>(),
            (state_->folder.path() / "objects.yaml").string());
  EXPECT_EQ(settings["made_with"]["program"].as<std::string>(), "live, /scene_graph");
}

TEST_F(Chain, VerticesOfTheMeshNameTheObjectsOfTheGraph) {
  std::map<std::int32_t, Aabb> vertices_of;
  for (const auto& [position, id] : readPlyVertices(outputPath("mesh.ply"))) {
    vertices_of[id].extend(position.cast<double>());
  }
  const auto graph = newestGraph();
  ASSERT_EQ(vertices_of.size(), 1U + graph->objects.size());
  for (const auto& object : graph->objects) {
    const Aabb box = ros_interface::toAabb(object.box);
    const Aabb labelled = vertices_of[static_cast<std::int32_t>(object.id)];
    EXPECT_GT(computeIoU(labelled, box), 0.7) << object.task;
    EXPECT_TRUE((labelled.min().array() > box.min().array() - 0.1).all()) << object.task;
    EXPECT_TRUE((labelled.max().array() < box.max().array() + 0.1).all()) << object.task;
  }
}

TEST_F(Chain, TheMeshIsGivenAsPointsForPclThatNameTheirObjects) {
  msg::GetMesh call;
  ASSERT_TRUE(ros::service::call("/scene_graph/get_mesh", call));
  ASSERT_TRUE(call.response.success) << call.response.message;
  const sensor_msgs::PointCloud2& points = call.response.points;
  EXPECT_EQ(points.header.frame_id, "world");
  ASSERT_EQ(points.fields.back().name, "label");
  const auto vertices = readPlyVertices(outputPath("mesh.ply"));
  ASSERT_EQ(points.width, vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::uint8_t* point = points.data.data() + i * points.point_step;
    Eigen::Vector3f position;
    std::uint32_t label = 0;
    std::memcpy(position.data(), point, 12);
    std::memcpy(&label, point + points.fields.back().offset, 4);
    ASSERT_EQ(position, vertices[i].first) << i;
    ASSERT_EQ(label, static_cast<std::uint32_t>(vertices[i].second)) << i;
  }
}

TEST_F(Chain, OccupancyChangesAddUpToTheOctreeThatIsPublishedAndWritten) {
  std::map<std::array<int, 3>, bool> voxels;
  for (const auto& changes : state_->octomap_changes.messages()) {
    for (std::size_t i = 0; i < changes->occupied.size(); ++i) {
      const auto* index = &changes->indices[3 * i];
      voxels[{index[0], index[1], index[2]}] = changes->occupied[i] != 0;
    }
  }
  ASSERT_GT(voxels.size(), 1000U);
  const auto message = state_->octomaps.messages().back();
  octomap::OcTree published(message->resolution);
  std::istringstream stream(std::string(message->data.begin(), message->data.end()));
  published.readBinaryData(stream);
  octomap::OcTree written(outputPath("map.bt"));
  const std::unique_ptr<octomap::AbstractOcTree> full(
      octomap::AbstractOcTree::read(outputPath("map.ot")));
  ASSERT_NE(full, nullptr);
  EXPECT_EQ(full->getTreeType(), "OcTree");
  const auto* probabilities = dynamic_cast<const octomap::OcTree*>(full.get());
  const std::vector<const octomap::OcTree*> trees{&published, &written, probabilities};
  for (const auto* tree : trees) {
    std::size_t num_wrong = 0;
    for (const auto& [index, is_occupied] : voxels) {
      const auto* node = tree->search((index[0] + 0.5) * message->resolution,
                                      (index[1] + 0.5) * message->resolution,
                                      (index[2] + 0.5) * message->resolution);
      num_wrong += node == nullptr || tree->isNodeOccupied(node) != is_occupied ? 1 : 0;
    }
    EXPECT_EQ(num_wrong, 0U);
  }
}

TEST_F(Chain, BothBoxesAreObjectsWhereTheyStand) {
  const auto graph = newestGraph();
  ASSERT_EQ(graph->objects.size(), 2U);
  std::map<std::string, Aabb> boxes;
  for (const auto& object : graph->objects) {
    boxes[object.task] = ros_interface::toAabb(object.box);
    EXPECT_NEAR(object.score, 1.0F, 1e-4F);
  }
  ASSERT_EQ(boxes.count("red box"), 1U);
  ASSERT_EQ(boxes.count("blue box"), 1U);
  // Only the sides that face the robot were seen; one voxel of slack.
  const Aabb red = makeAabb({1.2, 0.5, 0.0}, {1.8, 1.1, 0.7});
  const Aabb blue = makeAabb({1.2, -1.1, 0.0}, {1.8, -0.5, 0.7});
  EXPECT_GT(computeIoU(boxes["red box"], red), 0.5) << boxes["red box"].min().transpose();
  EXPECT_GT(computeIoU(boxes["blue box"], blue), 0.5) << boxes["blue box"].min().transpose();
}

TEST_F(Chain, PlacesAndARegionComeOut) {
  const auto graph = newestGraph();
  EXPECT_GT(graph->places.size(), 0U);
  ASSERT_GT(graph->regions.size(), 0U);
  EXPECT_EQ(graph->regions[0].task, "room");
  for (const auto& place : graph->places) {
    EXPECT_LT(std::abs(place.position.x), 3.0);
    EXPECT_LT(std::abs(place.position.y), 3.0);
  }
}

std::string describe(const std::map<std::string, std::string>& lines) {
  std::string text;
  for (const auto& [key, value] : lines) text += "\n  " + key + ": " + value;
  return text;
}

TEST_F(Chain, EveryStageReadsThePixelsOfTheMessageItself) {
  std::ostringstream expected;
  expected << static_cast<const void*>(state_->last.depth->data.data());
  for (const std::string stage : {"tracker", "mesh_fusion"}) {
    ASSERT_TRUE(waitUntil([&] {
      auto lines = findDiagnostics(state_->diagnostics, stage);
      return lines["pixels of the last image"] == expected.str() &&
             lines["processed"] == std::to_string(kNumFrames);
    })) << stage
        << ": " << describe(findDiagnostics(state_->diagnostics, stage))
        << ", published: " << expected.str();
    auto lines = findDiagnostics(state_->diagnostics, stage);
    EXPECT_EQ(lines["images shared"], std::to_string(2 * kNumFrames));
    EXPECT_EQ(lines["images copied"], "0");
    EXPECT_EQ(lines["processed"], std::to_string(kNumFrames));
  }
}

std::set<std::string> namespacesOf(const visualization_msgs::MarkerArray& array, int action) {
  std::set<std::string> names;
  for (const auto& marker : array.markers) {
    if (marker.action == action) names.insert(marker.ns);
  }
  return names;
}

bool reconfigure(const std::string& name, double value) {
  dynamic_reconfigure::Reconfigure call;
  call.request.config.doubles.resize(1);
  call.request.config.doubles[0].name = name;
  call.request.config.doubles[0].value = value;
  return ros::service::call("/scene_graph/set_parameters", call);
}

TEST_F(Chain, AlphaReclustersAtOnceAndStaleMarkersAreDeleted) {
  ASSERT_TRUE(reconfigure("min_object_score", 1.0));  // cosines of floats stay a little below
  ASSERT_TRUE(reconfigure("object_alpha", 1.0));
  ASSERT_TRUE(waitUntil([] { return newestGraph()->objects.empty(); }));
  ASSERT_TRUE(state_->markers.waitFor([](const visualization_msgs::MarkerArray& array) {
    return namespacesOf(array, visualization_msgs::Marker::DELETE).count("object_boxes") > 0;
  }));
  ASSERT_TRUE(reconfigure("object_alpha", 0.23));
  ASSERT_TRUE(reconfigure("min_object_score", -1.0));
  EXPECT_TRUE(waitUntil([] { return newestGraph()->objects.size() == 2; }));
}

TEST_F(Chain, MarkersHaveANamespaceForEachLayer) {
  std::set<std::string> names;
  for (const auto& array : state_->markers.messages()) {
    names.merge(namespacesOf(*array, visualization_msgs::Marker::ADD));
  }
  for (const auto* name : {"object_boxes", "object_nodes", "object_labels", "object_edges",
                           "places", "regions", "region_labels", "region_place_edges"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
}

/// What a path must not come near: the boxes and the walls.
double computeRoomClearance(const geometry_msgs::Point& p) {
  double clearance_m = 3.0 - std::max(std::abs(p.x), std::abs(p.y));
  for (const double y : {0.8, -0.8}) {
    const double dx = std::max(0.0, std::abs(p.x - 1.5) - 0.3);
    const double dy = std::max(0.0, std::abs(p.y - y) - 0.3);
    clearance_m = std::min(clearance_m, std::hypot(dx, dy));
  }
  return clearance_m;
}

msg::PlanPathResponse planPath(const msg::PlanPathRequest& request) {
  msg::PlanPath call;
  call.request = request;
  EXPECT_TRUE(ros::service::waitForService("plan_path", ros::Duration(30.0)));
  EXPECT_TRUE(ros::service::call("plan_path", call));
  return call.response;
}

TEST_F(Chain, APathLeadsFromTheCameraToAnObjectAndLooksAtIt) {
  msg::PlanPathRequest request;
  request.goal_kind = msg::PlanPathRequest::OBJECT;
  request.name = "red box";
  const auto response = planPath(request);
  ASSERT_TRUE(response.success) << response.message;
  const auto& poses = response.path.poses;
  ASSERT_GT(poses.size(), 5U);
  EXPECT_EQ(response.path.header.frame_id, "world");
  EXPECT_NEAR(poses.front().pose.position.x, 0.0, 0.1);
  EXPECT_NEAR(poses.front().pose.position.y, 1.8, 0.1);
  for (const auto& pose : poses) {
    // A voxel and a half, as places are.
    EXPECT_GE(computeRoomClearance(pose.pose.position), 0.25 - 0.15);
    EXPECT_NEAR(pose.pose.position.z, 0.0, 0.1);
  }
  const auto& end = poses.back().pose;
  const double yaw_rad = 2.0 * std::atan2(end.orientation.z, end.orientation.w);
  EXPECT_NEAR(yaw_rad, std::atan2(0.8 - end.position.y, 1.5 - end.position.x), 0.15);
  EXPECT_TRUE(state_->paths.waitFor(
      [&](const nav_msgs::Path& path) { return path.poses.size() == poses.size(); }));
  request.name.clear();
  request.id = response.goal_id;
  EXPECT_NEAR(planPath(request).length_m, response.length_m, 1e-9);
}

TEST_F(Chain, AClientFindsAThingAndAPathToIt) {
  const SceneGraphClient scene("/scene_graph", 30.0);
  msg::AskRequest question;
  question.embedding = ros_interface::toFloats(makeUnit(1));
  const auto answers = scene.ask(question);
  ASSERT_FALSE(answers.objects.empty());
  EXPECT_EQ(answers.objects.front().task, "blue box");
  const auto path = scene.pathTo(answers.objects.front());
  ASSERT_GT(path.path.poses.size(), 5U);
  const auto by_id = scene.pathTo(msg::PlanPathRequest::OBJECT, answers.objects.front().id);
  EXPECT_NEAR(path.length_m, by_id.length_m, 1e-9);
  EXPECT_FALSE(scene.pathTo(answers.regions.front()).path.poses.empty());
  EXPECT_EQ(scene.tasks().object_tasks.size(), 2U);
  EXPECT_NE(scene.explain(msg::ExplainRequest::OBJECT, answers.objects.front().id)
                .find("serves 'blue box'"),
            std::string::npos);
}

TEST_F(Chain, WhatAClientCannotHaveIsAnError) {
  const SceneGraphClient scene("/scene_graph", 30.0);
  const auto explain = [](const std::function<void()>& call) {
    try {
      call();
    } catch (const SceneGraphError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(explain([&] { scene.find("mug"); }).find("words need a text encoder"),
            std::string::npos);
  EXPECT_NE(explain([&] { SceneGraphClient("/nobody", 0.1).find("mug"); }).find("/nobody/ask"),
            std::string::npos);
  msg::PlanPathRequest request;
  request.goal_kind = msg::PlanPathRequest::BOX;
  EXPECT_NE(explain([&] { scene.planPath(request); }).find("expected the size of a thing"),
            std::string::npos);
  request.box.size.x = request.box.size.y = request.box.size.z = std::nan("");
  EXPECT_NE(explain([&] { scene.planPath(request); }).find("expected the size of a thing"),
            std::string::npos);
}

TEST_F(Chain, WhatCannotBePlannedSaysWhy) {
  msg::PlanPathRequest request;
  request.goal_kind = msg::PlanPathRequest::OBJECT;
  request.id = 999;
  auto response = planPath(request);
  EXPECT_FALSE(response.success);
  EXPECT_NE(response.message.find("no object has the id 999"), std::string::npos)
      << response.message;
  EXPECT_TRUE(response.path.poses.empty());
  request.id = 0;
  request.name = "piano";
  response = planPath(request);
  EXPECT_NE(response.message.find("no object is named 'piano'"), std::string::npos)
      << response.message;
  EXPECT_NE(response.message.find("red box"), std::string::npos) << response.message;
  request.goal_kind = msg::PlanPathRequest::POINT;
  request.point.x = 30.0;
  response = planPath(request);
  EXPECT_NE(response.message.find("outside the observed floor"), std::string::npos)
      << response.message;
}

TEST_F(Chain, ARegionAndAPlaceCanBeGoneTo) {
  msg::PlanPathRequest request;
  request.goal_kind = msg::PlanPathRequest::REGION;
  request.name = "room";
  const auto region = planPath(request);
  EXPECT_TRUE(region.success) << region.message;
  request.goal_kind = msg::PlanPathRequest::PLACE;
  request.id = newestGraph()->places.front().id;
  request.has_start = 1;
  request.start.x = -1.6;
  const auto place = planPath(request);
  EXPECT_TRUE(place.success) << place.message;
  EXPECT_GE(place.least_clearance_m, 0.25 - 0.01);
}

TEST_F(Chain, TheFloorIsAnOccupancyGridThatHoldsTheRoom) {
  ASSERT_TRUE(state_->floors.waitFor([](const nav_msgs::OccupancyGrid&) { return true; }));
  const auto grid = state_->floors.messages().back();
  EXPECT_EQ(grid->header.frame_id, "world");
  ASSERT_EQ(grid->data.size(), grid->info.width * grid->info.height);
  const auto at = [&](double x, double y) {
    const auto column = static_cast<std::size_t>((x - grid->info.origin.position.x) /
                                                 static_cast<double>(grid->info.resolution));
    const auto row = static_cast<std::size_t>((y - grid->info.origin.position.y) /
                                              static_cast<double>(grid->info.resolution));
    return static_cast<int>(grid->data.at(column + grid->info.width * row));
  };
  EXPECT_EQ(at(0.0, 0.0), 0);
  EXPECT_EQ(at(1.25, 0.8), 100);
  EXPECT_EQ(at(-2.0, 0.5), 0);
}

TEST_F(Chain, RepeatedStampIsDroppedAndCounted) {
  state_->robot.publish(state_->last);
  EXPECT_TRUE(waitUntil([] {
    return findDiagnostics(state_->diagnostics, "tracker")["dropped: repeated stamp"] == "1";
  }));
}

/// Last: it sets time back. The first frame finds tf cleared and is lost.
TEST_F(Chain, AGraspPixelLiesOnTheBoxThatIsAskedFor) {
  EXPECT_FALSE(state_->grasp_before.success);
  EXPECT_NE(state_->grasp_before.message.find("nothing has been segmented yet"), std::string::npos)
      << state_->grasp_before.message;
  const RobotMessages messages = makeMessages(20, 200.0);  // looks at the boxes
  state_->robot.publish(messages);
  ASSERT_TRUE(waitForTracks(state_->tracks, messages));
  msg::GraspPixelResponse grasp;
  ASSERT_TRUE(waitUntil([&] {  // the tracker publishes before it lets be asked
    grasp = findGraspPixel(makeUnit(0), 600.0F);
    return grasp.header.stamp == messages.color->header.stamp;
  })) << grasp.message;
  EXPECT_TRUE(grasp.success);
  EXPECT_TRUE(grasp.is_found);
  EXPECT_NEAR(grasp.score, 1.0F, 1e-5F);
  EXPECT_NEAR(grasp.margin, 1.0F, 1e-5F);
  EXPECT_EQ(grasp.header.frame_id, "world");
  EXPECT_EQ(grasp.camera_frame, "camera_color_optical_frame");
  const Eigen::Vector3d p_world = ros_interface::toVector(grasp.point);
  const Aabb red = makeAabb({1.2, 0.5, 0.0}, {1.8, 1.1, 0.7});
  EXPECT_LT(red.exteriorDistance(p_world), 0.01) << p_world.transpose();
  const Eigen::Vector3d p_camera = ros_interface::toVector(grasp.point_in_camera);
  EXPECT_TRUE((computePose(20) * p_camera).isApprox(p_world, 1e-6));
  EXPECT_NEAR(p_camera.x() / p_camera.z() * 75.0 + 47.5, grasp.u, 1e-3);
  EXPECT_NE(grasp.track, 0U);
}

TEST_F(Chain, AGraspPixelThatCannotBeKnownIsRefused) {
  const auto expectRefused = [](const msg::GraspPixelResponse& response, const std::string& part) {
    EXPECT_FALSE(response.success);
    EXPECT_EQ(response.u, 0U);
    EXPECT_NE(response.message.find(part), std::string::npos) << response.message;
  };
  expectRefused(findGraspPixel(makeUnit(0), 1e-6F), "s old, expected at most 0.0 s");
  expectRefused(findGraspPixel(Embedding::Ones(3), 600.0F), "3 numbers, expected 4");
  msg::GraspPixel words;
  words.request.words = "mug";
  ASSERT_TRUE(ros::service::call("/scene_graph/grasp_pixel", words));
  expectRefused(words.response, "words need a text encoder");
  msg::GraspPixel picture;
  picture.request.image = *makeMessages(0).color;
  ASSERT_TRUE(ros::service::call("/scene_graph/grasp_pixel", picture));
  expectRefused(picture.response, "a picture needs the image encoder of the segmenter");
}

TEST_F(Chain, BagInALoopGivesTracksAgain) {
  Recorder<rosgraph_msgs::Log> log("/rosout");
  ASSERT_TRUE(log.waitForPublisher());
  const std::size_t before = state_->tracks.messages().size();
  state_->robot.publish(makeMessages(0));
  ASSERT_TRUE(waitForLog(log, {"[/tracker]", "stamps jumped back"}));
  ASSERT_TRUE(waitForLog(log, {"[/mesh_fusion]", "stamps jumped back"}));
  for (int i = 1; i < 6; ++i) {
    const RobotMessages messages = makeMessages(i);
    state_->robot.publish(messages);
    ASSERT_TRUE(waitUntil([&] {
      const auto all = state_->tracks.messages();
      return std::any_of(all.begin() + static_cast<std::ptrdiff_t>(before), all.end(),
                         [&](const auto& tracks) {
                           return ros_interface::toStamp(tracks->header.stamp) == messages.stamp;
                         });
    })) << "frame "
        << i;
  }
  EXPECT_FALSE(state_->tracks.messages().back()->live.empty());
}

TEST_F(Chain, SaveMapWritesTheFloorsForMapServer) {
  const YAML::Node floor = YAML::LoadFile(outputPath("floor_0.yaml"));
  EXPECT_EQ(floor["image"].as<std::string>(), "floor_0.pgm");
  EXPECT_EQ(floor["origin"].size(), 3U);
  std::ifstream pgm(outputPath("floor_0.pgm"), std::ios::binary);
  std::string magic;
  std::getline(pgm, magic);
  EXPECT_EQ(magic, "P5");
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "chain_test"); }
