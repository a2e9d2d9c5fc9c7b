// SPDX-License-Identifier: BSD-3-Clause
// Adds embeddings to a list of tasks, for robots that have no text encoder.

#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/scene_graph/tasks.h"
#include "task_scene_graph/segmentation/model_set.h"

using namespace task_scene_graph;

namespace {

constexpr const char* kUsage =
    "usage: encode_tasks --models M.yaml --tasks T.yaml --output OUT.yaml [options]\n"
    "Writes the tasks with the embeddings that the model set's text encoder gives them, as\n"
    "'tasks: [{name: ..., embedding: [...]}]'. Embeddings that T.yaml has are made anew.\n"
    "  --template TEXT   prompt with {} for the task; may be given several times, then the mean\n"
    "                    embedding is taken (default: {})\n"
    "  --engine-library PATH   which libonnxruntime.so\n"
    "  --help            this text\n";

struct Arguments {
  std::string models;
  std::string tasks;
  std::string output;
  bool help = false;
  segmentation::EngineConfig engine;
  language::TextEncoderConfig encoder;
};

void requireOption(const std::string& value, const char* name) {
  if (value.empty()) throw std::invalid_argument(std::string(name) + " is missing\n" + kUsage);
}

Arguments parse(const std::vector<std::string>& words) {
  Arguments arguments;
  std::vector<std::string> templates;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto next = [&] {
      if (i + 1 == words.size()) throw std::invalid_argument(word + " needs a value");
      return words[++i];
    };
    if (word == "--models") {
      arguments.models = next();
    } else if (word == "--tasks") {
      arguments.tasks = next();
    } else if (word == "--output") {
      arguments.output = next();
    } else if (word == "--template") {
      templates.push_back(next());
    } else if (word == "--engine-library") {
      arguments.engine.library = next();
    } else if (word == "--help") {
      arguments.help = true;
    } else {
      throw std::invalid_argument("unknown option '" + word + "'\n" + kUsage);
    }
  }
  if (!templates.empty()) arguments.encoder.prompt_templates = templates;
  return arguments;
}

void encodeTasks(const Arguments& arguments) {
  requireOption(arguments.models, "--models");
  requireOption(arguments.tasks, "--tasks");
  requireOption(arguments.output, "--output");
  scene_graph::TaskList tasks = scene_graph::loadTasks(arguments.tasks);
  const language::TextEncoder encoder(segmentation::loadModelSet(arguments.models),
                                      arguments.engine, arguments.encoder);
  tasks.embeddings = encoder.encodeTasks(tasks.names);
  scene_graph::writeTasks(arguments.output, tasks);
  std::cout << arguments.output << ": " << tasks.size() << " tasks with embeddings of "
            << encoder.embeddingSize() << " values\n";
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments arguments = parse({argv + 1, argv + argc});
    if (arguments.help) {
      std::cout << kUsage;
    } else {
      encodeTasks(arguments);
    }
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "encode_tasks: " << e.what() << '\n';
    return 1;
  }
}
