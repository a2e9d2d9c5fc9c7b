// SPDX-License-Identifier: BSD-3-Clause
// The package's own messages, between its stages and out of bags. What a stage takes of them it can
// work with: a scene graph is built of them, and sent and written.
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "fuzzer.h"
#include "message_mutator.h"
#include "records.h"
#include "sample_messages.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/scene_graph_conversions.h"
#include "task_scene_graph/ros/settings_conversions.h"
#include "task_scene_graph/scene_graph/builder.h"
#include "task_scene_graph/scene_graph/files.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace msg = tsg::msg;
namespace ros_interface = tsg::ros_interface;
namespace scene_graph = tsg::scene_graph;

constexpr const char* kTopic = "/chain/topic";

msg::BoundingBox makeBox() {
  msg::BoundingBox box;
  box.pose.position.x = 1.0;
  box.pose.orientation.w = 1.0;
  box.size.x = box.size.y = box.size.z = 0.5;
  return box;
}

msg::Mesh makeMesh() {
  msg::Mesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.colors = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  mesh.triangles = {0, 1, 2};
  return mesh;
}

msg::Segmentation makeSegmentation() {
  msg::Segmentation message;
  message.header = fuzz::makeHeader("camera");
  cv::Mat labels = cv::Mat::zeros(fuzz::kHeight, fuzz::kWidth, CV_16UC1);
  labels.colRange(4, 9).setTo(1);
  labels.colRange(9, 20).setTo(2);
  message.labels = fuzz::makeImage("16UC1", labels);
  message.embedding_size = 3;
  message.embeddings = {1, 0, 0, 0, 1, 0};
  message.confidences = {0.9F, 0.8F};
  message.image_embedding = {0, 0, 1};
  return message;
}

msg::Tracks makeTracks() {
  msg::Tracks message;
  message.header = fuzz::makeHeader("camera");
  message.segment_tracks = {1, 2};
  message.live = {2};
  msg::Track track;
  track.id = 1;
  track.first_seen.fromSec(9.0);
  track.last_seen.fromSec(10.0);
  track.embedding = {1, 0, 0};
  track.observations.resize(2);
  message.finished = {track};
  return message;
}

msg::ObjectPrimitives makePrimitives() {
  msg::ObjectPrimitives message;
  message.header = fuzz::makeHeader("world");
  for (std::uint64_t id = 1; id <= 2; ++id) {
    msg::ObjectPrimitive primitive;
    primitive.id = id;
    primitive.track_id = id;
    primitive.mesh = makeMesh();
    primitive.box = makeBox();
    primitive.oriented_box = makeBox();
    primitive.embedding = {1, 0, 0};
    primitive.first_seen.fromSec(9.0);
    primitive.last_seen.fromSec(10.0);
    primitive.thumbnail = fuzz::makeImage("rgb8", cv::Mat::ones(2, 2, CV_8UC3));
    message.primitives.push_back(primitive);
  }
  return message;
}

msg::PlaceGraph makePlaces() {
  msg::PlaceGraph message;
  message.header = fuzz::makeHeader("world");
  message.places.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    message.places[i].id = i + 1;
    message.places[i].position.x = static_cast<double>(i);
    message.places[i].clearance = 1.0F;
    message.places[i].embedding = {0, 1, 0};
  }
  message.edges.resize(2);
  message.edges[0].a = message.edges[1].a = 1;
  message.edges[0].b = 2;
  message.edges[1].b = 3;
  return message;
}

msg::MeshUpdate makeMeshUpdate() {
  msg::MeshUpdate message;
  message.header = fuzz::makeHeader("world");
  message.block_size = 0.4F;
  message.sequence = 1;
  message.part = 1;
  message.is_last = 1;
  message.changed.resize(1);
  message.changed[0].mesh = makeMesh();
  message.removed = {1, 2, 3};
  return message;
}

