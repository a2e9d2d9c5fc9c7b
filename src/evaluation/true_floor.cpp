// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/true_floor.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>

#include "ply_file.h"
#include "task_scene_graph/core/point_index.h"

namespace tsg::evaluation {
namespace {

using places::GroundPlan;
using places::PlanCell;
using Index = GroundPlan::Index;

constexpr double kLevel_m = 0.01;  ///< surfaces are kept in such steps of height
constexpr double kMaxClearance_m = 5.0;
constexpr double kMaxCells = 1e8;

int toLevel(double z_m) { return static_cast<int>(std::lround(z_m / kLevel_m)); }
double toHeight(int level) { return level * kLevel_m; }

/// The heights at which a mesh has a surface, over each cell.
class SurfaceLevels {
 public:
  SurfaceLevels(const Mesh& mesh, double cell_m) : cell_m_(cell_m) {
    const Aabb bounds = mesh.computeBounds();
    min_ = toCell(bounds.min().head<2>().cast<double>());
    const Index max = toCell(bounds.max().head<2>().cast<double>());
    width_ = max.first - min_.first + 1;
    height_ = max.second - min_.second + 1;
    const double cells = static_cast<double>(width_) * static_cast<double>(height_);
    if (!(cells <= kMaxCells)) {
      throw std::invalid_argument("the true mesh covers " + std::to_string(cells) +
                                  " cells, expected at most 100 million");
    }
    columns_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    for (const auto& triangle : mesh.triangles) addTriangle(mesh, triangle);
    for (auto& column : columns_) {
      std::sort(column.begin(), column.end());
      column.erase(std::unique(column.begin(), column.end()), column.end());
    }
  }

  Index toCell(const Eigen::Vector2d& p_m) const {
    return {static_cast<int>(std::floor(p_m.x() / cell_m_)),
            static_cast<int>(std::floor(p_m.y() / cell_m_))};
  }

  /// Ascending; empty outside.
  const std::vector<int>& at(const Index& cell) const {
    static const std::vector<int> kNone;
    const int x = cell.first - min_.first;
    const int y = cell.second - min_.second;
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return kNone;
    return columns_[static_cast<std::size_t>(x) +
                    static_cast<std::size_t>(width_) * static_cast<std::size_t>(y)];
  }

 private:
  void addTriangle(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
    const Eigen::Vector3d a = mesh.vertices.at(triangle[0]).cast<double>();
    const Eigen::Vector3d ab = mesh.vertices.at(triangle[1]).cast<double>() - a;
    const Eigen::Vector3d ac = mesh.vertices.at(triangle[2]).cast<double>() - a;
    const double step_m = 0.5 * cell_m_;
    const double rows = std::max(1.0, std::ceil(ab.norm() / step_m));
    for (double i = 0.0; i <= rows; i += 1.0) {
      // Along the rest of the triangle at this share of ab.
      const double u = i / rows;
      const double columns = std::max(1.0, std::ceil((1.0 - u) * ac.norm() / step_m));
      for (double j = 0.0; j <= columns; j += 1.0)
        addPoint(a + u * ab + (1.0 - u) * (j / columns) * ac);
    }
  }

  void addPoint(const Eigen::Vector3d& p_m) {
    // Rounding may put a point of the rim just outside.
    const Index cell = toCell(p_m.head<2>());
    const int x = std::clamp(cell.first - min_.first, 0, width_ - 1);
    const int y = std::clamp(cell.second - min_.second, 0, height_ - 1);
    auto& column = columns_[static_cast<std::size_t>(x) +
                            static_cast<std::size_t>(width_) * static_cast<std::size_t>(y)];
    const int level = toLevel(p_m.z());
    if (column.empty() || column.back() != level) column.push_back(level);
  }

  double cell_m_;
  Index min_{0, 0};
  int width_ = 0;
  int height_ = 0;
  std::vector<std::vector<int>> columns_;
};

/// A cell of some floor.
struct FloorCell {
  Index index;
  int level = 0;
  bool is_free = false;
};

/// Walks over the floor from a cell.
class FloorWalk {
 public:
  FloorWalk(const SurfaceLevels& surface, const TrueFloorConfig& config)
      : surface_(surface),
        step_(toLevel(config.max_step_m)),
        body_(toLevel(config.body_height_m)) {}

