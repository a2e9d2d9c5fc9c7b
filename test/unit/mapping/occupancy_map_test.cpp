// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/occupancy_map.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <tuple>

#include "support.h"
#include "synthetic_scene.h"
#include "task_scene_graph/config/config.h"

namespace tsg::mapping {
namespace {

const CameraModel kCamera{160, 120, 120.0, 121.0, 79.5, 59.5};
using Key = std::tuple<int, int, int>;
using States = std::map<Key, bool>;

Key toKey(const GridIndex& index) { return {index.x(), index.y(), index.z()}; }

/// A room of 6 x 4 x 2.4 m seen from within, with a box in it.
std::vector<test::Solid> makeRoom() {
  return {test::makePlane({0.05, 0, 0}, {1, 0, 0}, {1, 1, 1}),
          test::makePlane({5.95, 0, 0}, {-1, 0, 0}, {1, 1, 1}),
          test::makePlane({0, 0.05, 0}, {0, 1, 0}, {1, 1, 1}),
          test::makePlane({0, 3.95, 0}, {0, -1, 0}, {1, 1, 1}),
          test::makePlane({0, 0, 0.05}, {0, 0, 1}, {1, 1, 1}),
          test::makePlane({0, 0, 2.45}, {0, 0, -1}, {1, 1, 1}),
          test::makeBox({Eigen::Vector3d(3.65, 1.55, 0.05), Eigen::Vector3d(4.45, 2.35, 1.05)},
                        {2, 2, 2})};
}

RgbdFrame renderRoom(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  return test::render(makeRoom(), kCamera, test::lookAt(eye, target)).frame;
}

/// All around, upwards and downwards.
std::vector<RgbdFrame> renderTurn() {
  std::vector<RgbdFrame> frames;
  const Eigen::Vector3d eye(1.53, 1.94, 1.27);
  for (int i = 0; i < 12; ++i) {
    const double angle = i / 2 * M_PI / 3.0;
    const double rise = i % 2 == 0 ? -0.4 : 0.3;
    frames.push_back(
        renderRoom(eye, eye + Eigen::Vector3d(std::cos(angle), std::sin(angle), rise)));
  }
  return frames;
}

OccupancyConfig makeConfig() {
  OccupancyConfig config;
  config.pixel_stride = 1;
  config.max_range_m = 10.0;
  return config;
}

States toStates(const std::vector<OccupancyVoxel>& voxels) {
  States states;
  for (const auto& voxel : voxels) states[toKey(voxel.index)] = voxel.is_occupied;
  EXPECT_EQ(states.size(), voxels.size()) << "a voxel is named twice";
  return states;
}

/// Log-odds per voxel from rays walked in tiny steps; no code shared with the module.
class BruteForceMap {
 public:
  explicit BruteForceMap(const OccupancyConfig& config) : config_(config) {}

  void integrate(const RgbdFrame& frame) {
    std::set<Key> hits;
    std::set<Key> far;
    const Eigen::Vector3d eye = frame.T_world_camera.translation();
    for (int v = 0; v < kCamera.height_px; v += config_.pixel_stride) {
      for (int u = 0; u < kCamera.width_px; u += config_.pixel_stride) {
        const double z_m = frame.depth.at(u, v);
        const Eigen::Vector3d end = frame.T_world_camera * kCamera.unproject(u, v, z_m);
        const double range_m = (end - eye).norm();
        if (z_m <= 0.0 || range_m < config_.min_range_m) continue;
        if (range_m <= config_.max_range_m) {
          hits.insert(voxelOf(end));
        } else {
          far.insert(voxelOf(eye + (end - eye).normalized() * config_.max_range_m));
        }
      }
    }
    std::set<Key> passed;
    for (const auto& end : hits) walk(eye, end, passed);
    for (const auto& end : far) walk(eye, end, passed);
    for (const auto& key : passed) {
      if (hits.count(key) == 0) add(key, config_.miss_probability);
    }
    for (const auto& key : hits) add(key, config_.hit_probability);
  }

  States states() const {
    States states;
    for (const auto& [key, odds] : log_odds_) states[key] = odds >= 0.0;
    return states;
  }

 private:
  Key voxelOf(const Eigen::Vector3d& p) const {
    return toKey((p / config_.resolution_m).array().floor().cast<int>().matrix());
  }

  void walk(const Eigen::Vector3d& eye, const Key& end, std::set<Key>& passed) const {
    const Eigen::Vector3d center =
        (Eigen::Vector3d(std::get<0>(end), std::get<1>(end), std::get<2>(end)).array() + 0.5) *
        config_.resolution_m;
    const int num_steps = static_cast<int>((center - eye).norm() / 0.0005) + 1;
    for (int i = 0; i < num_steps; ++i) {
      const Key key = voxelOf(eye + (center - eye) * (static_cast<double>(i) / num_steps));
      if (key != end) passed.insert(key);
    }
  }