msg::SceneGraph makeSceneGraph() {
  msg::SceneGraph message;
  message.header = fuzz::makeHeader("world");
  message.object_tasks = {"read"};
  message.places = makePlaces().places;
  message.place_edges = makePlaces().edges;
  msg::SceneObject object;
  object.id = 1;
  object.box = object.oriented_box = makeBox();
  object.primitives = {1, 2};
  message.objects = {object};
  msg::Region region;
  region.id = 1;
  region.places = {1, 2, 3};
  message.regions = {region};
  return message;
}

std::string make(fuzz::Mutator& mutator) {
  const auto prepare = [&](char type, const auto& message) {
    return fuzz::joinRecords({{type, fuzz::makeMutated(mutator, message)}});
  };
  switch (mutator.pick(6)) {
    case 0:
      return prepare('s', makeSegmentation());
    case 1:
      return prepare('t', makeTracks());
    case 2:
      return prepare('o', makePrimitives());
    case 3:
      return prepare('p', makePlaces());
    case 4:
      return prepare('m', makeMeshUpdate());
    default:
      return prepare('g', makeSceneGraph());
  }
}

scene_graph::SceneGraphBuilder makeBuilder() {
  scene_graph::SceneGraphBuilder builder({});
  scene_graph::TaskList tasks;
  tasks.names = {"read", "rest"};
  tasks.embeddings = (tsg::EmbeddingMatrix(2, 3) << 1, 0, 0, 0, 1, 0).finished();
  builder.setObjectTasks(tasks);
  builder.setPlaceTasks(tasks);
  return builder;
}

/// The graph can be sent, and its file can be read.
void use(scene_graph::SceneGraphBuilder& builder) {
  const auto graph = builder.snapshot();
  ros_interface::toMessage(*graph, "world", true);
  const std::string path = (fuzz::scratchFolder() / "scene_graph.json").string();
  scene_graph::writeSparkDsg(path, *graph, {true, true, true});
  const auto json = nlohmann::json::parse(std::ifstream(path));
  for (const auto& node : json.at("nodes")) {
    for (const auto& value : node.at("attributes").at("position")) {
      if (!value.is_number())
        throw std::logic_error("a position that is no number: " + node.dump());
    }
  }
}

void readPrimitives(const msg::ObjectPrimitives& message) {
  auto builder = makeBuilder();
  builder.addPrimitives(ros_interface::fromMessage(message, kTopic));
  use(builder);
}

void readPlaces(const msg::PlaceGraph& message) {
  auto builder = makeBuilder();
  const auto places = ros_interface::fromMessage(message, kTopic);
  try {
    builder.setPlaces(places);
  } catch (const std::invalid_argument&) {
    return;  // says "place graph: ...", and the nodelet says who sent it
  }
  use(builder);
}

/// Whoever calls these readers says which topic it is.
template <typename Read>
void readNamed(const Read& read_message) {
  try {
    read_message();
  } catch (const ros_interface::InputError& e) {
    throw std::runtime_error(std::string(kTopic) + ": " + e.what());
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(std::string(kTopic) + ": " + e.what());
  }
}

void readOne(char type, const std::string& bytes) {
  if (type == 's') {
    ros_interface::fromMessage(fuzz::fromBytes<msg::Segmentation>(bytes), kTopic);
  } else if (type == 't') {
    ros_interface::fromMessage(*fuzz::fromBytes<msg::Tracks>(bytes));
  } else if (type == 'o') {
    readPrimitives(*fuzz::fromBytes<msg::ObjectPrimitives>(bytes));
  } else if (type == 'p') {
    readPlaces(*fuzz::fromBytes<msg::PlaceGraph>(bytes));
  } else if (type == 'm') {
    const auto update = fuzz::fromBytes<msg::MeshUpdate>(bytes);
    readNamed([&] { ros_interface::MeshUpdateReader().apply(*update); });
  } else {
    const auto graph = fuzz::fromBytes<msg::SceneGraph>(bytes);
    readNamed([&] { ros_interface::fromMessage(*graph); });
  }
}

void readInput(const std::string& input) {
  for (const auto& [type, bytes] : fuzz::splitRecords(input)) readOne(type, bytes);
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, {"messages", kTopic, make, readInput});
}
