// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/world.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <set>

#include "simulation_oracles.h"
#include "support.h"
#include "task_scene_graph/simulation/ground_truth.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/segment_simulator.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

struct WorldCase {
  WorldKind kind;
  int seed;
  std::size_t min_instances;
  int num_floors;
};

std::string nameOf(const ::testing::TestParamInfo<WorldCase>& test) {
  static const std::map<WorldKind, std::string> kNames = {{WorldKind::kCubicle, "Cubicle"},
                                                          {WorldKind::kOffice, "Office"},
                                                          {WorldKind::kBuilding, "Building"}};
  return kNames.at(test.param.kind) + std::to_string(test.param.seed);
}

class Worlds : public ::testing::TestWithParam<WorldCase> {
 protected:
  /// Of the group's members, in the frame of the group.
  Aabb boxOf(const Group& group, std::uint16_t id) const {
    Aabb box;
    const Pose T_group_world = group.T_world_group.inverse();
    for (const Solid& solid : world_.solids) {
      if (solid.instance == id)
        box.extend(computeBounds(solid, T_group_world * solid.T_world_solid));
    }
    return box;
  }

  Apartment world_ = buildWorld(GetParam().kind, {GetParam().seed, 6});
};

INSTANTIATE_TEST_SUITE_P(Kinds, Worlds,
                         ::testing::Values(WorldCase{WorldKind::kCubicle, 1, 50, 1},
                                           WorldCase{WorldKind::kCubicle, 2, 50, 1},
                                           WorldCase{WorldKind::kOffice, 1, 90, 1},
                                           WorldCase{WorldKind::kOffice, 2, 90, 1},
                                           WorldCase{WorldKind::kBuilding, 1, 300, 3}),
                         nameOf);

TEST_P(Worlds, AreFurnishedOnEveryFloor) {
  EXPECT_GE(world_.instances.size(), GetParam().min_instances);
  EXPECT_EQ(world_.countFloors(), GetParam().num_floors);
  std::map<int, int> things;
  for (const Instance& instance : world_.instances) {
    ++things[instance.room];
    const Room& room = world_.rooms.at(static_cast<std::size_t>(instance.room - 1));
    EXPECT_GE(instance.box.min().z(), room.floor_z_m - 1e-9) << instance.phrase;
    EXPECT_LE(instance.box.max().z(), room.floor_z_m + room.height_m + 1e-9) << instance.phrase;
    EXPECT_EQ(world_.findRoom(Eigen::Vector3d(instance.box.center())), room.id) << instance.phrase;
  }
  for (const Room& room : world_.rooms) {
    const bool is_way = room.kind == RoomKind::kCorridor || room.kind == RoomKind::kStaircase;
    EXPECT_GE(things[room.id], is_way ? 0 : 6) << room.id << " " << room.phrase;
  }
}

TEST_P(Worlds, HaveThingsThatTouchButShareNoVolume) {
  EXPECT_EQ(test::findIntrusion(world_), "");
  for (const Group& group : world_.groups) {
    ASSERT_GE(group.instances.size(), 3U);
    for (const std::uint16_t id : group.instances) {
      double nearest_m = 1.0;
      for (const std::uint16_t other : group.instances) {
        if (other == id) continue;
        nearest_m = std::min(nearest_m, boxOf(group, id).exteriorDistance(boxOf(group, other)));
      }
      EXPECT_LT(nearest_m, 1e-6) << group.phrase;
    }
  }
}

TEST_P(Worlds, BoxesOfGroupsAreTheSmallestThatHoldTheirMembers) {
  for (const Group& group : world_.groups) {
    Aabb box;
    for (const std::uint16_t id : group.instances) box.extend(boxOf(group, id));
    EXPECT_LT((box.min() - group.local_box.min()).norm(), 1e-9) << group.phrase;
    EXPECT_LT((box.max() - group.local_box.max()).norm(), 1e-9) << group.phrase;
  }
}