  std::vector<FloorCell> run(const FloorCell& start) {
    std::deque<FloorCell> open{start};
    floors_[start.index].push_back(start);
    while (!open.empty()) {
      const FloorCell from = open.front();
      open.pop_front();
      for (const auto& [dx, dy] : {Index{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const FloorCell next = judge({from.index.first + dx, from.index.second + dy}, from.level);
        if (isNew(next) && next.is_free) open.push_back(next);
      }
    }
    std::vector<FloorCell> cells;
    for (const auto& [index, floors] : floors_)
      cells.insert(cells.end(), floors.begin(), floors.end());
    return cells;
  }

  /// Nothing is between a step and the body's height above a level.
  bool isStandable(const std::vector<int>& levels, int level) const {
    const auto above = std::upper_bound(levels.begin(), levels.end(), level + step_);
    return above == levels.end() || *above >= level + body_;
  }

 private:
  static constexpr int kNoFloor = -1000000;

  /// The cell as someone meets it who stands beside it; of level kNoFloor if nothing is there.
  FloorCell judge(const Index& index, int from_level) const {
    const std::vector<int>& levels = surface_.at(index);
    const auto begin = std::lower_bound(levels.begin(), levels.end(), from_level - step_);
    const auto end = std::upper_bound(levels.begin(), levels.end(), from_level + step_);
    for (auto level = end; level != begin;) {
      if (isStandable(levels, *--level)) return {index, *level, true};
    }
    const bool is_solid = begin != levels.end() && *begin < from_level + body_;
    return {index, is_solid ? from_level : kNoFloor, false};
  }

  /// Keeps the cell unless it is known; a free one takes the place of an obstacle.
  bool isNew(const FloorCell& cell) {
    if (cell.level == kNoFloor) return false;
    std::vector<FloorCell>& floors = floors_[cell.index];
    for (FloorCell& other : floors) {
      if (std::abs(other.level - cell.level) > step_) continue;
      if (other.is_free || !cell.is_free) return false;
      other = cell;
      return true;
    }
    floors.push_back(cell);
    return true;
  }

  const SurfaceLevels& surface_;
  int step_;
  int body_;
  std::map<Index, std::vector<FloorCell>> floors_;
};

FloorCell findStart(const SurfaceLevels& surface, const FloorWalk& walk,
                    const Eigen::Vector3d& start_m) {
  const Index index = surface.toCell(start_m.head<2>());
  const std::vector<int>& levels = surface.at(index);
  const auto above = std::upper_bound(levels.begin(), levels.end(), toLevel(start_m.z()));
  if (above == levels.begin() || !walk.isStandable(levels, *std::prev(above))) {
    throw std::invalid_argument("the true mesh has no free floor under the start (" +
                                std::to_string(start_m.x()) + ", " + std::to_string(start_m.y()) +
                                ", " + std::to_string(start_m.z()) +
                                "); are mesh and map in the same frame?");
  }
  return {index, *std::prev(above), true};
}

/// Tiles of one position: a cell goes to the first whose slot for it is empty and whose cells lie
/// at its height.
class TileStack {
 public:
  void add(const FloorCell& cell, const PlanCell& drawn) {
    const std::size_t offset = places::computeOffset(cell.index);
    for (Layer& layer : layers_) {
      const bool is_near = std::abs(layer.level - cell.level) < kNearLevels;
      if (!is_near || !std::isnan((*layer.tile)[offset].floor_m)) continue;
      (*layer.tile)[offset] = drawn;
      return;
    }
    layers_.push_back({cell.level, std::make_shared<GroundPlan::Tile>()});
    (*layers_.back().tile)[offset] = drawn;
  }

  std::vector<GroundPlan::TilePtr> tiles() const {
    std::vector<GroundPlan::TilePtr> tiles;
    for (const Layer& layer : layers_) tiles.push_back(layer.tile);
    return tiles;
  }

 private:
  static constexpr int kNearLevels = 100;

  struct Layer {
    int level = 0;  ///< of its first cell
    std::shared_ptr<GroundPlan::Tile> tile;
  };
  std::vector<Layer> layers_;
};

Eigen::Vector3d findCenter(const FloorCell& cell, double cell_m) {
  return {(cell.index.first + 0.5) * cell_m, (cell.index.second + 0.5) * cell_m,
          toHeight(cell.level)};
}

GroundPlan drawPlan(const std::vector<FloorCell>& cells, double cell_m) {
  std::vector<Eigen::Vector3d> obstacles_m;
  for (const FloorCell& cell : cells) {
    if (!cell.is_free) obstacles_m.push_back(findCenter(cell, cell_m));
  }
  const PointIndex obstacles(obstacles_m);
  std::map<Index, TileStack> stacks;
  for (const FloorCell& cell : cells) {
    PlanCell drawn;
    drawn.state = cell.is_free ? PlanCell::State::kFree : PlanCell::State::kObstacle;
    drawn.floor_m = static_cast<float>(toHeight(cell.level));
    if (cell.is_free) {
      const Eigen::Vector3d p_m = findCenter(cell, cell_m);
      double away_m = kMaxClearance_m;
      if (!obstacles.isEmpty()) {
        const Eigen::Vector3d offset_m = obstacles_m[obstacles.findNearest(p_m)] - p_m;
        away_m = std::min(away_m, offset_m.head<2>().norm() - 0.5 * cell_m);
      }
      drawn.clearance_m = static_cast<float>(std::max(0.0, away_m));
    }
    stacks[places::computeTile(cell.index)].add(cell, drawn);
  }
  GroundPlan plan(cell_m);
  for (const auto& [index, stack] : stacks) plan.setTiles(index, stack.tiles());
  return plan;
}

void addFace(const PlyFile& file, const std::vector<double>& corners, std::size_t row, Mesh& mesh) {
  std::vector<std::uint32_t> indices;
  for (const double corner : corners) {
    if (!(corner >= 0.0 && corner < static_cast<double>(mesh.vertices.size()))) {
      file.fail("face " + std::to_string(row) + " names vertex " + std::to_string(corner) + " of " +
                std::to_string(mesh.vertices.size()));
    }
    indices.push_back(static_cast<std::uint32_t>(corner));
  }
  for (std::size_t i = 2; i < indices.size(); ++i) {
    mesh.triangles.push_back({indices[0], indices[i - 1], indices[i]});
  }
}

void readFaces(PlyFile& file, const PlyElement& faces, Mesh& mesh) {
  const auto is_corners = [](const PlyProperty& property) {
    return property.name == "vertex_indices" || property.name == "vertex_index";
  };
  const auto found = std::find_if(faces.properties.begin(), faces.properties.end(), is_corners);
  if (found == faces.properties.end()) file.fail("face rows have no 'vertex_indices'");
  const auto corners = static_cast<std::size_t>(found - faces.properties.begin());
  PlyRow row;
  for (std::size_t i = 0; i < faces.count; ++i) {
    file.readRow(faces, i, row);
    addFace(file, row[corners], i, mesh);
  }
}

}  // namespace

Mesh loadMesh(const std::string& path) {
  PlyFile file(path);
  const PlyElement& vertices = file.vertices();
  const std::size_t x = file.findProperty(vertices, "x");
  const std::size_t y = file.findProperty(vertices, "y");
  const std::size_t z = file.findProperty(vertices, "z");
  Mesh mesh;
  PlyRow row;
  for (std::size_t i = 0; i < vertices.count; ++i) {
    file.readRow(vertices, i, row);
    const bool is_point = row[x].size() == 1 && row[y].size() == 1 && row[z].size() == 1 &&
                          std::isfinite(row[x][0] + row[y][0] + row[z][0]);
    if (!is_point) file.fail("vertex " + std::to_string(i) + " has a place that is no number");
    mesh.vertices.push_back(Eigen::Vector3d(row[x][0], row[y][0], row[z][0]).cast<float>());
  }
  for (std::size_t i = 1; i < file.elements().size(); ++i) {
    const PlyElement& element = file.elements()[i];
    if (element.name == "face") {
      readFaces(file, element, mesh);
      break;
    }
    for (std::size_t j = 0; j < element.count; ++j) file.readRow(element, j, row);
  }
  return mesh;
}

Mesh loadTrueMesh(const std::string& path) {
  Mesh mesh = loadMesh(path);
  if (mesh.isEmpty()) PlyFile(path).fail("has no faces, expected a mesh");
  return mesh;
}

places::GroundPlan computeTrueFloor(const Mesh& mesh, const Eigen::Vector3d& start_m,
                                    const TrueFloorConfig& config) {
  if (mesh.isEmpty()) throw std::invalid_argument("the true mesh is empty");
  const SurfaceLevels surface(mesh, config.cell_size_m);
  FloorWalk walk(surface, config);
  return drawPlan(walk.run(findStart(surface, walk, start_m)), config.cell_size_m);
}

}  // namespace tsg::evaluation
