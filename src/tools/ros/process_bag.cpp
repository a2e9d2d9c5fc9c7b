// SPDX-License-Identifier: BSD-3-Clause
// Runs the whole chain over a rosbag, without a clock: every frame, in order, the same result each
// time.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "../command_line.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/pipeline/map_files.h"
#include "task_scene_graph/pipeline/pipeline.h"
#include "task_scene_graph/ros/rgbd_bag.h"
#include "task_scene_graph/ros/task_loader.h"
#include "task_scene_graph/scene_graph/files.h"

namespace fs = std::filesystem;
namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string bag;
  std::string object_tasks;
  std::string place_tasks;
  std::string models;
  std::string config;
  std::string output;
  std::size_t max_frames = 0;
  bool ignore_recorded_segmentation = false;
  ros_interface::BagOptions bag_options;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  auto& topics = arguments.bag_options.topics;
  options::options_description description(
      "Builds the scene graph of a recorded walk.\n"
      "usage: process_bag --bag B --object-tasks T --output DIR [options]\n"
      "DIR gets scene_graph.json, summary.json, mesh.ply and timing.json, and map.bt and map.ot\n"
      "where mesh_fusion/occupancy/enabled is set.\noptions");
  const auto text = [](std::string& value) {
    return options::value(&value)->default_value(value, value);
  };
  description.add_options()("help,h", "print this")("bag",
                                                    options::value(&arguments.bag)->required(),
                                                    "rosbag with colour, depth, camera info, tf")(
      "object-tasks", options::value(&arguments.object_tasks)->required(), "task file (YAML)")(
      "place-tasks", options::value(&arguments.place_tasks),
      "task file; default: the object tasks")(
      "models", options::value(&arguments.models),
      "model set (YAML); needed unless the bag holds recorded segmentations")(
      "config", options::value(&arguments.config), "parameters, laid out as config/default.yaml")(
      "output", options::value(&arguments.output)->required(), "folder, made if absent")(
      "max-frames", options::value(&arguments.max_frames), "stop after so many frames; 0 = all")(
      "ignore-recorded-segmentation", options::bool_switch(&arguments.ignore_recorded_segmentation),
      "use the models although the bag holds recorded segmentations")(
      "world-frame", text(arguments.bag_options.world_frame), "fixed frame of tf")(
      "color-topic", text(topics.color), "8-bit colour images")(
      "depth-topic", text(topics.depth), "registered depth: 16UC1 mm or 32FC1 m")(
      "camera-info-topic", text(topics.camera_info), "intrinsics")(
      "segmentation-topic", text(topics.segmentation), "recorded segmentations");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  arguments.bag_options.use_recorded_segmentation = !arguments.ignore_recorded_segmentation;
  return arguments;
}

/// One line on a terminal; nothing where the output goes to a file.
class ProgressBar {
 public:
  explicit ProgressBar(std::size_t total)
      : total_(total), is_terminal_(isatty(STDERR_FILENO) == 1) {}
  ~ProgressBar() {
    if (is_terminal_) std::fprintf(stderr, "\n");
  }

  void show(std::size_t done) const {
    if (!is_terminal_ || total_ == 0) return;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const std::size_t filled = 40 * done / total_;
    std::fprintf(stderr, "\r[%s%s] %zu/%zu frames, %.1f per second ",
                 std::string(filled, '#').c_str(), std::string(40 - filled, ' ').c_str(), done,
                 total_, static_cast<double>(done) / std::max(seconds, 1e-3));
  }

