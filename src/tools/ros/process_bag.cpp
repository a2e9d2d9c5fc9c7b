// SPDX-License-Identifier: BSD-3-Clause
// Runs the whole chain over a rosbag, without a clock: every frame, in order, the same result each
// time.
#include <ros/package.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "../../nodelets/chain_config.h"
#include "../command_line.h"
#include "../saved_map.h"
#include "input_options.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/pipeline/pipeline.h"
#include "task_scene_graph/plausibility/embedding_checks.h"
#include "task_scene_graph/ros/input_plausibility_report.h"
#include "task_scene_graph/ros/rgbd_bag.h"
#include "task_scene_graph/ros/task_loader.h"

namespace fs = std::filesystem;
namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::vector<std::string> bags;
  std::string preset;
  std::string object_tasks;
  std::string place_tasks;
  std::string models;
  std::string config;
  std::string output;
  std::string map;
  std::size_t max_frames = 0;
  bool ignore_recorded_segmentation = false;
  tools::InputOptions input;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  options::options_description description(
      "Builds the scene graph of a recorded walk.\n"
      "usage: process_bag --bag B [B2 ...] --object-tasks T --output DIR [options]\n"
      "DIR gets scene_graph.json, summary.json, mesh.ply, settings.yaml and timing.json, and\n"
      "map.bt and map.ot where mesh_fusion/occupancy/enabled is set.\noptions");
  description.add_options()("help,h", "print this")(
      "bag", options::value(&arguments.bags)->required()->multitoken(),
      "rosbags with colour, depth, camera info, tf; several are read as one")(
      "object-tasks", tools::pathOption(arguments.object_tasks),
      "task file (YAML); default: the configuration's")(
      "place-tasks", tools::pathOption(arguments.place_tasks),
      "task file; default: the configuration's, else the object tasks")(
      "models", tools::pathOption(arguments.models),
      "model set (YAML); needed unless the bag holds recorded segmentations")(
      "config", tools::pathOption(arguments.config), "parameters, laid out as config/default.yaml")(
      "preset", options::value(&arguments.preset),
      "what is known of a published dataset: clio_dataset; or a file laid out as --config, which "
      "comes before it")("output", tools::pathOption(arguments.output),
                         "folder, made if absent; default: the configuration's")(
      "map", tools::pathOption(arguments.map),
      "folder of a saved map to go on from; default: the configuration's, else none")(
      "max-frames", options::value(&arguments.max_frames), "stop after so many frames; 0 = all")(
      "ignore-recorded-segmentation", options::bool_switch(&arguments.ignore_recorded_segmentation),
      "use the models although the bag holds recorded segmentations");
  options::options_description input("input: these win over section `input` of --config");
  arguments.input.addTo(input);
  description.add(input);
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  for (auto& bag : arguments.bags) bag = expandPath(bag).string();
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

/// A preset's file: a path, or a name in config/presets of the package.
std::string findPreset(const std::string& name) {
  if (fs::exists(name)) return name;
  const std::string file = name + ".yaml";
  const std::string package = ros::package::getPath("task_scene_graph");
  const fs::path path = fs::path(package) / "config" / "presets" / file;
  if (!package.empty() && fs::exists(path)) return path.string();
  throw std::runtime_error("--preset '" + name + "': neither a file nor one of config/presets (" +
                           path.string() + ")");
}

