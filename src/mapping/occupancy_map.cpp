// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/occupancy_map.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/mapping/moved_voxels.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"

namespace tsg::mapping {
namespace {

constexpr int kCenterKey = 32768;  ///< of the voxel whose lowest corner is the world's origin

GridIndex toIndex(const octomap::OcTreeKey& key) {
  return {key[0] - kCenterKey, key[1] - kCenterKey, key[2] - kCenterKey};
}

/// Nothing outside the tree.
std::optional<octomap::OcTreeKey> toKey(const GridIndex& index) {
  const GridIndex key = index.array() + kCenterKey;
  if (key.minCoeff() < 0 || key.maxCoeff() >= 2 * kCenterKey) return std::nullopt;
  const auto cast = [](int value) { return static_cast<octomap::key_type>(value); };
  return octomap::OcTreeKey(cast(key.x()), cast(key.y()), cast(key.z()));
}

/// The blocks that voxels lie in, ascending.
std::vector<GridIndex> listBlocks(const std::vector<OccupancyVoxel>& voxels) {
  std::vector<GridIndex> blocks;
  for (const OccupancyVoxel& voxel : voxels) {
    const GridIndex block = TsdfVolume::computeBlockIndex(voxel.index);
    if (blocks.empty() || blocks.back() != block) blocks.push_back(block);
  }
  std::sort(blocks.begin(), blocks.end(), isBefore);
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

octomap::point3d toPoint(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

void sortByIndex(std::vector<OccupancyVoxel>& voxels) {
  std::sort(voxels.begin(), voxels.end(), [](const OccupancyVoxel& a, const OccupancyVoxel& b) {
    return isBefore(a.index, b.index);
  });
}

void requireConsistent(const OccupancyConfig& config) {
  config::validate(config, "occupancy map");
  if (config.min_range_m < config.max_range_m) return;
  std::ostringstream text;
  text << "min_range_m is " << config.min_range_m << ", expected less than max_range_m, which is "
       << config.max_range_m;
  throw config::ConfigError("occupancy map", {text.str()});
}

/// What OctoMap's own writers put before the data; they print to the terminal meanwhile.
void writeHeader(const octomap::OcTree& octree, bool is_binary, std::ostream& out) {
  out << "# Octomap OcTree " << (is_binary ? "binary " : "") << "file\n"
      << "# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      << "id " << octree.getTreeType() << "\nsize " << octree.size() << "\nres "
      << octree.getResolution() << "\ndata\n";
}

void requireSameResolution(const std::string& what, double found_m, double expected_m) {
  if (std::abs(found_m - expected_m) < 1e-9) return;
  std::ostringstream text;
  text << what << " has a resolution of " << found_m << " m, expected " << expected_m
       << " m (occupancy/resolution_m)";
  throw std::runtime_error(text.str());
}

}  // namespace

/// The octree, and what one frame says of it.
struct OccupancyMap::Tree {
  explicit Tree(double resolution_m) : octree(resolution_m) {}

  /// Precondition: both ends are in the tree (computeRayKeys() prints a warning otherwise).
  void castRay(const octomap::point3d& origin, const octomap::OcTreeKey& end) {
    octree.computeRayKeys(origin, octree.keyToCoord(end), ray);
    passed.insert(ray.begin(), ray.end());
  }

  /// False for a point outside the tree. OctoMap's own test turns any number into an int first.
  bool findKey(const Eigen::Vector3d& point_m, octomap::OcTreeKey& key) const {
    constexpr double kVoxels = 40000.0;  // in each direction; the tree has 32,768
    const double farthest = kVoxels * octree.getResolution();
    return (point_m.array().abs() < farthest).all() &&
           octree.coordToKeyChecked(toPoint(point_m), key);
  }

  octomap::OcTree octree;
  octomap::KeyRay ray;
  octomap::KeySet ends;      ///< voxels of readings in range
  octomap::KeySet far_ends;  ///< where rays of readings beyond the range stop
  octomap::KeySet passed;
};

OccupancyMap::OccupancyMap(const OccupancyConfig& config) : config_(config) {
  requireConsistent(config);
  tree_ = std::make_unique<Tree>(config.resolution_m);
  auto& octree = tree_->octree;
  octree.setProbHit(config.hit_probability);
  octree.setProbMiss(config.miss_probability);
  octree.setClampingThresMin(config.clamp_min_probability);
  octree.setClampingThresMax(config.clamp_max_probability);
  octree.enableChangeDetection(true);
}

OccupancyMap::OccupancyMap(const OccupancyMap& other)
    : config_(other.config_),
      counters_(other.counters_),
      tree_(std::make_unique<Tree>(*other.tree_)) {}

OccupancyMap::OccupancyMap(OccupancyMap&&) noexcept = default;

OccupancyMap& OccupancyMap::operator=(OccupancyMap&&) noexcept = default;

OccupancyMap::~OccupancyMap() = default;

OccupancyMap OccupancyMap::read(const std::filesystem::path& path, const OccupancyConfig& config) {
  requireFile("file", path);
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(path.string()));
  auto* octree = dynamic_cast<octomap::OcTree*>(read.get());
  if (octree == nullptr) {
    throw std::runtime_error("file '" + path.string() + "' is no OctoMap of type OcTree (.ot)");
  }
  requireSameResolution("file '" + path.string() + "'", octree->getResolution(),
                        config.resolution_m);
  OccupancyMap map(config);
  map.tree_->octree.swapContent(*octree);
  return map;
}

void OccupancyMap::addUnknown(const OccupancyMap& other, const Pose& T_this_other) {
  requireSameResolution("the other map", other.config_.resolution_m, config_.resolution_m);
  auto& octree = tree_->octree;
  for (const OccupancyVoxel& voxel : other.voxels()) {
    const Eigen::Vector3d center_m =
        (voxel.index.cast<double>().array() + 0.5) * config_.resolution_m;
    octomap::OcTreeKey key;
    if (!tree_->findKey(T_this_other * center_m, key) || octree.search(key) != nullptr) continue;
    octree.setNodeValue(key, voxel.is_occupied ? octree.getProbHitLog() : octree.getProbMissLog(),
                        true);
  }
  octree.updateInnerOccupancy();
  octree.prune();
}

OccupancyMap OccupancyMap::moved(
    const std::function<Pose(const Eigen::Vector3d& p_m)>& motion) const {
  OccupancyMap result(config_);
  result.counters_ = counters_;
  result.tree_->octree.enableChangeDetection(false);
  for (const GridIndex& block : listBlocks(voxels())) {
    forEachMovedVoxel(block, config_.resolution_m,
                      motion(computeBlockMiddle(block, config_.resolution_m)),
                      [&](const GridIndex& target, const GridIndex& source) {
                        result.addVoxel(target, *this, source);
                      });
  }
  result.tree_->octree.updateInnerOccupancy();
  result.tree_->octree.prune();
  result.tree_->octree.enableChangeDetection(true);
  return result;
}

void OccupancyMap::addVoxel(const GridIndex& voxel, const OccupancyMap& other,
                            const GridIndex& from) {
  const auto source = toKey(from);
  const auto target = toKey(voxel);
  if (!source || !target) return;
  const octomap::OcTreeNode* node = other.tree_->octree.search(*source);
  if (node == nullptr) return;
  const octomap::OcTreeNode* known = tree_->octree.search(*target);
  if (known != nullptr && known->getLogOdds() >= node->getLogOdds()) return;
  tree_->octree.setNodeValue(*target, node->getLogOdds(), true);
}

bool OccupancyMap::integrate(const RgbdFrame& frame) {
  frame.validate();
  tree_->ends.clear();
  tree_->far_ends.clear();
  tree_->passed.clear();
  collectRays(frame);
  if (tree_->ends.empty() && tree_->far_ends.empty()) {
    ++counters_.frames_without_depth;
    return false;
  }
  const octomap::point3d origin = toPoint(frame.T_world_camera.translation());
  for (const auto& end : tree_->ends) tree_->castRay(origin, end);
  for (const auto& end : tree_->far_ends) tree_->castRay(origin, end);
  for (const auto& key : tree_->passed) {
    if (tree_->ends.count(key) == 0) tree_->octree.updateNode(key, false);
  }
  for (const auto& key : tree_->ends) tree_->octree.updateNode(key, true);
  ++counters_.frames_integrated;
  return true;
}

void OccupancyMap::collectRays(const RgbdFrame& frame) {
  const Eigen::Vector3d origin_m = frame.T_world_camera.translation();
  for (int v = 0; v < frame.camera.height_px; v += config_.pixel_stride) {
    for (int u = 0; u < frame.camera.width_px; u += config_.pixel_stride) {
      const double z_m = frame.depth.at(u, v);
      if (z_m <= 0.0) continue;
      addRay(origin_m, frame.T_world_camera * frame.camera.unproject(u, v, z_m));
    }
  }
}

void OccupancyMap::addRay(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& end_m) {
  const double range_m = (end_m - origin_m).norm();
  if (range_m < config_.min_range_m) return;
  const bool is_beyond = range_m > config_.max_range_m;
  const Eigen::Vector3d stop_m =
      is_beyond ? Eigen::Vector3d(origin_m + (end_m - origin_m) * (config_.max_range_m / range_m))
                : end_m;
  octomap::OcTreeKey camera;
  octomap::OcTreeKey stop;
  if (!tree_->findKey(origin_m, camera) || !tree_->findKey(stop_m, stop)) {
    ++counters_.readings_out_of_tree;
    return;
  }
  (is_beyond ? tree_->far_ends : tree_->ends).insert(stop);
}

Occupancy OccupancyMap::at(const Eigen::Vector3d& point_m) const {
  octomap::OcTreeKey key;
  if (!tree_->findKey(point_m, key)) return Occupancy::kUnknown;
  return atVoxel(toIndex(key));
}

Occupancy OccupancyMap::atVoxel(const GridIndex& index) const {
  const auto key = toKey(index);
  if (!key) return Occupancy::kUnknown;
  const octomap::OcTreeNode* node = tree_->octree.search(*key);
  if (node == nullptr) return Occupancy::kUnknown;
  return tree_->octree.isNodeOccupied(node) ? Occupancy::kOccupied : Occupancy::kFree;
}

std::vector<OccupancyVoxel> OccupancyMap::takeChanges() {
  auto& octree = tree_->octree;
  std::vector<OccupancyVoxel> changes;
  changes.reserve(octree.numChangesDetected());
  for (auto entry = octree.changedKeysBegin(); entry != octree.changedKeysEnd(); ++entry) {
    const octomap::OcTreeNode* node = octree.search(entry->first);
    changes.push_back({toIndex(entry->first), octree.isNodeOccupied(node)});
  }
  octree.resetChangeDetection();
  sortByIndex(changes);
  return changes;
}

std::vector<OccupancyLeaf> OccupancyMap::leaves() const {
  std::vector<OccupancyLeaf> leaves;
  const auto& octree = tree_->octree;
  for (auto leaf = octree.begin_leafs(); leaf != octree.end_leafs(); ++leaf) {
    leaves.push_back(
        {{leaf.getX(), leaf.getY(), leaf.getZ()}, leaf.getSize(), octree.isNodeOccupied(*leaf)});
  }
  return leaves;
}

std::vector<OccupancyVoxel> OccupancyMap::voxels() const {
  std::vector<OccupancyVoxel> voxels;
  for (const auto& leaf : leaves()) {
    const Eigen::Vector3d lowest_m = leaf.center_m.array() - 0.5 * leaf.side_m;
    const GridIndex lowest = (lowest_m / config_.resolution_m).array().round().cast<int>().matrix();
    const auto side = static_cast<int>(std::lround(leaf.side_m / config_.resolution_m));
    for (int i = 0; i < side * side * side; ++i) {
      const GridIndex step(i % side, i / side % side, i / (side * side));
      voxels.push_back({lowest + step, leaf.is_occupied});
    }
  }
  sortByIndex(voxels);
  return voxels;
}

std::string OccupancyMap::serialize(bool binary) const {
  std::ostringstream stream(std::ios::binary);
  binary ? tree_->octree.writeBinaryData(stream) : tree_->octree.writeData(stream);
  return stream.str();
}

std::string OccupancyMap::serializeFile(bool binary) const {
  std::ostringstream stream(std::ios::binary);
  writeHeader(tree_->octree, binary, stream);
  binary ? tree_->octree.writeBinaryData(stream) : tree_->octree.writeData(stream);
  return stream.str();
}

void OccupancyMap::write(const std::filesystem::path& path) const {
  const bool is_binary = path.extension() == ".bt";
  if (!is_binary && path.extension() != ".ot") {
    throw std::invalid_argument("occupancy map: file '" + path.string() +
                                "' ends neither in .bt nor in .ot");
  }
  writeFileAtomically(path, [&](std::ostream& out) { out << serializeFile(is_binary); });
}

}  // namespace tsg::mapping
