// SPDX-License-Identifier: BSD-3-Clause
#include "state_files.h"

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/config/settings.h"
#include "task_scene_graph/core/binary.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;
using scene_graph::TaskList;

constexpr std::uint32_t kVersion = 1;
constexpr int kMaxIndex = 1 << 26;  // of blocks, so that those of voxels can be counted, too

bool isLength(double length_m) { return length_m > 1e-6 && length_m < 1e6; }

// getCount() is given at least how many bytes an item takes, so that damaged counts allocate
// little.

/// What is damaged although the file is as it was written: it was not written by this package.
void require(bool is_so, const std::string& what) {
  if (!is_so) throw std::runtime_error("is damaged: " + what);
}

void put(BinaryWriter& out, const Mesh& mesh) {
  out.putVector(mesh.colors);
  out.putVector(mesh.triangles);
  out.put(static_cast<std::uint64_t>(mesh.vertices.size()));
  out.putBytes(mesh.vertices.data(), mesh.vertices.size() * sizeof(Eigen::Vector3f));
}

Mesh getMesh(BinaryReader& in) {
  Mesh mesh;
  mesh.colors = in.getVector<std::array<std::uint8_t, 3>>();
  mesh.triangles = in.getVector<std::array<std::uint32_t, 3>>();
  mesh.vertices.resize(in.getCount(sizeof(Eigen::Vector3f)));
  in.getBytes(mesh.vertices.data(), mesh.vertices.size() * sizeof(Eigen::Vector3f));
  require(mesh.colors.size() == mesh.vertices.size(), "a mesh has not one colour per vertex");
  for (const auto& vertex : mesh.vertices) {
    require(vertex.allFinite(), "a vertex of a mesh is not finite");
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      require(vertex < mesh.vertices.size(), "a triangle has a vertex that is not there");
    }
  }
  return mesh;
}

void put(BinaryWriter& out, const Aabb& box) {
  const Eigen::Vector3d min = box.min();
  const Eigen::Vector3d max = box.max();
  out.putMatrix(min);
  out.putMatrix(max);
}

Aabb getBox(BinaryReader& in) {
  Eigen::Vector3d min;
  Eigen::Vector3d max;
  in.getMatrix(min);
  in.getMatrix(max);
  return {min, max};
}

void put(BinaryWriter& out, const OrientedBox& box) {
  out.putMatrix(box.center_m);
  out.putMatrix(box.size_m);
  out.put(box.yaw_rad);
}

OrientedBox getOrientedBox(BinaryReader& in) {
  OrientedBox box;
  in.getMatrix(box.center_m);
  in.getMatrix(box.size_m);
  box.yaw_rad = in.get<double>();
  return box;
}

void put(BinaryWriter& out, const ViewStatistics& views) {
  out.put(views.best.stamp.ns);
  out.put(views.best.segment);
  out.put(views.best_pixels);
  out.put(views.mean_distance_m);
  out.put(views.min_distance_m);
  out.put(views.spread_rad);
}

ViewStatistics getViewStatistics(BinaryReader& in) {
  ViewStatistics views;
  views.best.stamp.ns = in.get<std::int64_t>();
  views.best.segment = in.get<std::uint16_t>();
  views.best_pixels = in.get<std::uint32_t>();
  views.mean_distance_m = in.get<double>();
  views.min_distance_m = in.get<double>();
  views.spread_rad = in.get<double>();
  return views;
}

/// As PNG, which loses nothing.
void put(BinaryWriter& out, const ColorImage& image) {
  out.put(image.stamp.ns);
  out.put(static_cast<std::uint8_t>(image.order == ColorOrder::kRgb ? 0 : 1));
  std::vector<std::uint8_t> bytes;
  if (!image.image.empty()) cv::imencode(".png", image.image, bytes);
  out.putVector(bytes);
}

ColorImage getImage(BinaryReader& in) {
  ColorImage image;
  image.stamp.ns = in.get<std::int64_t>();
  image.order = in.get<std::uint8_t>() == 0 ? ColorOrder::kRgb : ColorOrder::kBgr;
  const auto bytes = in.getVector<std::uint8_t>();
  if (bytes.empty()) return image;
  image.image = cv::imdecode(bytes, cv::IMREAD_COLOR);
  require(!image.image.empty(), "a thumbnail is no PNG image");
  return image;
}