  void add(const Key& key, double probability) {
    const auto odds = [](double p) { return std::log(p / (1.0 - p)); };
    double& value = log_odds_[key];
    value = std::clamp(value + odds(probability), odds(config_.clamp_min_probability),
                       odds(config_.clamp_max_probability));
  }

  OccupancyConfig config_;
  std::map<Key, double> log_odds_;
};

/// Share of the voxels of either map that the other one has not or has otherwise.
double computeDisagreement(const States& a, const States& b) {
  std::size_t num_different = 0;
  std::size_t num_all = b.size();
  for (const auto& [key, is_occupied] : a) {
    const auto other = b.find(key);
    num_all += other == b.end() ? 1 : 0;
    num_different += other == b.end() || other->second != is_occupied ? 1 : 0;
  }
  for (const auto& [key, is_occupied] : b) num_different += a.count(key) == 0 ? 1 : 0;
  return static_cast<double>(num_different) / static_cast<double>(num_all);
}

TEST(OccupancyMap, AgreesWithRaysWalkedInTinySteps) {
  for (const double max_range_m : {10.0, 2.0}) {
    OccupancyConfig config = makeConfig();
    config.max_range_m = max_range_m;
    config.pixel_stride = 3;
    OccupancyMap map(config);
    BruteForceMap expected(config);
    for (const auto& frame : renderTurn()) {
      ASSERT_TRUE(map.integrate(frame));
      expected.integrate(frame);
    }
    const States states = toStates(map.voxels());
    ASSERT_GT(states.size(), 5000U);
    // Rays through an edge or a corner of a voxel may go either way.
    EXPECT_LT(computeDisagreement(states, expected.states()), 0.004);
  }
}

TEST(OccupancyMap, IsFreeInsideOccupiedAtTheWallsAndUnknownBehindThem) {
  OccupancyMap map(makeConfig());
  for (const auto& frame : renderTurn()) map.integrate(frame);
  std::map<Occupancy, int> inside;
  std::map<Occupancy, int> wall;
  for (double y = 0.25; y < 3.8; y += 0.1) {
    for (double z = 0.65; z < 1.9; z += 0.1) {
      ++inside[map.at({0.75, y, z})];
      ++wall[map.at({0.03, y, z})];
      EXPECT_EQ(map.at({-0.05, y, z}), Occupancy::kUnknown) << y << " " << z;
      EXPECT_EQ(map.at({6.15, y, z}), Occupancy::kUnknown) << y << " " << z;
    }
  }
  EXPECT_EQ(inside[Occupancy::kOccupied], 0);
  EXPECT_EQ(inside[Occupancy::kUnknown], 0);
  EXPECT_EQ(wall[Occupancy::kUnknown], 0);
  EXPECT_GE(wall[Occupancy::kOccupied], 99 * wall[Occupancy::kFree]);
  EXPECT_EQ(map.at({4.05, 1.95, 0.55}), Occupancy::kUnknown) << "inside the box";
  EXPECT_EQ(map.at({3.67, 1.95, 0.75}), Occupancy::kOccupied) << "the box's front";
  EXPECT_EQ(map.at({1e9, 0, 0}), Occupancy::kUnknown) << "outside the tree";
}

TEST(OccupancyMap, ReadingsBeyondTheRangeFreeSpaceUpToItAndOccupyNothing) {
  OccupancyConfig config = makeConfig();
  config.max_range_m = 2.0;
  OccupancyMap map(config);
  const Eigen::Vector3d eye(0.55, 1.05, 1.25);
  map.integrate(renderRoom(eye, eye + Eigen::Vector3d::UnitX()));
  EXPECT_EQ(map.at({2.35, 1.05, 1.25}), Occupancy::kFree);
  EXPECT_EQ(map.at({2.75, 1.05, 1.25}), Occupancy::kUnknown);
  for (const auto& voxel : map.voxels()) {
    const Eigen::Vector3d center = (voxel.index.cast<double>().array() + 0.5) * 0.1;
    EXPECT_LT((center - eye).norm(), 2.0 + 0.1 * std::sqrt(3.0));
  }
}

TEST(OccupancyMap, ChangesAreTheDifferenceBetweenWholeMaps) {
  OccupancyConfig config = makeConfig();
  config.pixel_stride = 2;
  OccupancyMap map(config);
  States before;
  // The box is there, then gone, then there again: voxels change both ways.
  std::vector<test::Solid> empty_room = makeRoom();
  empty_room.pop_back();
  const Pose pose = test::lookAt({1.53, 1.94, 1.27}, {4.0, 1.9, 0.7});
  for (int i = 0; i < 18; ++i) {
    const bool has_box = i / 6 % 2 == 0;
    map.integrate(test::render(has_box ? makeRoom() : empty_room, kCamera, pose).frame);
    if (i % 3 == 1) continue;  // some sets hold several frames
    const States after = toStates(map.voxels());
    States expected;
    for (const auto& [key, is_occupied] : after) {
      const auto old = before.find(key);
      if (old == before.end() || old->second != is_occupied) expected[key] = is_occupied;
    }
    EXPECT_EQ(toStates(map.takeChanges()), expected) << "frame " << i;
    before = after;
  }
  EXPECT_TRUE(map.takeChanges().empty());
}

TEST(OccupancyMap, LeavesCoverTheSameSpaceAsVoxels) {
  OccupancyMap map(makeConfig());
  for (int i = 0; i < 6; ++i) {
    for (const auto& frame : renderTurn()) map.integrate(frame);
  }
  double volume_m3 = 0.0;
  std::size_t num_large = 0;
  for (const auto& leaf : map.leaves()) {
    volume_m3 += std::pow(leaf.side_m, 3);
    num_large += leaf.side_m > 0.15 ? 1 : 0;
  }
  EXPECT_GT(num_large, 0U) << "clamped voxels are merged";
  const auto voxels = map.voxels();
  EXPECT_NEAR(volume_m3, static_cast<double>(voxels.size()) * 1e-3, 1e-6);
  for (const auto& voxel : voxels) {
    const Eigen::Vector3d center = (voxel.index.cast<double>().array() + 0.5) * 0.1;
    ASSERT_EQ(map.at(center), voxel.is_occupied ? Occupancy::kOccupied : Occupancy::kFree);
  }
}

States readStates(const octomap::OcTree& octree) {
  States states;
  auto expanded = octree;
  expanded.expand();
  for (auto leaf = expanded.begin_leafs(); leaf != expanded.end_leafs(); ++leaf) {
    const auto key = leaf.getKey();
    states[{key[0] - 32768, key[1] - 32768, key[2] - 32768}] = octree.isNodeOccupied(*leaf);
  }
  return states;
}

TEST(OccupancyMap, OctomapReadsItsFiles) {
  OccupancyMap map(makeConfig());
  for (const auto& frame : renderTurn()) map.integrate(frame);
  const test::TemporaryFolder folder;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  map.write(folder.path() / "map.bt");
  map.write(folder.path() / "map.ot");
  const std::string said =
      testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
#ifdef NDEBUG  // else OctoMap's headers tell of their progress
  EXPECT_EQ(said, "");
#endif
  octomap::OcTree binary(1.0);
  ASSERT_TRUE(binary.readBinary((folder.path() / "map.bt").string()));
  EXPECT_DOUBLE_EQ(binary.getResolution(), 0.1);
  EXPECT_EQ(readStates(binary), toStates(map.voxels()));
  const std::unique_ptr<octomap::AbstractOcTree> any(
      octomap::AbstractOcTree::read((folder.path() / "map.ot").string()));
  const auto* full = dynamic_cast<octomap::OcTree*>(any.get());
  ASSERT_NE(full, nullptr);
  EXPECT_EQ(readStates(*full), toStates(map.voxels()));
}

TEST(OccupancyMap, FilesEndInBtOrOt) {
  const test::TemporaryFolder folder;
  const OccupancyMap map(makeConfig());
  EXPECT_THROW(map.write(folder.path() / "map.ply"), std::invalid_argument);
  EXPECT_THROW(map.write("/proc/no/such/folder/map.bt"), std::runtime_error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(OccupancyMap, SerializedDataAreTheFileWithoutItsHeader) {
  OccupancyMap map(makeConfig());
  for (const auto& frame : renderTurn()) map.integrate(frame);
  for (const bool is_binary : {true, false}) {
    octomap::OcTree octree(0.1);
    std::istringstream stream(map.serialize(is_binary), std::ios::binary);
    is_binary ? octree.readBinaryData(stream) : octree.readData(stream);
    EXPECT_EQ(readStates(octree), toStates(map.voxels()));
  }
}

TEST(OccupancyMap, FramesWithoutDepthChangeNothing) {
  OccupancyMap map(makeConfig());
  map.integrate(renderTurn().front());
  map.takeChanges();
  const std::string before = map.serialize(false);
  RgbdFrame frame = renderTurn().front();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {0.0F, nan, infinity, -1.0F, 0.1F}) {
    frame.depth.image = cv::Mat(kCamera.height_px, kCamera.width_px, CV_32FC1, cv::Scalar(bad));
    EXPECT_FALSE(map.integrate(frame)) << bad;
  }
  frame.depth.metres_per_unit = 0.001;
  for (const int bad : {0, 65535}) {
    frame.depth.image = cv::Mat(kCamera.height_px, kCamera.width_px, CV_16UC1, cv::Scalar(bad));
    EXPECT_FALSE(map.integrate(frame)) << bad;
  }
  EXPECT_EQ(map.serialize(false), before);
  EXPECT_TRUE(map.takeChanges().empty());
  EXPECT_EQ(map.counters().frames_without_depth, 7U);
  EXPECT_EQ(map.counters().frames_integrated, 1U);
}

TEST(OccupancyMap, ReadingsOutsideTheTreeAreCounted) {
  OccupancyMap map(makeConfig());
  RgbdFrame frame = renderTurn().front();
  frame.T_world_camera.translation() = Eigen::Vector3d(1e5, 0, 0);
  EXPECT_FALSE(map.integrate(frame));
  EXPECT_GT(map.counters().readings_out_of_tree, 10000U);
  EXPECT_TRUE(map.leaves().empty());
}

TEST(OccupancyMap, BadParametersAreNamedWithTheirRange) {
  for (const double resolution_m : {0.0, -0.1, 0.001, 5.0}) {
    OccupancyConfig config;
    config.resolution_m = resolution_m;
    EXPECT_THROW(OccupancyMap{config}, config::ConfigError) << resolution_m;
  }
  OccupancyConfig config;
  config.min_range_m = 6.0;
  try {
    OccupancyMap map(config);
    FAIL() << "not rejected";
  } catch (const config::ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("min_range_m is 6"), std::string::npos) << e.what();
  }
}

States listStates(const OccupancyMap& map) {
  States states;
  for (const auto& voxel : map.voxels()) states[toKey(voxel.index)] = voxel.is_occupied;
  return states;
}

OccupancyMap makeTurnMap() {
  OccupancyMap map(makeConfig());
  for (const RgbdFrame& frame : renderTurn()) map.integrate(frame);
  return map;
}

TEST(OccupancyMap, MovedByNothingItIsTheSameMap) {
  const OccupancyMap map = makeTurnMap();
  OccupancyMap same = map.moved([](const Eigen::Vector3d&) { return Pose::Identity(); });
  EXPECT_EQ(listStates(same), listStates(map));
  EXPECT_EQ(same.serialize(false), map.serialize(false));
  EXPECT_TRUE(same.takeChanges().empty());
  EXPECT_EQ(same.counters().frames_integrated, map.counters().frames_integrated);
}

TEST(OccupancyMap, MovedByWholeVoxelsEachIsThereWithItsProbability) {
  const OccupancyMap map = makeTurnMap();
  const double size_m = map.config().resolution_m;
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(3.0, -2.0, 10.0) * size_m;
  const OccupancyMap moved = map.moved([&](const Eigen::Vector3d&) { return T; });
  States expected;
  for (const auto& [key, is_occupied] : listStates(map)) {
    const auto& [x, y, z] = key;
    expected[{x + 3, y - 2, z + 10}] = is_occupied;
  }
  EXPECT_EQ(listStates(moved), expected);
}

TEST(OccupancyMap, TurnedItHasNoHolesAndBothStatesWhereTheyBelong) {
  const OccupancyMap map = makeTurnMap();
  const double size_m = map.config().resolution_m;
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(1.0, 0.3, 0.2);
  const OccupancyMap moved = map.moved([&](const Eigen::Vector3d&) { return T; });
  std::size_t num_inner = 0;
  const States states = listStates(map);
  for (const auto& [key, is_occupied] : states) {
    const auto& [x, y, z] = key;
    bool is_inner = true;  // all around it is alike
    for (int i = 0; i < 27; ++i) {
      const auto beside = states.find({x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1});
      is_inner = is_inner && beside != states.end() && beside->second == is_occupied;
    }
    if (!is_inner) continue;
    ++num_inner;
    const Eigen::Vector3d center_m = (Eigen::Vector3d(x, y, z).array() + 0.5) * size_m;
    EXPECT_EQ(moved.at(T * center_m), is_occupied ? Occupancy::kOccupied : Occupancy::kFree);
  }
  EXPECT_GT(num_inner, 1000U);
  EXPECT_NEAR(static_cast<double>(listStates(moved).size()), static_cast<double>(states.size()),
              0.05 * static_cast<double>(states.size()));
}

}  // namespace
}  // namespace tsg::mapping
