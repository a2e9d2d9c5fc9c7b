// SPDX-License-Identifier: BSD-3-Clause
// Adds embeddings to a list of tasks, for robots that have no text encoder.

#include <iostream>
#include <optional>
#include <string>

#include "command_line.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/scene_graph/tasks.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string models;
  std::string tasks;
  std::string output;
  segmentation::EngineConfig engine;
  language::TextEncoderConfig encoder;
};

/// Nothing if only help was asked for.
std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  auto& templates = arguments.encoder.prompt_templates;
  options::options_description description(
      "Writes tasks with the embeddings that a model set's text encoder gives them, as\n"
      "'tasks: [{name: ..., embedding: [...]}]'.\n"
      "usage: encode_tasks --models M.yaml --tasks T.yaml --output OUT.yaml [options]\noptions");
  description.add_options()("help,h", "print this")(
      "models", tools::pathOption(arguments.models)->required(), "model set (YAML)")(
      "tasks", tools::pathOption(arguments.tasks)->required(),
      "task file (YAML); embeddings that it has are made anew")(
      "output", tools::pathOption(arguments.output)->required(), "file to write")(
      "template", options::value(&templates)->default_value(templates, "{}"),
      "prompt with {} for the task; of several, the mean embedding is taken")(
      "engine-library", options::value(&arguments.engine.library), "path of libonnxruntime.so");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  return arguments;
}

void encodeTasks(const Arguments& arguments) {
  scene_graph::TaskList tasks = scene_graph::loadTasks(arguments.tasks);
  const language::TextEncoder encoder(segmentation::loadModelSet(arguments.models),
                                      arguments.engine, arguments.encoder);
  tasks.embeddings = encoder.encodeTasks(tasks.names);
  if (tasks.size() == 0) std::cerr << "task file '" << arguments.tasks << "' holds no task\n";
  scene_graph::writeTasks(arguments.output, tasks);
  const std::string content = formatCount(tasks.size(), "task") + " with embeddings of " +
                              std::to_string(encoder.embeddingSize()) + " values";
  std::cout << describeWritten({}, {{arguments.output, content}}) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("encode_tasks", argc, argv, parseArguments, encodeTasks);
}