/// Without whether it is provisional: nothing will replace it.
void put(BinaryWriter& out, const ObjectPrimitive& primitive) {
  out.put(primitive.id.value);
  out.put(primitive.track.value);
  out.put(primitive.first_seen.ns);
  out.put(primitive.last_seen.ns);
  out.put(primitive.num_observations);
  put(out, primitive.box);
  put(out, primitive.oriented_box);
  out.putMatrix(primitive.embedding);
  put(out, primitive.views);
  put(out, primitive.thumbnail);
  put(out, primitive.mesh);
}

ObjectPrimitivePtr getPrimitive(BinaryReader& in) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id.value = in.get<std::uint64_t>();
  primitive->track.value = in.get<std::uint64_t>();
  primitive->first_seen.ns = in.get<std::int64_t>();
  primitive->last_seen.ns = in.get<std::int64_t>();
  primitive->num_observations = in.get<std::uint32_t>();
  primitive->box = getBox(in);
  primitive->oriented_box = getOrientedBox(in);
  in.getMatrix(primitive->embedding);
  primitive->views = getViewStatistics(in);
  primitive->thumbnail = getImage(in);
  primitive->mesh = getMesh(in);
  const Aabb& box = primitive->box;
  require(box.min().allFinite() && box.max().allFinite() && !box.isEmpty() &&
              primitive->embedding.allFinite(),
          "primitive " + std::to_string(primitive->id.value) +
              " has a box or an embedding that is not finite");
  return primitive;
}

void put(BinaryWriter& out, const Place& place) {
  out.put(place.id.value);
  out.putMatrix(place.position_m);
  out.put(place.clearance_m);
  out.put(place.num_views);
  out.putMatrix(*place.embedding);
}

Place getPlace(BinaryReader& in) {
  Place place;
  place.id.value = in.get<std::uint64_t>();
  in.getMatrix(place.position_m);
  place.clearance_m = in.get<double>();
  place.num_views = in.get<std::uint32_t>();
  Embedding embedding;
  in.getMatrix(embedding);
  require(place.position_m.allFinite() && embedding.allFinite(),
          "place " + std::to_string(place.id.value) + " is not finite");
  place.embedding = std::move(embedding);
  return place;
}

void put(BinaryWriter& out, const mapping::GridIndex& index) {
  for (int axis = 0; axis < 3; ++axis) out.put(static_cast<std::int32_t>(index[axis]));
}

mapping::GridIndex getIndex(BinaryReader& in) {
  mapping::GridIndex index;
  for (int axis = 0; axis < 3; ++axis) {
    index[axis] = in.get<std::int32_t>();
    require(std::abs(index[axis] / 2) < kMaxIndex, "an index of a grid is out of range");
  }
  return index;
}

void put(BinaryWriter& out, const Pose& pose) {
  const Eigen::Matrix<double, 3, 4> affine = pose.matrix().topRows<3>();
  out.putMatrix(affine);
}

Pose getPose(BinaryReader& in) {
  Eigen::Matrix<double, 3, 4> affine;
  in.getMatrix(affine);
  Pose pose = Pose::Identity();
  pose.matrix().topRows<3>() = affine;
  require(affine.allFinite(), "a pose is not finite");
  return pose;
}

void put(BinaryWriter& out, const TaskList& tasks) {
  out.put(static_cast<std::uint64_t>(tasks.names.size()));
  for (const auto& name : tasks.names) out.putString(name);
  out.putMatrix(tasks.embeddings);
}

TaskList getTasks(BinaryReader& in) {
  TaskList tasks;
  tasks.names.resize(in.getCount(sizeof(std::uint64_t)));
  for (auto& name : tasks.names) name = in.getString();
  in.getMatrix(tasks.embeddings);
  return tasks;
}

template <typename Id>
void putIds(BinaryWriter& out, const std::vector<Id>& ids) {
  out.put(static_cast<std::uint64_t>(ids.size()));
  for (const Id id : ids) out.put(id.value);
}

template <typename Id>
std::vector<Id> getIds(BinaryReader& in) {
  std::vector<Id> ids(in.getCount(sizeof(std::uint64_t)));
  for (Id& id : ids) id.value = in.get<std::uint64_t>();
  return ids;
}

std::string toYamlText(const scene_graph::SceneGraphConfig& config) {
  std::vector<config::YamlLine> lines;
  for (const auto& setting : config::listSettings(config, {})) {
    lines.push_back({setting.name, setting.value, ""});
  }
  std::ostringstream text;
  config::writeYaml(text, lines);
  return text.str();
}

}  // namespace

void writeTasksState(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kTasksFile, "tasks", kVersion, [&](BinaryWriter& out) {
    put(out, map.objectTasks());
    put(out, map.placeTasks());
    out.putString(toYamlText(map.settings().scene_graph));
  });
}

