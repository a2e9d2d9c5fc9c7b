// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/object_truth.h"

#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/config/scalar.h"

namespace tsg::evaluation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what); }

// --- Clio's YAML
// ----------------------------------------------------------------------------------

double readNumber(const YAML::Node& node, const char* name) {
  const auto number =
      node.IsScalar() ? config::parseNumber(node.Scalar()) : std::optional<double>();
  if (!number || !std::isfinite(*number)) {
    fail(std::string("has '") + name + "' with " + config::formatNode(node) +
         ", expected a finite number");
  }
  return *number;
}

Eigen::Vector3d readVector(const YAML::Node& box, const char* name) {
  const YAML::Node node = box[name];
  if (!node.IsDefined() || !node.IsSequence() || node.size() != 3) {
    fail(std::string("has '") + name + "' = " +
         (node.IsDefined() ? config::formatNode(node) : "nothing") + ", expected 3 numbers");
  }
  return {readNumber(node[0], name), readNumber(node[1], name), readNumber(node[2], name)};
}

Eigen::Matrix3d readRotation(const YAML::Node& box) {
  const YAML::Node node = box["rotation"];
  if (!node.IsDefined()) return Eigen::Matrix3d::Identity();
  Eigen::Quaterniond rotation;
  if (node.IsMap() && node["w"] && node["x"] && node["y"] && node["z"]) {
    rotation = {readNumber(node["w"], "rotation"), readNumber(node["x"], "rotation"),
                readNumber(node["y"], "rotation"), readNumber(node["z"], "rotation")};
  } else if (node.IsSequence() && node.size() == 4) {
    rotation = {readNumber(node[0], "rotation"), readNumber(node[1], "rotation"),
                readNumber(node[2], "rotation"), readNumber(node[3], "rotation")};
  } else {
    fail("has 'rotation' = " + config::formatNode(node) + ", expected w, x, y and z");
  }
  if (!(rotation.norm() > 1e-6)) {
    fail("has 'rotation' = " + config::formatNode(node) + ", expected a quaternion that is not 0");
  }
  return rotation.normalized().toRotationMatrix();
}

RotatedBox readBox(const YAML::Node& node) {
  if (!node.IsMap()) fail("is " + config::formatNode(node) + ", expected center and extents");
  const RotatedBox box{readVector(node, "center"), readVector(node, "extents"), readRotation(node)};
  if (!(box.size_m.array() >= 0.0).all()) {
    fail("has 'extents' = " + config::formatNode(node["extents"]) + ", expected none below 0");
  }
  return box;
}

TaskTruth readTask(const std::string& task, const YAML::Node& boxes) {
  TaskTruth truth{task, {}};
  if (boxes.IsNull()) return truth;
  if (!boxes.IsSequence()) {
    fail("task '" + task + "' has " + config::formatNode(boxes) + ", expected a list of boxes");
  }
  for (const YAML::Node& node : boxes) {
    try {
      truth.boxes.push_back(readBox(node));
    } catch (const std::runtime_error& e) {
      fail("box " + std::to_string(truth.boxes.size() + 1) + " of task '" + task + "' " + e.what());
    }
  }
  return truth;
}

std::vector<TaskTruth> readYaml(const std::string& path) {
  const YAML::Node whole = config::loadYamlFile(path);
  if (!whole.IsMap()) fail("is no map from tasks to lists of boxes");
  std::vector<TaskTruth> truth;
  std::set<std::string> names;
  for (const auto& entry : whole) {
    const std::string task = config::formatNode(entry.first);
    if (!names.insert(task).second) fail("has task '" + task + "' twice, expected once");
    truth.push_back(readTask(task, entry.second));
  }
  return truth;
}

// --- A rendered house
// -----------------------------------------------------------------------------

json readJson(const fs::path& path) {
  std::ifstream file(path);
  if (!file) fail("'" + path.string() + "' cannot be read");
  try {
    return json::parse(file);
  } catch (const json::exception& e) {
    fail("'" + path.string() + "' is no JSON: " + e.what());
  }
}

Eigen::Vector3d toVector(const json& numbers) {
  const auto values = numbers.get<std::array<double, 3>>();
  return {values[0], values[1], values[2]};
}

std::map<int, RotatedBox> readInstances(const fs::path& path) {
  std::map<int, RotatedBox> boxes;
  for (const json& instance : readJson(path)) {
    const Eigen::Vector3d min = toVector(instance.at("aabb_min"));
    const Eigen::Vector3d max = toVector(instance.at("aabb_max"));
    boxes[instance.at("id").get<int>()] = {(min + max) / 2.0, max - min,
                                           Eigen::Matrix3d::Identity()};
  }
  return boxes;
}

std::vector<TaskTruth> readHouse(const fs::path& folder, TruthExtent extent) {
  const auto boxes = readInstances(folder / "instances.json");
  std::vector<TaskTruth> truth;
  for (const json& task : readJson(folder / "tasks.json")) {
    truth.push_back({task.at("name").get<std::string>(), {}});
    for (const int id : task.at(extent == TruthExtent::kSeen ? "seen" : "instances")) {
      const auto box = boxes.find(id);
      if (box == boxes.end()) {
        fail("task '" + truth.back().task + "' names instance " + std::to_string(id) +
             ", which is not in instances.json");
      }
      truth.back().boxes.push_back(box->second);
    }
  }
  return truth;
}

std::vector<TaskTruth> read(const fs::path& path, TruthExtent extent) {
  if (!fs::is_directory(path)) return readYaml(path.string());
  if (fs::exists(path / "tasks.yaml")) return readYaml((path / "tasks.yaml").string());
  if (fs::exists(path / "tasks.json")) return readHouse(path, extent);
  fail("is a folder with neither tasks.yaml nor tasks.json");
}

}  // namespace

std::vector<TaskTruth> loadObjectTruth(const std::string& path, TruthExtent extent) {
  try {
    return read(path, extent);
  } catch (const std::exception& e) {
    throw std::runtime_error("truth '" + path + "': " + e.what());
  }
}

}  // namespace tsg::evaluation
