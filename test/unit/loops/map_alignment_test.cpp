// SPDX-License-Identifier: BSD-3-Clause
// Two maps of the same rooms, in different coordinates.
#include "task_scene_graph/loops/map_alignment.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "task_scene_graph/mapping/tsdf_volume.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::loops {
namespace {

constexpr double kVoxel_m = 0.05;
constexpr int kEmbeddingSize = 32;

struct Thing {
  Eigen::Vector3f min_m;
  Eigen::Vector3f size_m;
  Embedding embedding;
};

/// A room of 4 m x 3 m with furniture; the same for the same seed.
struct Room {
  Eigen::Vector3f corner_m;
  std::vector<Thing> things;
};

Room makeRoom(std::uint32_t seed, float x_m) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> share(0.0F, 1.0F);
  std::normal_distribution<float> normal;
  Room room{{x_m, 0.0F, 0.0F}, {}};
  for (int i = 0; i < 7; ++i) {
    const Eigen::Vector3f size_m(0.3F + 0.6F * share(engine), 0.3F + 0.5F * share(engine),
                                 0.4F + 1.2F * share(engine));
    const Eigen::Vector3f place(share(engine) * (4.0F - size_m.x()),
                                share(engine) < 0.5F ? 0.0F : 3.0F - size_m.y(), 0.0F);
    Embedding embedding(kEmbeddingSize);
    for (int k = 0; k < kEmbeddingSize; ++k) embedding(k) = normal(engine);
    room.things.push_back({room.corner_m + place, size_m, embedding.normalized()});
  }
  return room;
}

/// A mesh in blocks, in coordinates of its own.
class MapMaker {
 public:
  explicit MapMaker(const Pose& T_map_world) : T_map_world_(T_map_world) {}

  void addRoom(const Room& room) {
    const Eigen::Vector3f x(4.0F, 0.0F, 0.0F);
    const Eigen::Vector3f y(0.0F, 3.0F, 0.0F);
    const Eigen::Vector3f z(0.0F, 0.0F, 2.5F);
    const Eigen::Vector3f& o = room.corner_m;
    addRectangle(o, x, y);  // seen from above
    addRectangle(o, z, x);  // ... from within
    addRectangle(o, y, z);
    addRectangle(o + y, x, z);
    addRectangle(o + x, z, y);
    for (const Thing& thing : room.things) addThing(thing);
    for (float step_m = 0.5F; step_m < 4.0F; step_m += 0.5F) {
      addPose(o + Eigen::Vector3f(step_m, 1.2F + 0.2F * step_m, 1.3F));
    }
  }

  map::Map make() const {
    map::Map map("map");
    std::vector<mapping::BlockMesh> blocks;
    for (const auto& [key, mesh] : blocks_) {
      blocks.push_back({{key[0], key[1], key[2]}, std::make_shared<const Mesh>(mesh)});
    }
    std::sort(blocks.begin(), blocks.end(),
              [](const auto& a, const auto& b) { return mapping::isBefore(a.block, b.block); });
    map.setMesh(kVoxel_m, std::move(blocks));
    map.setTrajectory(std::make_shared<const Trajectory>(way_));
    map.addPrimitives(primitives_);
    return map;
  }

 private:
  void addThing(const Thing& thing) {
    const Eigen::Vector3f x(thing.size_m.x(), 0.0F, 0.0F);
    const Eigen::Vector3f y(0.0F, thing.size_m.y(), 0.0F);
    const Eigen::Vector3f z(0.0F, 0.0F, thing.size_m.z());
    const Eigen::Vector3f& o = thing.min_m;
    addRectangle(o + z, x, y);
    addRectangle(o, x, z);
    addRectangle(o, z, y);
    addRectangle(o + y, z, x);
    addRectangle(o + x, y, z);
    const auto primitive = std::make_shared<ObjectPrimitive>();
    primitive->id = PrimitiveId{primitives_.size() + 1};
    const Eigen::Vector3d middle_m = toMap(o + 0.5F * thing.size_m).cast<double>();
    primitive->box.extend(middle_m - Eigen::Vector3d::Constant(0.2));
    primitive->box.extend(middle_m + Eigen::Vector3d::Constant(0.2));
    primitive->embedding = thing.embedding;
    primitive->first_seen = primitive->last_seen = Stamp{1};
    primitives_.push_back(primitive);
  }

  /// Triangles of a voxel's size on u x v, whose product points to free space.
  void addRectangle(const Eigen::Vector3f& corner_m, const Eigen::Vector3f& u,
                    const Eigen::Vector3f& v) {
    const int num_u = static_cast<int>(u.norm() / static_cast<float>(kVoxel_m)) + 1;
    const int num_v = static_cast<int>(v.norm() / static_cast<float>(kVoxel_m)) + 1;
    const Eigen::Vector3f du = u / static_cast<float>(num_u);
    const Eigen::Vector3f dv = v / static_cast<float>(num_v);
    for (int i = 0; i < num_u * num_v; ++i) {
      const Eigen::Vector3f p =
          corner_m + static_cast<float>(i % num_u) * du + static_cast<float>(i / num_u) * dv;
      addTriangle(toMap(p), toMap(p + du), toMap(p + dv));
    }
  }