void readTasksState(const fs::path& file, Map& map) {
  readBinaryFile(file, "tasks", kVersion, [&](BinaryReader& in) {
    TaskList objects = getTasks(in);
    TaskList places = getTasks(in);
    map.setTasks(std::move(objects), std::move(places));
    MapSettings settings = map.settings();
    settings.scene_graph = config::load<scene_graph::SceneGraphConfig>(
        YAML::Load(in.getString()), "the settings of the clustering", {});
    map.setSettings(std::move(settings));
  });
}

void writePrimitives(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kPrimitivesFile, "primitives", kVersion, [&](BinaryWriter& out) {
    out.put(static_cast<std::uint64_t>(map.primitives().size()));
    for (const auto& primitive : map.primitives()) put(out, *primitive);
  });
}

void readPrimitives(const fs::path& file, Map& map) {
  readBinaryFile(file, "primitives", kVersion, [&](BinaryReader& in) {
    std::vector<ObjectPrimitivePtr> primitives(in.getCount(64));
    for (auto& primitive : primitives) primitive = getPrimitive(in);
    map.addPrimitives(std::move(primitives));
  });
}

void writePlaces(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kPlacesFile, "places", kVersion, [&](BinaryWriter& out) {
    const PlaceGraph& graph = *map.places();
    out.put(graph.stamp.ns);
    out.put(static_cast<std::uint64_t>(graph.places.size()));
    for (const Place& place : graph.places) put(out, place);
    out.put(static_cast<std::uint64_t>(graph.edges.size()));
    for (const PlaceEdge& edge : graph.edges) {
      out.put(edge.a.value);
      out.put(edge.b.value);
      out.put(edge.clearance_m);
    }
  });
}

void readPlaces(const fs::path& file, Map& map) {
  readBinaryFile(file, "places", kVersion, [&](BinaryReader& in) {
    auto graph = std::make_shared<PlaceGraph>();
    graph->stamp.ns = in.get<std::int64_t>();
    graph->places.resize(in.getCount(56));
    for (Place& place : graph->places) place = getPlace(in);
    graph->edges.resize(in.getCount(3 * sizeof(double)));
    for (PlaceEdge& edge : graph->edges) {
      edge.a.value = in.get<std::uint64_t>();
      edge.b.value = in.get<std::uint64_t>();
      edge.clearance_m = in.get<double>();
    }
    map.setPlaces(std::move(graph));
  });
}

void writeClusters(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kClustersFile, "clusters", kVersion, [&](BinaryWriter& out) {
    out.put(static_cast<std::uint64_t>(map.objectClusters().size()));
    for (const auto& cluster : map.objectClusters()) {
      out.put(cluster.id.value);
      out.put(static_cast<std::int32_t>(cluster.task));
      putIds(out, cluster.primitives);
    }
    out.put(static_cast<std::uint64_t>(map.regionClusters().size()));
    for (const auto& cluster : map.regionClusters()) {
      out.put(cluster.id.value);
      putIds(out, cluster.places);
    }
  });
}

void readClusters(const fs::path& file, Map& map) {
  readBinaryFile(file, "clusters", kVersion, [&](BinaryReader& in) {
    std::vector<scene_graph::ObjectCluster> objects(in.getCount(sizeof(std::uint64_t)));
    for (auto& cluster : objects) {
      cluster.id.value = in.get<std::uint64_t>();
      cluster.task = in.get<std::int32_t>();
      cluster.primitives = getIds<PrimitiveId>(in);
    }
    std::vector<scene_graph::RegionCluster> regions(in.getCount(sizeof(std::uint64_t)));
    for (auto& cluster : regions) {
      cluster.id.value = in.get<std::uint64_t>();
      cluster.places = getIds<PlaceId>(in);
    }
    map.setClusters(std::move(objects), std::move(regions));
  });
}

void writeMeshBlocks(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kMeshBlocksFile, "mesh blocks", kVersion, [&](BinaryWriter& out) {
    out.put(map.meshVoxelSize());
    out.put(static_cast<std::uint64_t>(map.meshBlocks().size()));
    for (const auto& block : map.meshBlocks()) {
      put(out, block.block);
      put(out, *block.mesh);
    }
  });
}

void readMeshBlocks(const fs::path& file, Map& map) {
  readBinaryFile(file, "mesh blocks", kVersion, [&](BinaryReader& in) {
    const auto voxel_size_m = in.get<double>();
    std::vector<mapping::BlockMesh> blocks(in.getCount(32));
    for (auto& block : blocks) {
      block.block = getIndex(in);
      block.mesh = std::make_shared<const Mesh>(getMesh(in));
    }
    map.setMesh(voxel_size_m, std::move(blocks));
  });
}

