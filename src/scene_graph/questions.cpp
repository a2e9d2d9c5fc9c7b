// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/questions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

/// A thing that has an embedding, and its cosine to the question.
struct Candidate {
  std::size_t index = 0;
  std::uint64_t id = 0;
  double score = 0.0;
};

template <typename Thing>
const Thing& getThing(const Thing& thing) {
  return thing;
}
const ObjectPrimitive& getThing(const ObjectPrimitivePtr& primitive) { return *primitive; }

/// @throws std::invalid_argument for embeddings of another size.
template <typename Items>
std::vector<double> computeScores(const Items& items, const Embedding& question) {
  std::vector<double> scores;
  scores.reserve(items.size());
  for (const auto& item : items) {
    const Embedding& embedding = getThing(item).embedding;
    if (!hasDirection(embedding)) {
      scores.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    if (embedding.size() != question.size()) {
      throw std::invalid_argument("question has an embedding of " +
                                  std::to_string(question.size()) + " numbers, expected " +
                                  std::to_string(embedding.size()) + " as those of the map have");
    }
    scores.push_back(computeCosine(embedding, question));
  }
  return scores;
}

/// By score, best first; one more than `max_answers`, for the margin of the last.
std::vector<Candidate> keepBest(std::vector<Candidate> candidates, std::size_t max_answers) {
  const std::size_t count = std::min(candidates.size(), max_answers + 1);
  std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                    candidates.end(), [](const Candidate& a, const Candidate& b) {
                      return a.score > b.score || (a.score == b.score && a.id < b.id);
                    });
  candidates.resize(count);
  return candidates;
}

class Search {
 public:
  Search(const SceneGraph& graph, std::size_t max_answers)
      : graph_(graph), max_answers_(max_answers) {
    const auto regions = computeRegionOfPlaces(graph);
    for (std::size_t i = 0; i < regions.size(); ++i) {
      region_of_place_[graph.places->places[i].id] = regions[i];
    }
    for (const auto& object : graph.objects) {
      for (const PrimitiveId id : object.primitives) object_of_primitive_[id] = object.id;
    }
  }

  /// @param items     of the graph
  /// @param scores    of each
  template <typename Items>
  std::vector<Answer> find(const Items& items, const std::vector<double>& scores) const {
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (!std::isnan(scores[i])) candidates.push_back({i, getThing(items[i]).id.value, scores[i]});
    }
    candidates = keepBest(std::move(candidates), max_answers_);
    std::vector<Answer> answers;
    for (std::size_t i = 0; i < std::min(candidates.size(), max_answers_); ++i) {
      Answer answer;
      answer.id = candidates[i].id;
      answer.score = candidates[i].score;
      if (i + 1 < candidates.size()) answer.margin = answer.score - candidates[i + 1].score;
      describe(getThing(items[candidates[i].index]), answer);
      answers.push_back(std::move(answer));
    }
    return answers;
  }

  void describe(const SceneObject& object, Answer& answer) const {
    answer.task = object.task;
    answer.position_m = object.position_m;
    answer.box = object.oriented_box;
    answer.object = object.id;
    answer.last_seen = object.last_seen;
    setPlace(object.place, answer);
  }

  void describe(const ObjectPrimitive& primitive, Answer& answer) const {
    answer.position_m = primitive.box.center();
    answer.box = primitive.oriented_box;
    answer.last_seen = primitive.last_seen;
    const auto object = object_of_primitive_.find(primitive.id);
    if (object != object_of_primitive_.end()) answer.object = object->second;
    setPlace(findNearestPlace(answer.position_m), answer);
  }

  void describe(const Place& place, Answer& answer) const {
    answer.position_m = place.position_m;
    setPlace(place.id, answer);
  }

  static void describe(const Region& region, Answer& answer) {
    answer.task = region.task;
    answer.position_m = region.position_m;
    answer.region = region.id;
  }

 private:
  /// O(places): asked for a few answers only.
  PlaceId findNearestPlace(const Eigen::Vector3d& p_m) const {
    const auto& places = graph_.places->places;
    const auto nearest =
        std::min_element(places.begin(), places.end(), [&](const Place& a, const Place& b) {
          return (a.position_m - p_m).squaredNorm() < (b.position_m - p_m).squaredNorm();
        });
    return nearest == places.end() ? PlaceId{} : nearest->id;
  }

  void setPlace(PlaceId place, Answer& answer) const {
    answer.place = place;
    const auto region = region_of_place_.find(place);
    if (region != region_of_place_.end()) answer.region = region->second;
  }

  const SceneGraph& graph_;
  std::size_t max_answers_;
  std::map<PlaceId, RegionId> region_of_place_;
  std::map<PrimitiveId, ObjectId> object_of_primitive_;
};

