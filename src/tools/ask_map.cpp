// SPDX-License-Identifier: BSD-3-Clause
// Asks a saved map, without a ROS master, what the services ask, explain and plan_path ask a live
// one.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "saved_map.h"
#include "task_scene_graph/config/scalar.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/map/settings.h"
#include "task_scene_graph/planning/goals.h"
#include "task_scene_graph/planning/planner.h"
#include "task_scene_graph/scene_graph/questions.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::string map;
  std::vector<std::string> words;
  std::vector<std::string> explain;
  std::vector<std::string> path_to;
  std::vector<double> from;
  std::vector<float> embedding;
  std::string models;
  double robot_radius_m = 0.0;
  std::size_t max_answers = 5;
};

constexpr int kNotFound = 1;
constexpr int kNotAnswered = 2;

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  options::options_description description(
      "Asks a saved map what in it fits some words, why it is clustered as it is, or for a path.\n"
      "usage: ask_map --map FOLDER WORDS... | --explain KIND ID [ID] | --path-to GOAL...\n"
      "The exit status is 0 if something fits, 1 if nothing in the map reaches alpha or there is "
      "no way,\n2 if the question could not be answered.\noptions");
  description.add_options()("help,h", "print this")(
      "map", tools::pathOption(arguments.map)->required(), "folder of the map")(
      "words", options::value(&arguments.words)->multitoken(), "what is looked for: coffee mug")(
      "embedding", options::value(&arguments.embedding)->multitoken(),
      "instead of words: the numbers of a vector")(
      "explain", options::value(&arguments.explain)->multitoken(),
      "object ID, primitive ID, primitives ID ID, region ID, places ID ID")(
      "path-to", options::value(&arguments.path_to)->multitoken(),
      "object ID, region ID, place ID, point X Y Z, object TASK or region TASK (what serves it "
      "best), or other words: the best answer to them")(
      "from", options::value(&arguments.from)->multitoken(),
      "X Y Z: where the path begins (default: where the camera was last)")(
      "robot-radius", options::value(&arguments.robot_radius_m),
      "metres (default: the map's setting)")("models", tools::pathOption(arguments.models),
                                             "model set (YAML) whose text encoder reads words; "
                                             "default: the one that the map was made with")(
      "max-answers", options::value(&arguments.max_answers), "of each kind (default 5)");
  options::positional_options_description positions;
  positions.add("words", -1);
  if (!tools::parseOptions(argc, argv, description, positions)) return std::nullopt;
  const int num_questions =
      (arguments.words.empty() ? 0 : 1) + (arguments.explain.empty() ? 0 : 1) +
      (arguments.path_to.empty() ? 0 : 1) + (arguments.embedding.empty() ? 0 : 1);
  if (num_questions != 1) {
    throw options::error("expected one of words, --embedding, --explain and --path-to");
  }
  if (arguments.max_answers < 1) throw options::error("--max-answers 0, expected at least 1");
  if (!arguments.from.empty() && arguments.from.size() != 3) {
    throw options::error("--from has " + std::to_string(arguments.from.size()) +
                         " numbers, expected X Y Z");
  }
  return arguments;
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::uint64_t toId(const std::string& text) {
  const bool is_number = !text.empty() && text.size() < 19 &&
                         text.find_first_not_of("0123456789") == std::string::npos;
  if (!is_number) throw std::invalid_argument("'" + text + "', expected an id");
  return std::stoull(text);
}

