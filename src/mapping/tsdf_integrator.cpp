// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/tsdf_integrator.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/parallel.h"
#include "tsdf_kernel.h"

namespace tsg::mapping {
namespace {

constexpr double kMaxCoordinate_m = 1e6;  // keeps voxel indices within 32 bits
constexpr std::size_t kBlocksPerTask = 16;

void requireConsistent(const IntegratorConfig& config) {
  std::vector<std::string> violations;
  const auto require = [&](bool ok, const std::string& name, double value,
                           const std::string& expected) {
    std::ostringstream text;
    text << name << " is " << value << ", expected " << expected;
    if (!ok) violations.push_back(text.str());
  };
  require(config.truncation_m >= 2.0 * config.voxel_size_m, "truncation_m", config.truncation_m,
          "at least 2 voxels of " + std::to_string(config.voxel_size_m) + " m");
  require(config.truncation_m > config.drop_off_start_voxels * config.voxel_size_m,
          "drop_off_start_voxels", config.drop_off_start_voxels,
          "less than the truncation of " + std::to_string(config.truncation_m) + " m");
  require(config.min_range_m < config.max_range_m, "min_range_m", config.min_range_m,
          "less than max_range_m, which is " + std::to_string(config.max_range_m));
  if (!violations.empty()) throw config::ConfigError("TSDF integrator", violations);
}

void requireVoxelSize(const TsdfVolume& volume, const IntegratorConfig& config) {
  if (volume.voxelSize() == config.voxel_size_m) return;
  std::ostringstream message;
  message << "the volume has voxels of " << volume.voxelSize() << " m, expected the integrator's "
          << config.voxel_size_m << " m";
  throw std::invalid_argument(message.str());
}

UpdateRule makeUpdateRule(const IntegratorConfig& config, const CameraModel& camera) {
  UpdateRule rule;
  rule.truncation_m = static_cast<float>(config.truncation_m);
  rule.drop_off_start_m = static_cast<float>(config.drop_off_start_voxels * config.voxel_size_m);
  const bool is_constant = config.weighting == Weighting::kConstant;
  const double voxel_area_px =
      camera.fx_px * camera.fy_px * config.voxel_size_m * config.voxel_size_m;
  rule.constant_weight = is_constant ? 1.0F : 0.0F;
  rule.weight_at_1m = is_constant ? 0.0F : static_cast<float>(voxel_area_px);
  rule.max_weight = static_cast<float>(config.max_weight);
  rule.max_range_m = static_cast<float>(config.max_range_m);
  return rule;
}

bool isObserved(const TsdfBlock& block) {
  return std::any_of(block.voxels.begin(), block.voxels.end(),
                     [](const TsdfVoxel& voxel) { return voxel.weight > 0.0F; });
}

}  // namespace

bool isBefore(const GridIndex& a, const GridIndex& b) {
  return std::make_tuple(a.z(), a.y(), a.x()) < std::make_tuple(b.z(), b.y(), b.x());
}

TsdfIntegrator::TsdfIntegrator(const IntegratorConfig& config) : config_(config) {
  config::validate(config, "TSDF integrator");
  requireConsistent(config);
}

IntegrationStatus TsdfIntegrator::readDepth(const RgbdFrame& frame) {
  if (frame.T_world_camera.translation().cwiseAbs().maxCoeff() > kMaxCoordinate_m) {
    return IntegrationStatus::kPoseOutOfRange;
  }
  const int tile_px = BlockSelector::computeTileSide(
      frame.camera, config_.voxel_size_m * kBlockSide, config_.max_range_m);
  // Far enough for every voxel in range to be free.
  const double beyond_m =
      config_.carve_free_space ? config_.max_range_m + 2.0 * config_.truncation_m : 0.0;
  depth_.assign(frame.depth, config_.min_range_m, config_.max_range_m, tile_px, beyond_m);
  return depth_.hasValidDepth() ? IntegrationStatus::kIntegrated : IntegrationStatus::kNoValidDepth;
}

std::vector<TsdfBlock*> TsdfIntegrator::allocateBlocks(const RgbdFrame& frame, TsdfVolume& volume) {
  const BlockSelector::Options options{config_.voxel_size_m * kBlockSide, config_.truncation_m,
                                       config_.min_range_m, config_.carve_free_space};
  const auto& selected = selector_.select(depth_, frame.camera, frame.T_world_camera, options);
  std::vector<TsdfBlock*> blocks;
  blocks.reserve(selected.size());
  for (const auto& index : selected) blocks.push_back(&volume.allocateBlock(index));
  std::sort(blocks.begin(), blocks.end(),
            [](const TsdfBlock* a, const TsdfBlock* b) { return isBefore(a->index, b->index); });
  return blocks;
}

IntegrationResult TsdfIntegrator::integrate(const RgbdFrame& frame, TsdfVolume& volume) {
  frame.validate();
  requireVoxelSize(volume, config_);
  IntegrationResult result;
  result.status = readDepth(frame);
  if (result.status != IntegrationStatus::kIntegrated) return result;
  const std::size_t blocks_before = volume.blocks().size();
  const std::vector<TsdfBlock*> blocks = allocateBlocks(frame, volume);

  const FrameView view(frame, depth_, config_.voxel_size_m, config_.with_color);
  const UpdateRule rule = makeUpdateRule(config_, frame.camera);
  std::vector<BlockUpdate> updates(blocks.size());
  const std::size_t tasks = (blocks.size() + kBlocksPerTask - 1) / kBlocksPerTask;
  parallelFor(tasks, config_.num_threads, [&](std::size_t task) {
    const std::size_t end = std::min(blocks.size(), (task + 1) * kBlocksPerTask);
    for (std::size_t i = task * kBlocksPerTask; i < end; ++i) {
      updates[i] = updateBlock(view, rule, config_.voxel_size_m, *blocks[i]);
    }
  });

  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const GridIndex index = blocks[i]->index;
    if (updates[i].observed > 0) result.observed_blocks.push_back(index);
    if (updates[i].changed > 0) result.changed_blocks.push_back(index);
    result.num_updated_voxels += static_cast<std::size_t>(updates[i].observed);
    if (updates[i].observed == 0 && !isObserved(*blocks[i])) volume.removeBlock(index);
  }
  result.num_new_blocks = volume.blocks().size() - blocks_before;
  return result;
}

}  // namespace tsg::mapping