/// "(1.20, -0.35, 0.80)"
std::string formatPosition(const Eigen::Vector3d& p_m) {
  std::ostringstream text;
  text.precision(2);
  text << std::fixed << "(" << p_m.x() << ", " << p_m.y() << ", " << p_m.z() << ")";
  return text.str();
}

std::string formatScore(double score) {
  std::ostringstream text;
  text.precision(3);
  text << std::fixed << score;
  return text.str();
}

std::string describeAnswer(const char* kind, const Answer& answer, const SceneGraph& graph) {
  std::string text = std::string(kind) + " " + std::to_string(answer.id);
  if (!answer.task.empty()) text += " (" + answer.task + ")";
  text += " at " + formatPosition(answer.position_m) + " m";
  const auto region = std::find_if(graph.regions.begin(), graph.regions.end(),
                                   [&](const Region& r) { return r.id == answer.region; });
  if (region != graph.regions.end() && std::string(kind) != "region") {
    text += " in region " + std::to_string(region->id.value);
    if (!region->task.empty()) text += " (" + region->task + ")";
  }
  return text + ", score " + formatScore(answer.score) + ", " + formatScore(answer.margin) +
         " above the next " + kind;
}

double bestScore(const std::vector<Answer>& answers) {
  return answers.empty() ? -1.0 : answers.front().score;
}

}  // namespace

bool isFound(const Answers& answers, const SceneGraphConfig& config) {
  const double thing = std::max(bestScore(answers.objects), bestScore(answers.primitives));
  return thing >= config.object_alpha || bestScore(answers.regions) >= config.place_alpha;
}

std::string describeAnswers(const Answers& answers, const SceneGraph& graph) {
  struct Best {
    const char* kind;
    const std::vector<Answer>& list;
    double alpha;
  };
  const double alpha = graph.config.object_alpha;
  std::string text;
  for (const Best& best :
       {Best{"object", answers.objects, alpha}, Best{"primitive", answers.primitives, alpha},
        Best{"region", answers.regions, graph.config.place_alpha}}) {
    if (bestScore(best.list) < best.alpha) continue;
    text += (text.empty() ? "" : "; ") + describeAnswer(best.kind, best.list.front(), graph);
  }
  if (!text.empty()) return text;
  const double best = std::max(bestScore(answers.objects), bestScore(answers.primitives));
  if (best <= -1.0) return "nothing with an embedding is in the map";
  return "nothing found: the best score is " + formatScore(best) + ", below alpha " +
         formatScore(alpha);
}

QuestionScores scoreQuestion(const SceneGraph& graph, const Embedding& question) {
  if (!hasDirection(question)) {
    throw std::invalid_argument("question has an embedding of " + std::to_string(question.size()) +
                                " numbers without a direction, expected finite ones, not all 0");
  }
  return {computeScores(graph.objects, question), computeScores(graph.primitives, question),
          computeScores(graph.places->places, question), computeScores(graph.regions, question)};
}

Answers answerQuestion(const SceneGraph& graph, const QuestionScores& scores,
                       std::size_t max_answers) {
  const Search search(graph, max_answers);
  return {
      search.find(graph.objects, scores.objects), search.find(graph.primitives, scores.primitives),
      search.find(graph.places->places, scores.places), search.find(graph.regions, scores.regions)};
}

Answers answerQuestion(const SceneGraph& graph, const Embedding& question,
                       std::size_t max_answers) {
  return answerQuestion(graph, scoreQuestion(graph, question), max_answers);
}

}  // namespace tsg::scene_graph