double toMetres(const std::string& text) {
  const auto number = config::parseNumber(text);
  if (!number) throw std::invalid_argument("'" + text + "', expected a number of metres");
  return *number;
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// A saved map and the graph that follows from it, as a live one has them.
class SavedMap {
 public:
  explicit SavedMap(const Arguments& arguments)
      : arguments_(arguments),
        models_(arguments.models.empty() ? map::findModels(arguments.map).string()
                                         : arguments.models),
        map_(load()),
        builder_(map_.settings().scene_graph, map_.worldFrame()) {
    builder_.setObjectTasks(map_.objectTasks());
    builder_.setPlaceTasks(map_.placeTasks());
    map::restoreBuilder(map_, builder_);
    graph_ = builder_.snapshot();
  }

  /// True if something fits.
  bool answer() {
    const scene_graph::Answers answers = ask(arguments_.words, arguments_.embedding);
    std::cout << (arguments_.words.empty() ? "" : "'" + join(arguments_.words) + "': ")
              << scene_graph::describeAnswers(answers, *graph_) << '\n';
    print("object", answers.objects);
    print("primitive", answers.primitives);
    print("region", answers.regions);
    return scene_graph::isFound(answers, graph_->config);
  }

  std::string explain() {
    const auto& words = arguments_.explain;
    const std::string& kind = words.front();
    const bool is_pair = kind == "primitives" || kind == "places";
    if (words.size() != (is_pair ? 3U : 2U)) {
      throw std::invalid_argument("--explain " + join(words) +
                                  ", expected object ID, primitive ID, "
                                  "primitives ID ID, region ID or places ID ID");
    }
    const std::uint64_t a = toId(words[1]);
    if (kind == "object") return builder_.explainObject({a});
    if (kind == "primitive") return builder_.explainPrimitive({a});
    if (kind == "region") return builder_.explainRegion({a});
    if (kind == "primitives") return builder_.explainPrimitives({a}, {toId(words[2])});
    if (kind == "places") return builder_.explainPlaces({a}, {toId(words[2])});
    throw std::invalid_argument("--explain " + kind +
                                ", expected object, primitive, primitives, region or places");
  }

  /// True if there is a path.
  bool findPath() {
    const auto config =
        map::readSettings<planning::PlannerConfig>(arguments_.map, "mesh_fusion", "planner");
    planning::PlanRequest request;
    request.start_m = findStart();
    const std::optional<planning::Goal> goal = findGoal();
    if (!goal) {
      std::cout << "nothing in the map reaches alpha\n";
      return false;
    }
    request.goal = *goal;
    request.robot_radius_m =
        arguments_.robot_radius_m > 0.0 ? arguments_.robot_radius_m : config.robot_radius_m;
    const planning::Planner planner(*map_.places(), map_.placeMemory()->plan, config);
    const planning::PlanResult result = planner.plan(request);
    if (!result.message.empty()) std::cout << result.message << '\n';
    if (!result.isFound()) return false;
    std::printf("path of %.2f m, clearance at least %.2f m (frame %s)\n", result.path.length_m,
                result.path.least_clearance_m, map_.worldFrame().c_str());
    for (const auto& point : result.path.points) {
      std::printf("  %.3f %.3f %.3f  yaw %.3f\n", point.position_m.x(), point.position_m.y(),
                  point.position_m.z(), point.yaw_rad);
    }
    return true;
  }

 private:
  map::Map load() const {
    map::MapUse use;
    if (!models_.empty()) use.model_set = segmentation::loadModelSet(models_).name;
    return tools::loadMap(arguments_.map, use);
  }

  scene_graph::Answers ask(const std::vector<std::string>& words,
                           const std::vector<float>& embedding) const {
    Embedding question;
    if (words.empty()) {
      question = Eigen::Map<const Embedding>(embedding.data(),
                                             static_cast<Eigen::Index>(embedding.size()));
    } else {
      language::WordEncoder encoder(models_);
      question = encoder.encode({join(words)}).row(0).transpose();
    }
    return scene_graph::answerQuestion(*graph_, question, arguments_.max_answers);
  }

  void print(const char* kind, const std::vector<scene_graph::Answer>& answers) const {
    for (const auto& answer : answers) {
      std::string region;
      if (answer.region.isValid()) region = " in region " + std::to_string(answer.region.value);
      for (const auto& r : graph_->regions) {
        if (r.id == answer.region && !r.task.empty()) region += " (" + r.task + ")";
      }
      std::printf("  %-9s %5llu  score %6.3f  (%.2f, %.2f, %.2f)  %s%s\n", kind,
                  static_cast<unsigned long long>(answer.id), answer.score, answer.position_m.x(),
                  answer.position_m.y(), answer.position_m.z(), answer.task.c_str(),
                  region.c_str());
    }
  }

  Eigen::Vector3d findStart() const {
    if (!arguments_.from.empty()) {
      return {arguments_.from[0], arguments_.from[1], arguments_.from[2]};
    }
    const auto& poses = map_.trajectory()->poses();
    if (poses.empty()) throw std::invalid_argument("the map has no trajectory: give --from X Y Z");
    return poses.rbegin()->second.translation();
  }

  /// Nothing if the words fit nothing.
  std::optional<planning::Goal> findGoal() const {
    const auto& words = arguments_.path_to;
    const std::string& kind = words.front();
    if (kind == "point" && words.size() == 4) {
      const Eigen::Vector3d point_m(toMetres(words[1]), toMetres(words[2]), toMetres(words[3]));
      return planning::Goal{point_m, {}};
    }
    const bool is_id =
        words.size() == 2 && words[1].find_first_not_of("0123456789") == std::string::npos;
    const std::string task = join({words.begin() + 1, words.end()});
    if (kind == "object" && is_id) return planning::findObjectGoal(*graph_, {toId(words[1])});
    if (kind == "region" && is_id) return planning::findRegionGoal(*graph_, {toId(words[1])});
    if (kind == "place" && is_id) return planning::findPlaceGoal(*graph_->places, {toId(words[1])});
    if (kind == "object" && contains(graph_->object_tasks, task)) {
      return planning::findObjectGoal(*graph_, planning::findObject(*graph_, task));
    }
    if (kind == "region" && contains(graph_->place_tasks, task)) {
      return planning::findRegionGoal(*graph_, planning::findRegion(*graph_, task));
    }
    return findGoal(ask(words, {}));
  }

  /// Of the kinds whose best answer reaches its alpha the one that stands above it most.
  std::optional<planning::Goal> findGoal(const scene_graph::Answers& answers) const {
    std::cout << scene_graph::describeAnswers(answers, *graph_) << '\n';
    const auto above = [](const std::vector<scene_graph::Answer>& list, double alpha) {
      return list.empty() ? -2.0 : list.front().score - alpha;
    };
    const double object = above(answers.objects, graph_->config.object_alpha);
    const double primitive = above(answers.primitives, graph_->config.object_alpha);
    const double region = above(answers.regions, graph_->config.place_alpha);
    const double best = std::max({object, primitive, region});
    if (best < 0.0) return std::nullopt;
    if (object == best) {
      return planning::findObjectGoal(*graph_, {answers.objects.front().id});
    }
    if (primitive == best) {
      const scene_graph::Answer& answer = answers.primitives.front();
      return planning::Goal{answer.position_m, answer.box};
    }
    return planning::findRegionGoal(*graph_, {answers.regions.front().id});
  }

  const Arguments& arguments_;
  std::string models_;
  map::Map map_;
  scene_graph::SceneGraphBuilder builder_;
  scene_graph::SceneGraphPtr graph_;
};

int run(const Arguments& arguments) {
  SavedMap saved(arguments);
  if (!arguments.explain.empty()) {
    std::cout << saved.explain() << '\n';
    return 0;
  }
  const bool is_found = arguments.path_to.empty() ? saved.answer() : saved.findPath();
  return is_found ? 0 : kNotFound;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto arguments = parseArguments(argc, argv);
    return arguments ? run(*arguments) : 0;
  } catch (const options::error& e) {
    std::cerr << "ask_map: " << e.what() << " (see ask_map --help)\n";
  } catch (const std::exception& e) {
    std::cerr << "ask_map: " << e.what() << '\n';
  }
  return kNotAnswered;
}