/// The preset, over it the user's file, and over that what the command line gives.
nodelets::ChainConfig loadConfig(const Arguments& arguments) {
  YAML::Node given(YAML::NodeType::Map);
  const auto give = [](YAML::Node map, const char* name, const std::string& value) {
    if (!value.empty()) map[name] = value;
  };
  give(given, "models", arguments.models);
  give(given, "output", arguments.output);
  give(given, "map", arguments.map);
  given["input"] = arguments.input.toYaml();
  give(given["scene_graph"], "object_tasks", arguments.object_tasks);
  give(given["scene_graph"], "place_tasks", arguments.place_tasks);
  std::vector<config::Source> sources;
  if (!arguments.preset.empty()) {
    sources.push_back(config::readConfigFile(findPreset(arguments.preset)));
  }
  sources.push_back(config::readConfigFile(arguments.config));
  sources.push_back({"command line", given, {}});
  auto chain = nodelets::loadChain(sources);
  const auto require = [](const std::filesystem::path& path, const char* option) {
    if (!path.empty()) return;
    throw options::error(std::string("the option '") + option +
                         "' is required but missing, and the configuration does not say it");
  };
  require(chain.scene_graph.config.object_tasks, "--object-tasks");
  require(chain.scene_graph.config.output, "--output");
  return chain;
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

std::unique_ptr<segmentation::Segmenter> makeSegmenter(
    const ros_interface::RgbdBag& bag, const std::optional<segmentation::ModelSet>& models,
    const segmentation::SegmenterConfig& config) {
  if (bag.hasRecordedSegmentation()) return nullptr;
  if (!models) {
    throw std::runtime_error("no recorded segmentation on '" + bag.segmentationTopic() +
                             "': give --models MODELS.yaml (see the README on where models come "
                             "from), or --segmentation-topic");
  }
  return std::make_unique<segmentation::Segmenter>(*models, config);
}

/// Says what looks wrong with the input, each thing once.
class Findings {
 public:
  Findings(const ros_interface::RgbdBag& bag, const nodelets::ChainConfig& config)
      : bag_(bag),
        report_(toRange(config.mesh_fusion.config.background_fusion.background.tsdf),
                config.mesh_fusion.config.input.sync_tolerance_s) {}

  void addFrame(const RgbdFrame& frame) {
    report_.addFrame(frame);
    if (++num_frames_ == kFirstLook) print();
  }
  void print() {
    for (const auto& [key, text] : report_.makeReport(bag_.counters(), bag_.frameIds())) {
      print(key, text);
    }
  }
  /// What looks wrong with the embeddings.
  void print(const pipeline::Pipeline& pipeline, const scene_graph::SceneGraph& graph,
             const tracking::TrackerConfig& tracker) {
    auto findings = plausibility::checkGraph(pipeline.sceneGraph(), graph);
    if (const auto finding = plausibility::checkTracker(pipeline.tracker().counters(), tracker)) {
      findings.push_back(*finding);
    }
    for (const auto& finding : findings) print(finding.check, plausibility::toText(finding));
  }

 private:
  static plausibility::PlausibilityConfig toRange(const mapping::IntegratorConfig& tsdf) {
    return {tsdf.min_range_m, tsdf.max_range_m};
  }
  void print(const std::string& key, const std::string& text) {
    if (printed_.insert(key).second) std::cerr << "plausibility: " << text << "\n";
  }
  static constexpr int kFirstLook = 100;  ///< frames: a few seconds

  const ros_interface::RgbdBag& bag_;
  ros_interface::InputPlausibilityReport report_;
  std::set<std::string> printed_;
  int num_frames_ = 0;
};

std::size_t processFrames(ros_interface::RgbdBag& bag, pipeline::Pipeline& pipeline,
                          Findings& findings, std::size_t max_frames) {
  const ProgressBar progress(bag.numColorImages());
  std::size_t num_frames = 0;
  bag.forEachFrame(
      [&](const RgbdFramePtr& frame, const SegmentationPtr& recorded) {
        findings.addFrame(*frame);
        pipeline.process(frame, recorded);
        return ++num_frames != max_frames;
      },
      [&](std::size_t num_read) { progress.show(num_read); });
  return num_frames;
}

std::string describeDrops(const ros_interface::RgbdBag& bag) {
  std::string text;
  for (const auto& [reason, drops] : bag.drops()) {
    text += "\n  " + reason + ", " + std::to_string(drops.count) + ": " + drops.example;
  }
  return text;
}

/// A YAML list of strings.
std::string quoteAll(const std::vector<std::string>& texts) {
  std::string list;
  for (const auto& text : texts) list += (list.empty() ? "" : ", ") + config::quoteYaml(text);
  return "[" + list + "]";
}

std::vector<config::YamlLine> describeRun(const Arguments& arguments, const std::string& models) {
  std::vector<config::YamlLine> lines{{"program", config::quoteYaml("process_bag"), ""},
                                      {"bag", quoteAll(arguments.bags), ""}};
  if (!models.empty()) lines.push_back({"model_set", config::quoteYaml(models), ""});
  return lines;
}

std::vector<WrittenFile> writeFiles(const Arguments& arguments, const nodelets::ChainConfig& chain,
                                    const std::string& model_set, map::Map map) {
  const fs::path& output = chain.scene_graph.config.output;
  map.setSettings({model_set, map.settings().scene_graph, nodelets::listSettings(chain),
                   describeRun(arguments, model_set)});
  return map::writeMap(output, map);
}

/// Loads a map that was made with what is used now.
void goOn(const fs::path& folder, const nodelets::ChainConfig& chain,
          const std::optional<segmentation::ModelSet>& models, const scene_graph::TaskList& tasks,
          pipeline::Pipeline& pipeline) {
  const auto& fusion = chain.mesh_fusion.config.background_fusion;
  map::MapUse use;
  use.world_frame = chain.mesh_fusion.config.input.world_frame;
  if (models) use.model_set = models->name;
  use.embedding_size = tasks.embeddings.cols();
  use.mesh_voxel_size_m = fusion.background.tsdf.voxel_size_m;
  use.free_space_voxel_size_m = fusion.free_space.tsdf.voxel_size_m;
  map::Map map = tools::loadMap(folder.string(), use);
  if (fusion.occupancy.enabled) map.setOccupancy(map::readOccupancy(folder, fusion.occupancy));
  pipeline.restore(map);
}

void run(const Arguments& arguments) {
  const nodelets::ChainConfig chain = loadConfig(arguments);
  const auto& scene_graph_config = chain.scene_graph.config;
  const std::string models_path = scene_graph_config.models.string();
  std::optional<segmentation::ModelSet> models;
  if (!models_path.empty()) models = segmentation::loadModelSet(models_path);
  const pipeline::PipelineConfig config = nodelets::toPipelineConfig(chain);
  const ros_interface::InputConfig& input = chain.mesh_fusion.config.input;
  ros_interface::RgbdBag bag(arguments.bags, input, !arguments.ignore_recorded_segmentation);
  auto segmenter = makeSegmenter(bag, models, config.segmenter);
  language::WordEncoder encoder(models_path);
  const auto tasks = ros_interface::loadChainTasks(
      scene_graph_config.object_tasks.string(), scene_graph_config.place_tasks.string(), encoder);
  for (const auto& warning : tasks.warnings) std::cerr << warning << "\n";
  pipeline::Pipeline pipeline(config, tasks.objects, tasks.places, std::move(segmenter),
                              input.world_frame);

  if (!scene_graph_config.map.empty()) {
    goOn(scene_graph_config.map, chain, models, tasks.objects, pipeline);
  }

  Findings findings(bag, chain);
  const std::size_t num_frames = processFrames(bag, pipeline, findings, arguments.max_frames);
  findings.print();
  for (const auto& warning : bag.warnings()) std::cerr << "warning: " << warning << "\n";
  if (num_frames == 0) {
    throw std::runtime_error("no map was written: none of " + std::to_string(bag.numColorImages()) +
                             " colour images could be used:" + describeDrops(bag));
  }

  const map::MapPtr map = pipeline.finish();
  const scene_graph::SceneGraph graph = map::computeSceneGraph(*map);
  findings.print(pipeline, graph, config.tracker);
  std::vector<WrittenFile> files = writeFiles(arguments, chain, models ? models->name : "", *map);
  const fs::path& output = scene_graph_config.output;
  writeTiming(output / "timing.json", pipeline, bag);
  files.push_back({"timing.json", ""});
  for (const auto& [reason, drops] : bag.drops()) {
    std::cerr << "dropped " << drops.count << " (" << reason << "): " << drops.example << "\n";
  }
  if (graph.places->places.empty()) {
    std::cerr << "no places: no floor to walk on was seen; where the world's z is not up (see"
                 " dataset_to_bag --world-up) or the camera sees no floor, set"
                 " mesh_fusion/places/free_space: volume\n";
  }
  std::cout << num_frames << " frames, " << graph.primitives.size() << " object primitives, "
            << graph.objects.size() << " objects, " << graph.places->places.size() << " places, "
            << graph.regions.size() << " regions\n"
            << describeWritten(output, files) << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("process_bag", argc, argv, parseArguments, run);
}