 private:
  std::size_t total_;
  bool is_terminal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

pipeline::PipelineConfig loadConfig(const Arguments& arguments,
                                    const std::optional<segmentation::ModelSet>& models) {
  pipeline::PipelineConfig defaults;
  if (models) defaults.scene_graph.object_alpha = models->alpha;
  if (arguments.config.empty()) return defaults;
  return config::load<pipeline::PipelineConfig>(
      config::loadYamlFile(arguments.config), "configuration '" + arguments.config + "'", defaults);
}

void writeTiming(const fs::path& path, const pipeline::Pipeline& pipeline,
                 const ros_interface::RgbdBag& bag) {
  nlohmann::json json;
  for (const auto& [stage, times] : pipeline.times().summarize()) {
    json["stages"][stage] = {{"frames", times.count},
                             {"mean_ms", times.mean_ms},
                             {"p50_ms", times.p50_ms},
                             {"p95_ms", times.p95_ms},
                             {"max_ms", times.max_ms}};
  }
  json["drops"] = nlohmann::json::object();
  for (const auto& [reason, drops] : bag.drops()) json["drops"][reason] = drops.count;
  json["tracks_without_primitive"] = pipeline.objects().rejections();
  writeFileAtomically(path, [&](std::ostream& out) { out << json.dump(2) << "\n"; });
}

void run(const Arguments& arguments) {
  std::optional<segmentation::ModelSet> models;
  if (!arguments.models.empty()) models = segmentation::loadModelSet(arguments.models);
  const pipeline::PipelineConfig config = loadConfig(arguments, models);
  ros_interface::RgbdBag bag(arguments.bag, arguments.bag_options);
  std::unique_ptr<segmentation::Segmenter> segmenter;
  if (!bag.hasRecordedSegmentation()) {
    if (!models) {
      throw std::runtime_error(
          "bag '" + arguments.bag + "' holds no recorded segmentation on '" +
          arguments.bag_options.topics.segmentation +
          "': give --models MODELS.yaml (see the README on where models come from)");
    }
    segmenter = std::make_unique<segmentation::Segmenter>(*models, config.segmenter);
  }
  const auto object_tasks = ros_interface::loadTaskList(arguments.object_tasks, arguments.models);
  const auto place_tasks =
      arguments.place_tasks.empty()
          ? object_tasks
          : ros_interface::loadTaskList(arguments.place_tasks, arguments.models);
  pipeline::Pipeline pipeline(config, object_tasks, place_tasks, std::move(segmenter));

  const ProgressBar progress(bag.numColorImages());
  std::size_t num_frames = 0;
  bag.forEachFrame(
      [&](const RgbdFramePtr& frame, const SegmentationPtr& recorded) {
        if (arguments.max_frames != 0 && num_frames >= arguments.max_frames) return;
        ++num_frames;
        pipeline.process(frame, recorded);
      },
      [&](std::size_t num_read) { progress.show(num_read); });
  if (num_frames == 0) {
    std::string reasons;
    for (const auto& [reason, drops] : bag.drops()) {
      reasons += "\n  " + reason + ", " + std::to_string(drops.count) + " frames: " + drops.example;
    }
    throw std::runtime_error("no frame of bag '" + arguments.bag + "' could be used:" + reasons);
  }

  const scene_graph::SceneGraphPtr graph = pipeline.finish();
  const fs::path output = arguments.output;
  scene_graph::writeSparkDsg(output / "scene_graph.json", *graph);
  scene_graph::writeSummary(output / "summary.json", *graph);
  pipeline::writeMeshFile(output, pipeline.extractMesh(), graph->primitives,
                          scene_graph::computeObjectOfPrimitives(*graph),
                          config.mesh_fusion.background_fusion.background.tsdf.voxel_size_m);
  pipeline::writeOccupancyFiles(output, pipeline.occupancy());
  writeTiming(output / "timing.json", pipeline, bag);
  for (const auto& [reason, drops] : bag.drops()) {
    std::cerr << "dropped " << drops.count << " (" << reason << "): " << drops.example << "\n";
  }
  if (graph->places->places.empty()) {
    std::cerr << "no places: no floor to walk on was seen; where the world's z is not up (see"
                 " dataset_to_bag --world-up) or the camera sees no floor, set"
                 " mesh_fusion/places/free_space: volume\n";
  }
  std::cout << num_frames << " frames, " << graph->primitives.size() << " object primitives, "
            << graph->objects.size() << " objects, " << graph->places->places.size() << " places, "
            << graph->regions.size() << " regions; written to " << output.string() << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("process_bag", argc, argv, parseArguments, run);
}