void writeTrajectoryState(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kTrajectoryFile, "trajectory", kVersion, [&](BinaryWriter& out) {
    out.put(static_cast<std::uint64_t>(map.trajectory()->size()));
    for (const auto& [ns, pose] : map.trajectory()->poses()) {
      out.put(ns);
      put(out, pose);
    }
  });
}

void readTrajectoryState(const fs::path& file, Map& map) {
  readBinaryFile(file, "trajectory", kVersion, [&](BinaryReader& in) {
    auto trajectory = std::make_shared<Trajectory>();
    for (std::size_t left = in.getCount(13 * sizeof(double)); left > 0; --left) {
      const Stamp stamp{in.get<std::int64_t>()};
      trajectory->add(stamp, getPose(in));
    }
    map.setTrajectory(std::move(trajectory));
  });
}

namespace {

using places::PlaceMemory;

void put(BinaryWriter& out, const places::CameraPose& pose) {
  out.put(pose.stamp.ns);
  put(out, pose.T_world_camera);
}

places::CameraPose getCameraPose(BinaryReader& in) {
  places::CameraPose pose;
  pose.stamp.ns = in.get<std::int64_t>();
  pose.T_world_camera = getPose(in);
  return pose;
}

void put(BinaryWriter& out, const places::WayMemory& way) {
  out.put(static_cast<std::uint64_t>(way.segments.size()));
  for (const auto& segment : way.segments) {
    out.putMatrix(segment.from_m);
    out.putMatrix(segment.to_m);
  }
  out.put(way.camera_height_m);
  out.putVector(way.height_counts);
  out.put(static_cast<std::uint8_t>(way.last ? 1 : 0));
  if (way.last) put(out, *way.last);
  out.put(static_cast<std::uint64_t>(way.waiting.size()));
  for (const auto& pose : way.waiting) put(out, pose);
}

places::WayMemory getWay(BinaryReader& in) {
  places::WayMemory way;
  way.segments.resize(in.getCount(6 * sizeof(double)));
  for (auto& segment : way.segments) {
    in.getMatrix(segment.from_m);
    in.getMatrix(segment.to_m);
    require((segment.to_m - segment.from_m).norm() < 1e3, "the way jumps");
  }
  way.camera_height_m = in.get<double>();
  way.height_counts = in.getVector<std::uint32_t>();
  if (in.get<std::uint8_t>() != 0) way.last = getCameraPose(in);
  way.waiting.resize(in.getCount(13 * sizeof(double)));
  for (auto& pose : way.waiting) pose = getCameraPose(in);
  return way;
}

void put(BinaryWriter& out, const places::View& view) {
  const CameraModel& camera = view.camera;
  out.put(static_cast<std::int32_t>(camera.width_px));
  out.put(static_cast<std::int32_t>(camera.height_px));
  for (const double value : {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}) {
    out.put(value);
  }
  put(out, view.T_camera_world);
  out.putVector(view.depth_mm);
  out.putMatrix(view.embedding);
}

places::View getView(BinaryReader& in) {
  places::View view;
  view.camera.width_px = in.get<std::int32_t>();
  view.camera.height_px = in.get<std::int32_t>();
  for (double* value :
       {&view.camera.fx_px, &view.camera.fy_px, &view.camera.cx_px, &view.camera.cy_px}) {
    *value = in.get<double>();
  }
  view.camera.validate();
  view.T_camera_world = getPose(in);
  view.depth_mm = in.getVector<std::uint16_t>();
  in.getMatrix(view.embedding);
  const auto countTiles = [](int size_px) {
    return (static_cast<std::size_t>(size_px) + places::View::kTile_px - 1) /
           places::View::kTile_px;
  };
  const std::size_t columns = countTiles(view.camera.width_px);
  view.tiles_per_row = static_cast<int>(columns);
  const std::size_t expected = columns * countTiles(view.camera.height_px);
  require(view.depth_mm.size() == expected, "a view has not one depth per tile");
  require(view.embedding.allFinite(), "a view's embedding is not finite");
  return view;
}

void put(BinaryWriter& out, const places::RememberedPlace& known) {
  put(out, known.place);
  put(out, known.key);
  out.put(static_cast<std::uint8_t>(known.views ? 1 : 0));
  if (!known.views) return;
  out.putMatrix(known.views->sum);
  out.put(known.views->weight);
  out.put(known.views->count);
  out.put(known.views->nearest_m);
}

places::RememberedPlace getRememberedPlace(BinaryReader& in) {
  places::RememberedPlace known;
  known.place = getPlace(in);
  known.key = getIndex(in);
  if (in.get<std::uint8_t>() == 0) return known;
  known.views.emplace();
  in.getMatrix(known.views->sum);
  known.views->weight = in.get<double>();
  known.views->count = in.get<std::uint32_t>();
  known.views->nearest_m = in.get<double>();
  return known;
}

void put(BinaryWriter& out, const places::GroundPlan& plan) {
  out.put(plan.cellSize());
  out.put(static_cast<std::uint64_t>(plan.tiles().size()));
  for (const auto& [index, tiles] : plan.tiles()) {
    out.put(static_cast<std::int32_t>(index.first));
    out.put(static_cast<std::int32_t>(index.second));
    out.put(static_cast<std::uint64_t>(tiles.size()));
    for (const auto& tile : tiles) {
      for (const places::PlanCell& cell : *tile) {
        out.put(static_cast<std::uint8_t>(cell.state));
        out.put(cell.floor_m + 0.0F);  // a floor at -0 is one at 0
        out.put(cell.clearance_m);
      }
    }
  }
}

places::GroundPlan::TilePtr getTile(BinaryReader& in) {
  auto tile = std::make_shared<places::GroundPlan::Tile>();
  for (places::PlanCell& cell : *tile) {
    const auto state = in.get<std::uint8_t>();
    require(state <= 2, "a cell of the plan has no state");
    cell.state = static_cast<places::PlanCell::State>(state);
    cell.floor_m = in.get<float>();
    cell.clearance_m = in.get<float>();
  }
  return tile;
}

places::GroundPlan getPlan(BinaryReader& in) {
  const auto cell_size_m = in.get<double>();
  require(isLength(cell_size_m), "the plan's cells have no size");
  places::GroundPlan plan(cell_size_m);
  for (std::size_t left = in.getCount(2 * sizeof(std::int32_t)); left > 0; --left) {
    const auto x = in.get<std::int32_t>();
    const auto y = in.get<std::int32_t>();
    require(std::abs(x / 2) < kMaxIndex && std::abs(y / 2) < kMaxIndex,
            "a tile of the plan is out of range");
    std::vector<places::GroundPlan::TilePtr> tiles(in.getCount(64 * 9));
    for (auto& tile : tiles) tile = getTile(in);
    plan.setTiles({x, y}, std::move(tiles));
  }
  return plan;
}

}  // namespace

