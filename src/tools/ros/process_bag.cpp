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

#include "../../nodelets/chain_config.h"
#include "../command_line.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/pipeline/map_files.h"
#include "task_scene_graph/pipeline/pipeline.h"
#include "task_scene_graph/ros/rgbd_bag.h"
#include "task_scene_graph/ros/task_loader.h"

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
  std::string world_frame;
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
      "DIR gets scene_graph.json, summary.json, mesh.ply, settings.yaml and timing.json, and "
      "map.bt\n"
      "and map.ot where mesh_fusion/occupancy/enabled is set.\noptions");
  const auto text = [](std::string& value) {
    return options::value(&value)->default_value(value, value);
  };
  description.add_options()("help,h", "print this")("bag",
                                                    tools::pathOption(arguments.bag)->required(),
                                                    "rosbag with colour, depth, camera info, tf")(
      "object-tasks", tools::pathOption(arguments.object_tasks),
      "task file (YAML); default: the configuration's")(
      "place-tasks", tools::pathOption(arguments.place_tasks),
      "task file; default: the configuration's, else the object tasks")(
      "models", tools::pathOption(arguments.models),
      "model set (YAML); needed unless the bag holds recorded segmentations")(
      "config", tools::pathOption(arguments.config), "parameters, laid out as config/default.yaml")(
      "output", tools::pathOption(arguments.output),
      "folder, made if absent; default: the configuration's")(
      "max-frames", options::value(&arguments.max_frames), "stop after so many frames; 0 = all")(
      "ignore-recorded-segmentation", options::bool_switch(&arguments.ignore_recorded_segmentation),
      "use the models although the bag holds recorded segmentations")(
      "world-frame", options::value(&arguments.world_frame),
      "fixed frame of tf; default: the configuration's input/world_frame, else world")(
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

/// The user's file, and over it what the command line gives.
nodelets::ChainConfig loadConfig(const Arguments& arguments) {
  YAML::Node given(YAML::NodeType::Map);
  const auto give = [](YAML::Node map, const char* name, const std::string& value) {
    if (!value.empty()) map[name] = value;
  };
  give(given, "models", arguments.models);
  give(given, "output", arguments.output);
  give(given["input"], "world_frame", arguments.world_frame);
  give(given["scene_graph"], "object_tasks", arguments.object_tasks);
  give(given["scene_graph"], "place_tasks", arguments.place_tasks);
  auto chain =
      nodelets::loadChain({config::readConfigFile(arguments.config), {"command line", given, {}}});
  const auto require = [](const std::filesystem::path& path, const char* option) {
    if (!path.empty()) return;
    throw options::error(std::string("the option '") + option +
                         "' is required but missing, and the configuration does not say it");
  };
  require(chain.scene_graph.config.object_tasks, "--object-tasks");
  require(chain.scene_graph.config.output, "--output");
  return chain;
}

/// What is written of the drops: "150 frames (no pose)".
std::string describeDrops(const ros_interface::RgbdBag& bag) {
  std::string text;
  for (const auto& [reason, drops] : bag.drops()) {
    text += (text.empty() ? "" : "; ") + std::to_string(drops.count) + " dropped: " + reason +
            ", for instance " + drops.example;
  }
  return text;
}

void writeTiming(const fs::path& path, const pipeline::Pipeline& pipeline,
                 const ros_interface::RgbdBag& bag) {
  nlohmann::ordered_json json;
  for (const auto& [stage, times] : pipeline.times().summarize()) {
    json["stages"][stage] = {{"frames", times.count},
                             {"mean_ms", times.mean_ms},
                             {"p50_ms", times.p50_ms},
                             {"p95_ms", times.p95_ms},
                             {"max_ms", times.max_ms}};
  }
  json["drops"] = nlohmann::ordered_json::object();
  for (const auto& [reason, drops] : bag.drops()) json["drops"][reason] = drops.count;
  json["tracks_without_primitive"] = pipeline.objects().rejections();
  writeFileAtomically(path, [&](std::ostream& out) { out << json.dump(2) << "\n"; });
}

std::vector<config::YamlLine> describeRun(const Arguments& arguments, const std::string& models) {
  std::vector<config::YamlLine> lines{{"program", config::quoteYaml("process_bag"), ""},
                                      {"bag", config::quoteYaml(arguments.bag), ""}};
  if (!models.empty()) lines.push_back({"model_set", config::quoteYaml(models), ""});
  return lines;
}

std::vector<WrittenFile> writeFiles(const Arguments& arguments, const nodelets::ChainConfig& chain,
                                    const std::string& model_set, pipeline::Pipeline& pipeline,
                                    const scene_graph::SceneGraph& graph) {
  const fs::path& output = chain.scene_graph.config.output;
  std::vector<WrittenFile> files = pipeline::writeGraphFiles(output, graph);
  const auto& background = chain.mesh_fusion.config.background_fusion.background;
  files.push_back(pipeline::writeMeshFile(output, pipeline.extractMesh(), graph.primitives,
                                          scene_graph::computeObjectOfPrimitives(graph),
                                          background.tsdf.voxel_size_m, graph.world_frame));
  for (auto& file : pipeline::writeOccupancyFiles(output, pipeline.occupancy())) {
    files.push_back(std::move(file));
  }
  files.push_back(pipeline::writeSettingsFile(output, describeRun(arguments, model_set),
                                              nodelets::listSettings(chain)));
  return files;
}

void run(const Arguments& arguments) {
  const nodelets::ChainConfig chain = loadConfig(arguments);
  const auto& scene_graph_config = chain.scene_graph.config;
  const std::string models_path = scene_graph_config.models.string();
  std::optional<segmentation::ModelSet> models;
  if (!models_path.empty()) models = segmentation::loadModelSet(models_path);
  const pipeline::PipelineConfig config = nodelets::toPipelineConfig(chain);
  ros_interface::BagOptions bag_options = arguments.bag_options;
  bag_options.world_frame = chain.mesh_fusion.config.input.world_frame;
  bag_options.sync_tolerance_s = chain.mesh_fusion.config.input.sync_tolerance_s;
  ros_interface::RgbdBag bag(arguments.bag, bag_options);
  std::unique_ptr<segmentation::Segmenter> segmenter;
  if (!bag.hasRecordedSegmentation()) {
    if (!models) {
      throw std::runtime_error(
          "bag '" + arguments.bag + "' holds no recorded segmentation on '" +
          bag_options.topics.segmentation +
          "': give --models MODELS.yaml (see the README on where models come from)");
    }
    segmenter = std::make_unique<segmentation::Segmenter>(*models, config.segmenter);
  }
  const auto tasks =
      ros_interface::loadChainTasks(scene_graph_config.object_tasks.string(),
                                    scene_graph_config.place_tasks.string(), models_path);
  for (const auto& warning : tasks.warnings) std::cerr << warning << "\n";
  pipeline::Pipeline pipeline(config, tasks.objects, tasks.places, std::move(segmenter),
                              bag_options.world_frame);

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
    throw std::runtime_error("no map was written: no frame of bag '" + arguments.bag +
                             "' could be used (" + describeDrops(bag) + ")");
  }

  const scene_graph::SceneGraphPtr graph = pipeline.finish();
  std::vector<WrittenFile> files =
      writeFiles(arguments, chain, models ? models->name : "", pipeline, *graph);
  const fs::path& output = scene_graph_config.output;
  writeTiming(output / "timing.json", pipeline, bag);
  files.push_back({"timing.json", ""});
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
            << graph->regions.size() << " regions\n"
            << describeWritten(output, files) << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("process_bag", argc, argv, parseArguments, run);
}
