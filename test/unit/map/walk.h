// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>

#include "synthetic_scene.h"
#include "task_scene_graph/pipeline/pipeline.h"

/// A robot that walks through a room with a red and a blue box, all in closed form.
namespace tsg::test {

constexpr int kWalkSize = 4;     ///< of embeddings; e0: red box, e1: blue box, e2: room
constexpr int kWalkFrames = 80;  ///< red box, turn, blue box, turn

inline std::vector<Solid> makeWalkRoom() {
  const cv::Vec3b wall(200, 190, 170);
  return {makePlane({0, 0, 0}, {0, 0, 1}, {120, 120, 110}),
          makePlane({0, 0, 2.5}, {0, 0, -1}, {230, 230, 230}),
          makePlane({3, 0, 0}, {-1, 0, 0}, wall),
          makePlane({-3, 0, 0}, {1, 0, 0}, wall),
          makePlane({0, 3, 0}, {0, -1, 0}, wall),
          makePlane({0, -3, 0}, {0, 1, 0}, wall),
          makeBox(makeAabb({1.4, 0.6, 0.0}, {2.0, 1.2, 0.7}), {210, 30, 30}, 1),
          makeBox(makeAabb({1.4, -1.4, 0.0}, {2.0, -0.8, 0.7}), {30, 30, 210}, 2)};
}

/// Both boxes are in view, the robot walks along a circle of 0.8 m and looks at where they stand;
/// every second quarter it turns about itself.
inline Pose computeWalkPose(int index) {
  const int quarter = index / (kWalkFrames / 4);
  const double along = (index % (kWalkFrames / 4)) / (kWalkFrames / 4.0);
  const double side_m = -0.8 + 0.4 * (quarter / 2) + 0.4 * along;
  const Eigen::Vector3d eye(-1.2 + 0.2 * side_m, side_m, 1.3);
  if (quarter % 2 == 0) return lookAt(eye, {1.7, -0.1, 0.2});
  const double angle_rad = 2.0 * M_PI * along;
  return lookAt(eye, eye + Eigen::Vector3d(2 * std::cos(angle_rad), 2 * std::sin(angle_rad), -0.8));
}

struct WalkFrame {
  RgbdFramePtr frame;
  SegmentationPtr segmentation;
};

/// @param T_map_world  the robot's coordinates: of its map less those of the room
inline WalkFrame makeWalkFrame(int index, double start_s = 100.0,
                               const Pose& T_map_world = Pose::Identity()) {
  const CameraModel camera{96, 72, 75.0, 75.0, 47.5, 35.5};
  const Rendering rendering = render(makeWalkRoom(), camera, computeWalkPose(index));
  auto frame = std::make_shared<RgbdFrame>(rendering.frame);
  frame->stamp = Stamp::fromSeconds(start_s + 0.1 * index);
  frame->T_world_camera = T_map_world * frame->T_world_camera;
  auto segmentation = std::make_shared<Segmentation>();
  segmentation->stamp = frame->stamp;
  segmentation->labels = rendering.labels;
  segmentation->embeddings = EmbeddingMatrix::Identity(2, kWalkSize);
  segmentation->confidences = {0.9F, 0.9F};
  segmentation->image_embedding = Embedding::Unit(kWalkSize, 2);
  return {frame, segmentation};
}

inline scene_graph::TaskList makeWalkTasks() {
  return {{"red", "blue", "room"}, EmbeddingMatrix::Identity(3, kWalkSize)};
}

inline std::unique_ptr<pipeline::Pipeline> makePipeline(bool with_occupancy = false) {
  pipeline::PipelineConfig config;
  config.mesh_fusion.background_fusion.occupancy.enabled = with_occupancy;
  return std::make_unique<pipeline::Pipeline>(config, makeWalkTasks(), makeWalkTasks(), nullptr,
                                              "odom");
}

inline void walk(pipeline::Pipeline& pipeline, int first, int end,
                 const Pose& T_map_world = Pose::Identity(), double start_s = 100.0) {
  for (int i = first; i < end; ++i) {
    const WalkFrame walked = makeWalkFrame(i, start_s, T_map_world);
    pipeline.process(walked.frame, walked.segmentation);
  }
}

inline map::MapPtr makeWalkMap(int first, int end, bool with_occupancy = false,
                               const Pose& T_map_world = Pose::Identity(), double start_s = 100.0) {
  const auto pipeline = makePipeline(with_occupancy);
  walk(*pipeline, first, end, T_map_world, start_s);
  return pipeline->finish();
}

/// Content of all files below a folder by their names.
inline std::map<std::string, std::string> readFolder(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    files[entry.path().lexically_relative(folder).generic_string()] = {
        std::istreambuf_iterator<char>(stream), {}};
  }
  return files;
}

/// "" if each object of a map has one of the same task in the other whose box overlaps with an IoU
/// of `least`, and none is left over; else what is different.
inline std::string compareObjects(const scene_graph::SceneGraph& a,
                                  const scene_graph::SceneGraph& b, double least) {
  std::string text;
  const auto look = [&](const auto& from, const auto& in, const char* where) {
    for (const auto& object : from.objects) {
      double best = 0.0;
      for (const auto& other : in.objects) {
        if (other.task == object.task) best = std::max(best, computeIoU(object.box, other.box));
      }
      if (best >= least) continue;
      text += object.task + " O" + std::to_string(object.id.value) + " has at most " +
              std::to_string(best) + " in " + where + "; ";
    }
  };
  look(a, b, "the second");
  look(b, a, "the first");
  return text;
}

}  // namespace tsg::test
