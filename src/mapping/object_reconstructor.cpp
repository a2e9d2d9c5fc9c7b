// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/mapping/object_reconstructor.h"

#include <algorithm>
#include <stdexcept>

#include "main_part.h"
#include "object_volume.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/mapping/marching_cubes.h"
#include "thumbnail.h"

namespace tsg::mapping {
namespace {

// Wide enough for the filters' windows and the truncation of any object of usual size.
constexpr double kFilterMargin_m = 0.25;

void requireFrames(const Track& track, const std::vector<SegmentedFrame>& frames) {
  if (frames.size() == track.observations.size()) return;
  throw std::invalid_argument("object reconstruction got " + std::to_string(frames.size()) +
                              " frames, expected " + std::to_string(track.observations.size()) +
                              ", one per observation");
}

/// `count` positions spread evenly over `size`, first and last among them.
std::vector<std::size_t> spread(std::size_t size, std::size_t count) {
  std::vector<std::size_t> positions;
  count = std::min(size, count);
  for (std::size_t i = 0; i < count; ++i) {
    positions.push_back(count == 1 ? size / 2 : i * (size - 1) / (count - 1));
  }
  return positions;
}

/// The observations whose frames are still there, evenly thinned out to max_frames.
std::vector<ObjectView> makeViews(const Track& track, const std::vector<SegmentedFrame>& frames,
                                  std::size_t max_frames) {
  std::vector<ObjectView> present;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].frame || !frames[i].segmentation) continue;
    present.emplace_back(*frames[i].frame, frames[i].segmentation->labels,
                         track.observations[i].segment);
  }
  std::vector<ObjectView> views;
  for (const std::size_t i : spread(present.size(), max_frames)) views.push_back(present[i]);
  return views;
}

ColorImage makeBestThumbnail(const Track& track, const std::vector<SegmentedFrame>& frames,
                             int max_side_px) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_best = track.observations[i].stamp == track.views.best.stamp &&
                         track.observations[i].segment == track.views.best.segment;
    if (is_best) return makeThumbnail(frames[i], track.views.best.segment, max_side_px);
  }
  return {};
}

/// Cuts the views to the object, drops doubtful depth and returns the extent of what is left.
Aabb prepareViews(const ObjectConfig& config, std::vector<ObjectView>& views) {
  const Aabb unfiltered = computeExtent(config, views);
  if (unfiltered.isEmpty() || config.depth_filter.isOff()) return unfiltered;
  DepthFilter filter(config.depth_filter);
  for (auto& view : views) {
    view.cropTo(unfiltered, kFilterMargin_m);
    view.frame.depth = filter.apply(view.frame.depth, view.frame.camera);
  }
  return computeExtent(config, views);
}

std::shared_ptr<ObjectPrimitive> makePrimitive(const Track& track, PrimitiveId id, Mesh mesh,
                                               const Aabb& box) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = id;
  primitive->track = track.id;
  primitive->mesh = std::move(mesh);
  primitive->box = box;
  primitive->oriented_box = computeOrientedBox(primitive->mesh.vertices);
  primitive->embedding = track.embedding;
  primitive->first_seen = track.first_seen;
  primitive->last_seen = track.last_seen;
  primitive->num_observations = static_cast<std::uint32_t>(track.observations.size());
  primitive->views = track.views;
  return primitive;
}

}  // namespace

const char* toString(ReconstructionStatus status) {
  switch (status) {
    case ReconstructionStatus::kReconstructed:
      return "reconstructed";
    case ReconstructionStatus::kTooFewObservations:
      return "too few observations";
    case ReconstructionStatus::kNoFrames:
      return "no frames";
    case ReconstructionStatus::kNoDepth:
      return "no depth";
    case ReconstructionStatus::kTooSmall:
      return "too small";
    case ReconstructionStatus::kTooLarge:
      return "too large";
    case ReconstructionStatus::kEmptyMesh:
      return "empty mesh";
    case ReconstructionStatus::kBadFrames:
      return "bad frames";
  }
  return "unknown";
}

ObjectReconstructor::ObjectReconstructor(const ObjectConfig& config) : config_(config) {
  config::validate(config, "object reconstruction");
  if (config.min_range_m >= config.max_range_m) {
    throw config::ConfigError(
        "object reconstruction",
        {"min_range_m is " + std::to_string(config.min_range_m) +
         ", expected less than max_range_m, which is " + std::to_string(config.max_range_m)});
  }
}

ReconstructionResult ObjectReconstructor::reconstruct(const Track& track, const FrameBuffer& frames,
                                                      PrimitiveId id) const {
  return reconstruct(track, frames.collect(track), id);
}

ReconstructionResult ObjectReconstructor::reconstruct(const Track& track,
                                                      const std::vector<SegmentedFrame>& frames,
                                                      PrimitiveId id) const {
  requireFrames(track, frames);
  if (track.observations.size() < static_cast<std::size_t>(config_.min_observations)) {
    return {ReconstructionStatus::kTooFewObservations, nullptr};
  }
  auto views = makeViews(track, frames, static_cast<std::size_t>(config_.max_frames));
  if (views.empty()) return {ReconstructionStatus::kNoFrames, nullptr};
  Aabb extent = prepareViews(config_, views);
  if (config_.min_part_share > 0.0) extent = keepMainPart(config_, extent, views);
  if (extent.isEmpty()) return {ReconstructionStatus::kNoDepth, nullptr};

  const double voxel_size_m =
      std::max(config_.resolution_fraction * extent.sizes().maxCoeff(), config_.min_voxel_size_m);
  ObjectVolume volume(config_, voxel_size_m);
  for (auto& view : views) view.cropTo(extent, volume.truncation());
  for (const auto& view : views) volume.allocate(view);
  for (const auto& view : views) volume.integrate(view);
  volume.removeBackground();

  Mesh mesh = computeMesh(volume.tsdf(), 0.0);
  if (mesh.isEmpty()) return {ReconstructionStatus::kEmptyMesh, nullptr};
  const Aabb box = mesh.computeBounds();
  if (computeVolume(box) < config_.min_volume_m3) return {ReconstructionStatus::kTooSmall, nullptr};
  if (computeVolume(box) > config_.max_volume_m3) return {ReconstructionStatus::kTooLarge, nullptr};
  auto primitive = makePrimitive(track, id, std::move(mesh), box);
  primitive->thumbnail = makeBestThumbnail(track, frames, config_.thumbnail_px);
  return {ReconstructionStatus::kReconstructed, std::move(primitive)};
}

}  // namespace tsg::mapping