TEST_P(Worlds, FollowFromTheirSeed) {
  const Apartment again = buildWorld(GetParam().kind, {GetParam().seed, 6});
  ASSERT_EQ(again.solids.size(), world_.solids.size());
  for (std::size_t i = 0; i < again.solids.size(); ++i) {
    ASSERT_EQ(again.solids[i].T_world_solid.matrix(), world_.solids[i].T_world_solid.matrix());
    ASSERT_EQ(again.solids[i].half_size_m, world_.solids[i].half_size_m);
    ASSERT_EQ(again.solids[i].material.color, world_.solids[i].material.color);
  }
  const Apartment other = buildWorld(GetParam().kind, {GetParam().seed + 10, 6});
  bool differs = other.solids.size() != world_.solids.size();
  for (std::size_t i = 0; !differs && i < other.solids.size(); ++i) {
    differs = other.solids[i].T_world_solid.matrix() != world_.solids[i].T_world_solid.matrix();
  }
  EXPECT_TRUE(differs);
}

TEST_P(Worlds, BothTaskListsAreAboutTheSameThings) {
  const auto fine = makeGroupTasks(world_, TaskGrain::kFine);
  const auto coarse = makeGroupTasks(world_, TaskGrain::kCoarse);
  std::set<std::uint16_t> grouped;
  std::set<std::size_t> groups;
  for (const TaskTruth& task : coarse) {
    for (const std::size_t index : task.groups) {
      EXPECT_TRUE(groups.insert(index).second) << task.name;
      for (const std::uint16_t id : world_.groups.at(index).instances) {
        EXPECT_TRUE(grouped.insert(id).second) << task.name;
      }
    }
  }
  EXPECT_EQ(groups.size(), world_.groups.size());
  std::size_t one_by_one = 0;
  for (const TaskTruth& task : fine) {
    EXPECT_TRUE(task.groups.empty());
    const auto same = std::find_if(coarse.begin(), coarse.end(),
                                   [&](const TaskTruth& other) { return other.name == task.name; });
    if (same != coarse.end()) {
      EXPECT_EQ(same->instances, task.instances) << task.name;
      continue;
    }
    one_by_one += task.instances.size();
    for (const std::uint16_t id : task.instances) EXPECT_EQ(grouped.count(id), 1U) << task.name;
  }
  EXPECT_GE(one_by_one, world_.groups.size());
}

TEST_P(Worlds, MembersAreNearTheirOwnTasksInBothListsAndToNoOther) {
  const SegmentSimulator segments(world_, SegmentConfig{});
  const EmbeddingSpace space;
  for (const TaskGrain grain : {TaskGrain::kFine, TaskGrain::kCoarse}) {
    for (const TaskTruth& task : makeGroupTasks(world_, grain)) {
      std::set<std::uint16_t> right(task.instances.begin(), task.instances.end());
      for (const std::size_t index : task.groups) {
        const auto& members = world_.groups[index].instances;
        right.insert(members.begin(), members.end());
      }
      const Embedding text = space.encodeText(task.phrases);
      for (std::uint16_t part = 1; part <= world_.parts.size(); ++part) {
        const double cosine = static_cast<double>(text.dot(segments.embedPart(part, 5)));
        const std::uint16_t instance = world_.parts[part - 1U].instance;
        EXPECT_GE(cosine, right.count(instance) != 0 ? 0.225 : 0.1) << task.name;
        EXPECT_LE(cosine, right.count(instance) != 0 ? 0.32 : 0.245)
            << task.name << ": " << world_.instances[instance - 1U].phrase;
      }
    }
  }
}