  void addTriangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    const auto side_m = static_cast<float>(kVoxel_m * mapping::kBlockSide);
    const Eigen::Vector3i block = (a / side_m).array().floor().cast<int>();
    Mesh& mesh = blocks_[{block.x(), block.y(), block.z()}];
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.colors.resize(mesh.vertices.size());
    mesh.triangles.push_back({first, first + 1, first + 2});
  }

  void addPose(const Eigen::Vector3f& p_world) {
    Pose pose = Pose::Identity();
    pose.translation() = toMap(p_world).cast<double>();
    way_.add(Stamp{static_cast<std::int64_t>(way_.size() + 1) * 1000000000}, pose);
  }

  Eigen::Vector3f toMap(const Eigen::Vector3f& p_world) const {
    return (T_map_world_ * p_world.cast<double>()).cast<float>();
  }

  Pose T_map_world_;
  std::map<std::array<int, 3>, Mesh> blocks_;
  std::vector<ObjectPrimitivePtr> primitives_;
  Trajectory way_;
};

map::Map makeMap(const std::vector<Room>& rooms, const Pose& T_map_world = Pose::Identity()) {
  MapMaker maker(T_map_world);
  for (const Room& room : rooms) maker.addRoom(room);
  return maker.make();
}

Pose makeMotion(double x_m, double y_m, double yaw_rad) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(x_m, y_m, -0.4);
  T.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).matrix();
  return T;
}

std::string findProblem(const map::Map& a, const map::Map& b) {
  try {
    const MapAlignment found = alignMaps(a, b);
    return "overlap " + std::to_string(found.overlap) + ", " + std::to_string(found.num_there) +
           " of " + std::to_string(found.num_things) + " things, " +
           std::to_string(found.num_agreeing) + " of " + std::to_string(found.num_fitting) +
           " agree";
  } catch (const std::runtime_error& e) {
    return e.what();
  }
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(MapAlignment, FindsWhereAMapOfTwoRoomsLiesInOneOfThree) {
  const std::vector<Room> rooms = {makeRoom(1, 0.0F), makeRoom(2, 4.2F), makeRoom(3, 8.4F)};
  for (const double yaw_rad : {2.3, -1.2}) {
    const Pose T_b_world = makeMotion(12.0, -30.0, yaw_rad);
    const MapAlignment found = alignMaps(makeMap(rooms), makeMap({rooms[1], rooms[2]}, T_b_world));
    const Pose off = found.T_a_b * T_b_world;
    EXPECT_LT((off * Eigen::Vector3d(8.4, 1.5, 1.0) - Eigen::Vector3d(8.4, 1.5, 1.0)).norm(), 0.05);
    EXPECT_LT(trajectory::computeAngle(off), 0.01);
    EXPECT_GE(found.num_agreeing, 3U);
    EXPECT_GE(found.num_fitting, found.num_agreeing);
    EXPECT_GE(found.num_tried, found.num_fitting);
  }
}

TEST(MapAlignment, NeedsNoEmbeddings) {
  std::vector<Room> rooms = {makeRoom(1, 0.0F), makeRoom(2, 4.2F), makeRoom(3, 8.4F)};
  for (Room& room : rooms) {
    for (Thing& thing : room.things) thing.embedding = Embedding();
  }
  const Pose T_b_world = makeMotion(-3.0, 5.0, 0.7);
  const MapAlignment found = alignMaps(makeMap(rooms), makeMap({rooms[0], rooms[1]}, T_b_world));
  const Pose off = found.T_a_b * T_b_world;
  EXPECT_LT((off * Eigen::Vector3d(4.0, 1.5, 1.0) - Eigen::Vector3d(4.0, 1.5, 1.0)).norm(), 0.05);
}

TEST(MapAlignment, OfOtherRoomsIsRefused) {
  const auto problem = findProblem(makeMap({makeRoom(1, 0.0F), makeRoom(2, 4.2F)}),
                                   makeMap({makeRoom(11, 0.0F), makeRoom(12, 4.2F)}));
  expectContains(problem, "maps not aligned: ");
  expectContains(problem, "expected");
}

TEST(MapAlignment, OfEqualRoomsIsRefused) {
  const auto problem =
      findProblem(makeMap({makeRoom(1, 0.0F), makeRoom(1, 12.0F)}), makeMap({makeRoom(1, 0.0F)}));
  expectContains(problem, "maps not aligned: ");
}

TEST(MapAlignment, NeedsAWayAndAMesh) {
  const map::Map map = makeMap({makeRoom(1, 0.0F)});
  map::Map without_way = map;
  without_way.setTrajectory(std::make_shared<const Trajectory>());
  expectContains(findProblem(without_way, map), "the first map has no trajectory");
  map::Map without_mesh = map;
  without_mesh.setMesh(kVoxel_m, {});
  expectContains(findProblem(map, without_mesh), "the second map has no mesh");
}

}  // namespace
}  // namespace tsg::loops
