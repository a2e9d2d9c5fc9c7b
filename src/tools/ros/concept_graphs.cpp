// SPDX-License-Identifier: BSD-3-Clause
// The baseline ConceptGraphs over the recorded segmentations of a bag.

#include "task_scene_graph/evaluation/concept_graphs.h"

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "../command_line.h"
#include "input_options.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/ros/rgbd_bag.h"
#include "task_scene_graph/scene_graph/files.h"

namespace fs = std::filesystem;
namespace options = boost::program_options;
using namespace tsg;
using evaluation::ConceptGraphsConfig;
using evaluation::ConceptObject;

namespace {

struct Arguments {
  std::vector<std::string> bags;
  std::string output;
  int stride = 1;
  ConceptGraphsConfig config;
  tools::InputOptions input;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  options::options_description description(
      "Maps objects as ConceptGraphs does, from recorded segmentations: the paper's baseline.\n"
      "usage: concept_graphs --bag B [B2 ...] --output DIR [options]\n"
      "DIR gets scene_graph.json, for evaluate_scene_graph, and timing.json.\noptions");
  description.add_options()("help,h", "print this")(
      "bag", options::value(&arguments.bags)->required()->multitoken(), "rosbags, read as one")(
      "output", tools::pathOption(arguments.output)->required(), "folder, made if absent")(
      "stride", options::value(&arguments.stride), "takes every so many segmented frames (1)")(
      "min-similarity", options::value(&arguments.config.min_similarity),
      "overlap plus cosine at which a detection belongs to an object (1.2)");
  options::options_description input("input");
  arguments.input.addTo(input);
  description.add(input);
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  if (arguments.stride < 1) {
    throw options::error("--stride is " + std::to_string(arguments.stride) +
                         ", expected at least 1");
  }
  for (auto& bag : arguments.bags) bag = expandPath(bag).string();
  return arguments;
}

scene_graph::SceneGraph makeGraph(const std::vector<ConceptObject>& objects,
                                  const std::string& world_frame) {
  scene_graph::SceneGraph graph;
  graph.world_frame = world_frame;
  graph.places = std::make_shared<PlaceGraph>();
  for (const ConceptObject& from : objects) {
    scene_graph::SceneObject object;
    object.id = ObjectId{graph.objects.size() + 1};
    object.oriented_box = from.box;
    for (const Eigen::Vector3f& p : from.points_m) object.box.extend(p.cast<double>());
    object.position_m = from.box.center_m;
    object.embedding = from.embedding;
    object.first_seen = from.first_seen;
    object.last_seen = from.last_seen;
    graph.objects.push_back(std::move(object));
  }
  return graph;
}

void run(const Arguments& arguments) {
  const auto input =
      config::load(arguments.input.toYaml(), "the command line", ros_interface::InputConfig{});
  ros_interface::RgbdBag bag(arguments.bags, input, true);
  if (!bag.hasRecordedSegmentation()) {
    throw std::runtime_error("no recorded segmentation on '" + bag.segmentationTopic() +
                             "': name another topic with --segmentation-topic");
  }
  evaluation::ConceptGraphs mapping(arguments.config);
  const auto start = std::chrono::steady_clock::now();
  std::size_t num_segmented = 0;
  std::size_t num_used = 0;
  bag.forEachFrame(
      [&](const RgbdFramePtr& frame, const SegmentationPtr& recorded) {
        const auto aligned = recorded ? alignToFrame(*frame, recorded) : nullptr;
        if (aligned && num_segmented++ % static_cast<std::size_t>(arguments.stride) == 0) {
          mapping.add(*frame, *aligned);
          ++num_used;
        }
        return true;
      },
      [](std::size_t) {});
  const std::vector<ConceptObject> objects = mapping.finish();
  if (num_used == 0) throw std::runtime_error("no frame of the bag has a usable segmentation");
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  const fs::path output = arguments.output;
  fs::create_directories(output);
  scene_graph::SparkDsgOptions form;
  form.primitives = false;
  scene_graph::writeSparkDsg((output / "scene_graph.json").string(),
                             makeGraph(objects, input.world_frame), form);
  const nlohmann::json timing = {
      {"stages",
       {{"tracking", {{"frames", num_used}, {"mean_ms", ms / static_cast<double>(num_used)}}}}}};
  writeFileAtomically(output / "timing.json",
                      [&](std::ostream& out) { out << timing.dump(2) << '\n'; });
  std::cout << num_used << " frames, " << formatCount(objects.size(), "object") << " in "
            << (output / "scene_graph.json").string() << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("concept_graphs", argc, argv, parseArguments, run);
}