TEST_P(Worlds, BoxesOfCoarseTasksHoldThoseOfFineOnesInTheFiles) {
  const tsg::test::TemporaryFolder folder;
  const auto fine = makeGroupTasks(world_, TaskGrain::kFine);
  const auto coarse = makeGroupTasks(world_, TaskGrain::kCoarse);
  writeTaskTruth(folder.path() / "fine.yaml", world_, fine);
  writeTaskTruth(folder.path() / "coarse.yaml", world_, coarse);
  const YAML::Node one =
      YAML::LoadFile((folder.path() / "fine.yaml").string())["get the green book"];
  const YAML::Node all =
      YAML::LoadFile((folder.path() / "coarse.yaml").string())["move the stacks of books"];
  ASSERT_GE(one.size(), 1U);
  ASSERT_EQ(one.size(), all.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    const auto book = one[i]["extents"].as<std::vector<double>>();
    const auto stack = all[i]["extents"].as<std::vector<double>>();
    EXPECT_NEAR(book[0], stack[0], 1e-6);  // the lowest and largest
    EXPECT_NEAR(book[1], stack[1], 1e-6);
    EXPECT_GT(stack[2], 3.0 * book[2]);
    const auto book_center = one[i]["center"].as<std::vector<double>>();
    const auto stack_center = all[i]["center"].as<std::vector<double>>();
    EXPECT_NEAR(stack_center[2] - book_center[2], 0.5 * (stack[2] - book[2]), 1e-6);
  }
}

TEST_P(Worlds, WalksEnterEveryRoomAndClimbAllStairs) {
  const auto walk = planWalk(world_, WalkConfig{});
  std::set<int> visited;
  double before_m = walk.front().T_world_camera.translation().z();
  for (const WalkPose& pose : walk) {
    const Eigen::Vector3d p = pose.T_world_camera.translation();
    const Eigen::Vector3d feet = p - Eigen::Vector3d(0.0, 0.0, WalkConfig{}.camera_height_m);
    visited.insert(world_.findRoom(feet));
    ASSERT_LT(std::abs(p.z() - before_m), 0.12);  // no jump from floor to floor
    before_m = p.z();
  }
  for (const Room& room : world_.rooms) {
    const bool is_top = room.floor + 1 == world_.countFloors();
    if (is_top && room.kind == RoomKind::kStaircase) continue;
    EXPECT_EQ(visited.count(room.id), 1U) << room.id << " " << room.phrase;
  }
}

TEST_P(Worlds, CamerasOnTheWalkAreInsideOfNothing) {
  for (const WalkPose& pose : planWalk(world_, WalkConfig{})) {
    for (const Solid& solid : world_.solids) {
      ASSERT_FALSE(isInside(solid, pose.T_world_camera.translation()));
    }
  }
}

TEST_P(Worlds, WalksSeeNearlyAllThingsOfTheTasks) {
  WalkConfig config;
  config.rate_hz = 2.5;
  config.stops_per_room = 2;
  const Renderer renderer(world_, 2);
  const CameraModel camera = makeDefaultCamera(160, 120);
  std::vector<int> views(world_.instances.size() + 1, 0);
  for (const WalkPose& pose : planWalk(world_, config)) {
    const RenderedView view = renderer.render(camera, pose.T_world_camera);
    std::vector<int> pixels(views.size(), 0);
    for (auto at = view.labels.begin<std::uint16_t>(); at != view.labels.end<std::uint16_t>();
         ++at) {
      ++pixels[*at];
    }
    for (std::size_t i = 1; i < views.size(); ++i) views[i] += pixels[i] >= 20 ? 1 : 0;
  }
  int num_things = 0;
  int num_seen = 0;
  for (const TaskTruth& task : makeGroupTasks(world_, TaskGrain::kFine)) {
    for (const std::uint16_t id : task.instances) {
      ++num_things;
      num_seen += views[id] >= 2 ? 1 : 0;
    }
  }
  EXPECT_GE(num_seen, 0.95 * num_things) << "of " << num_things;
}

TEST(WorldKinds, AreReadFromTheirNames) {
  EXPECT_EQ(parseWorldKind("building"), WorldKind::kBuilding);
  try {
    parseWorldKind("castle");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'castle', expected apartment"), std::string::npos);
  }
}

TEST(WorldKinds, AnApartmentIsTheOneThatItsConfigurationNames) {
  const Apartment a = buildWorld(WorldKind::kApartment, {3, 5});
  const Apartment b = buildApartment({3, 5});
  ASSERT_EQ(a.solids.size(), b.solids.size());
  EXPECT_EQ(a.solids.back().T_world_solid.matrix(), b.solids.back().T_world_solid.matrix());
  EXPECT_TRUE(a.groups.empty());
}

}  // namespace
}  // namespace tsg::simulation
