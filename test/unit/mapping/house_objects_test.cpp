// SPDX-License-Identifier: BSD-3-Clause
// Object boxes on the rendered house against the true boxes of its instances.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "sequence.h"
#include "support.h"
#include "task_scene_graph/mapping/object_reconstructor.h"

namespace tsg::mapping {
namespace {

constexpr int kFrames = 400;
constexpr int kFrameStep = 4;

struct Instance {
  std::uint16_t label = 0;
  std::string name;
  Aabb box;
  int largest_view_px = 0;
};

Eigen::Vector3d toVector(const nlohmann::json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

std::vector<Instance> loadInstances(const std::filesystem::path& file) {
  std::vector<Instance> instances;
  std::ifstream stream(file);
  for (const auto& entry : nlohmann::json::parse(stream)) {
    if (entry.at("kind") != "object" || entry.at("frames_400px").get<int>() < 20) continue;
    instances.push_back({entry.at("id").get<std::uint16_t>(), entry.at("name").get<std::string>(),
                         makeAabb(toVector(entry.at("aabb_min")), toVector(entry.at("aabb_max"))),
                         entry.at("max_pixels").get<int>()});
  }
  return instances;
}

/// Share of the box's extent that the points of the instance's pixels reach, on the worst axis.
double computeSeenShare(const Instance& instance, const Aabb& seen) {
  if (seen.isEmpty()) return 0.0;
  return (seen.sizes().array() / instance.box.sizes().array()).minCoeff();
}

struct SeenObject {
  Track track;
  std::vector<SegmentedFrame> frames;
  Aabb points;
};

void observe(const RgbdFramePtr& frame, const SegmentationPtr& segmentation,
             const Instance& instance, double max_range_m, SeenObject& object) {
  int pixels = 0;
  Aabb points;
  for (int v = 0; v < segmentation->labels.rows; ++v) {
    for (int u = 0; u < segmentation->labels.cols; ++u) {
      if (segmentation->labels.at<std::uint16_t>(v, u) != instance.label) continue;
      const double z_m = frame->depth.at(u, v);
      if (z_m <= 0.3 || z_m > max_range_m) continue;
      points.extend(frame->T_world_camera * frame->camera.unproject(u, v, z_m));
      ++pixels;
    }
  }
  if (pixels < 400) return;
  object.points.extend(points);
  object.track.observations.push_back({frame->stamp, instance.label});
  object.frames.push_back({frame, segmentation});
}

TEST(HouseObjects, BoxesOfFullySeenObjectsMatchTheTrueBoxes) {
  TSG_REQUIRE_SHARED(folder, "data/house_a");
  const auto instances = loadInstances(folder / "instances.json");
  const ObjectConfig config;
  std::vector<SeenObject> objects(instances.size());
  for (int i = 0; i < kFrames; i += kFrameStep) {
    const auto frame = std::make_shared<RgbdFrame>(test::loadSequenceFrame(folder, i));
    const auto segmentation = std::make_shared<Segmentation>();
    segmentation->labels = test::loadSequenceLabels(folder, i);
    for (std::size_t k = 0; k < instances.size(); ++k) {
      observe(frame, segmentation, instances[k], config.max_range_m, objects[k]);
    }
  }
  const ObjectReconstructor reconstructor(config);
  std::vector<double> overlaps;
  double seconds = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < instances.size(); ++k) {
    if (computeSeenShare(instances[k], objects[k].points) < 0.9) continue;
    const auto begin = std::chrono::steady_clock::now();
    const auto result = reconstructor.reconstruct(objects[k].track, objects[k].frames, {1});
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    ++count;
    const bool done = result.status == ReconstructionStatus::kReconstructed;
    overlaps.push_back(done ? computeIoU(result.primitive->box, instances[k].box) : 0.0);
    std::cout << instances[k].name << ": " << toString(result.status) << ", IoU " << overlaps.back()
              << " from " << objects[k].frames.size() << " frames, size "
              << instances[k].box.sizes().transpose() << "\n";
  }
  ASSERT_GE(overlaps.size(), 10U);
  std::sort(overlaps.begin(), overlaps.end());
  const double median = overlaps[overlaps.size() / 2];
  std::cout << "median IoU " << median << " of " << overlaps.size() << " objects, "
            << 1e3 * seconds / count << " ms per object\n";
  EXPECT_GE(median, 0.6);
}

}  // namespace
}  // namespace tsg::mapping
