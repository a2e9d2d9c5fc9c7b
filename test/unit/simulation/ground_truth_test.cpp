// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/ground_truth.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support.h"

namespace tsg::simulation {
namespace {

class GroundTruth : public ::testing::Test {
 protected:
  void SetUp() override { writeGroundTruth(folder_.path() / "truth", apartment_, tasks_, walk_); }

  nlohmann::json readJson(const std::string& name) const {
    std::ifstream file(folder_.path() / "truth" / name);
    return nlohmann::json::parse(file);
  }

  test::TemporaryFolder folder_;
  Apartment apartment_ = buildApartment({1, 6});
  std::vector<TaskTruth> tasks_ = makeObjectTasks(apartment_);
  std::vector<WalkPose> walk_ = planWalk(apartment_, WalkConfig{});
};

TEST_F(GroundTruth, InstancesKeepTheirBoxes) {
  const nlohmann::json list = readJson("instances.json");
  ASSERT_EQ(list.size(), apartment_.instances.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Instance& instance = apartment_.instances[i];
    EXPECT_EQ(list[i]["id"], instance.id);
    EXPECT_EQ(list[i]["phrase"], instance.phrase);
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      EXPECT_DOUBLE_EQ(list[i]["box_min_m"][at].get<double>(), instance.box.min()[axis]);
      EXPECT_DOUBLE_EQ(list[i]["box_max_m"][at].get<double>(), instance.box.max()[axis]);
    }
  }
}

TEST_F(GroundTruth, RoomsListTheirInstances) {
  const nlohmann::json rooms = readJson("rooms.json")["rooms"];
  ASSERT_EQ(rooms.size(), apartment_.rooms.size());
  std::size_t total = 0;
  for (const auto& room : rooms) {
    total += room["instances"].size();
    for (const int id : room["instances"]) {
      EXPECT_EQ(apartment_.instances.at(static_cast<std::size_t>(id - 1)).room, room["id"]);
    }
  }
  EXPECT_EQ(total, apartment_.instances.size());
}

TEST_F(GroundTruth, OrientedBoxesOfTheTasksHoldTheirInstances) {
  const YAML::Node file = YAML::LoadFile((folder_.path() / "truth" / "tasks.yaml").string());
  ASSERT_EQ(file.size(), tasks_.size());
  std::size_t boxes = 0;
  for (const TaskTruth& task : tasks_) {
    const YAML::Node list = file[task.name];
    ASSERT_EQ(list.size(), task.instances.size()) << task.name;
    for (std::size_t i = 0; i < list.size(); ++i) {
      ++boxes;
      const auto center = list[i]["center"].as<std::vector<double>>();
      const auto extents = list[i]["extents"].as<std::vector<double>>();
      const YAML::Node r = list[i]["rotation"];
      const Eigen::Quaterniond q(r["w"].as<double>(), r["x"].as<double>(), r["y"].as<double>(),
                                 r["z"].as<double>());
      const Instance& instance = apartment_.instances[task.instances[i] - 1U];
      const Eigen::Vector3d middle(center[0], center[1], center[2]);
      EXPECT_LT(instance.box.exteriorDistance(middle), 1e-6);
      for (const Solid& solid : apartment_.solids) {
        if (solid.instance != instance.id) continue;
        const Eigen::Vector3d p = q.conjugate() * (solid.T_world_solid.translation() - middle);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_LE(std::abs(p[axis]), 0.5 * extents[static_cast<std::size_t>(axis)] + 1e-6);
        }
      }
    }
  }
  EXPECT_GT(boxes, 15U);
}

TEST_F(GroundTruth, PosesAreWrittenInOrder) {
  std::ifstream file(folder_.path() / "truth" / "poses.txt");
  std::size_t count = 0;
  for (std::string line; std::getline(file, line); ++count) {
    std::istringstream words(line);
    double stamp_s = 0.0;
    double x = 0.0;
    words >> stamp_s >> x;
    EXPECT_NEAR(stamp_s, walk_.at(count).stamp.seconds(), 1e-9);
    EXPECT_NEAR(x, walk_[count].T_world_camera.translation().x(), 1e-9);
  }
  EXPECT_EQ(count, walk_.size());
}

TEST_F(GroundTruth, TaskFilesCarryUnitEmbeddingsOfTheirTasks) {
  const auto path = folder_.path() / "tasks.yaml";
  writeTaskEmbeddings(path, tasks_);
  const YAML::Node list = YAML::LoadFile(path.string())["tasks"];
  ASSERT_EQ(list.size(), tasks_.size());
  const EmbeddingSpace space;
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(list[i]["name"].as<std::string>(), tasks_[i].name);
    const auto values = list[i]["embedding"].as<std::vector<float>>();
    const Eigen::Map<const Embedding> read(values.data(), static_cast<Eigen::Index>(values.size()));
    EXPECT_LT((read - space.encodeText(tasks_[i].phrases)).norm(), 1e-6F);
  }
}

TEST_F(GroundTruth, SomeTasksHaveNoInstanceAndMostHaveSome) {
  int without = 0;
  for (const TaskTruth& task : tasks_) without += task.instances.empty() ? 1 : 0;
  EXPECT_GE(without, 2);
  EXPECT_LE(without, 8);
  EXPECT_EQ(makePlaceTasks(apartment_).size(), apartment_.rooms.size());
}

}  // namespace
}  // namespace tsg::simulation