void writePlaceMemory(const fs::path& folder, const Map& map) {
  writeBinaryFile(folder / kPlaceMemoryFile, "free space", kVersion, [&](BinaryWriter& out) {
    const PlaceMemory& memory = *map.placeMemory();
    out.put(memory.voxel_size_m);
    out.put(static_cast<std::uint64_t>(memory.blocks.size()));
    for (const auto& block : memory.blocks) {
      put(out, block.index);
      out.putBytes(block.distances_m.data(), sizeof(block.distances_m));
    }
    put(out, memory.way);
    out.put(static_cast<std::uint64_t>(memory.views.size()));
    for (const auto& view : memory.views) put(out, view);
    out.put(static_cast<std::uint64_t>(memory.places.size()));
    for (const auto& place : memory.places) put(out, place);
    out.put(memory.next_id);
    out.put(memory.stamp.ns);
    put(out, memory.plan);
  });
}

void readPlaceMemory(const fs::path& file, Map& map) {
  readBinaryFile(file, "free space", kVersion, [&](BinaryReader& in) {
    auto memory = std::make_shared<PlaceMemory>();
    memory->voxel_size_m = in.get<double>();
    require(memory->voxel_size_m == 0.0 || isLength(memory->voxel_size_m),
            "the voxels have no size");
    memory->blocks.resize(in.getCount(sizeof(places::VoxelBlock::distances_m)));
    for (auto& block : memory->blocks) {
      block.index = getIndex(in);
      in.getBytes(block.distances_m.data(), sizeof(block.distances_m));
    }
    memory->way = getWay(in);
    memory->views.resize(in.getCount(128));
    for (auto& view : memory->views) view = getView(in);
    memory->places.resize(in.getCount(56));
    for (auto& place : memory->places) place = getRememberedPlace(in);
    memory->next_id = in.get<std::uint64_t>();
    memory->stamp.ns = in.get<std::int64_t>();
    memory->plan = getPlan(in);
    map.setPlaceMemory(std::move(memory));
  });
}

}  // namespace tsg::map
