// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/embedding_checks.h"

#include <algorithm>
#include <cmath>

namespace tsg::plausibility {
namespace {

constexpr std::size_t kMinThings = 5;
constexpr std::size_t kMinThingsForAll = 20;
constexpr std::size_t kPlacesAlike = 4;  // in a square metre
constexpr double kFarAbove = 0.15;
constexpr std::uint64_t kMinOverlaps = 100;
constexpr double kMaxRefusedShare = 0.5;
constexpr double kRefusedByAdvice = 0.2;  // share that the suggested threshold would refuse

std::string roundDown(double cosine) {
  return formatNumber(std::floor(cosine * 50.0) / 50.0);  // steps of 0.02
}

std::string describeCount(const scene_graph::CosineSummary& cosines, const CosineContext& context) {
  return std::to_string(cosines.count) + " " + context.things + "s";
}

Finding describeNoTasks(const scene_graph::CosineSummary& cosines, const CosineContext& context) {
  return {"no tasks", "there are " + describeCount(cosines, context) + " and no task",
          "usually the task file is empty or its list is", "list tasks in the task file"};
}

Finding describeTooLow(const scene_graph::CosineSummary& cosines, const CosineContext& context) {
  const auto task = static_cast<std::size_t>(std::max(cosines.task_index, 0));
  const std::string name = task < context.tasks.size() ? context.tasks[task] : "?";
  return {"",
          "none of " + describeCount(cosines, context) + " reaches " + context.parameter + " " +
              formatNumber(context.alpha) + "; the highest cosine was " +
              formatNumber(cosines.highest) + " (task '" + name + "'), the median of the best " +
              formatNumber(cosines.median),
          "either nothing that was seen serves a task, or this encoder's cosines are lower than"
          " those that the threshold was made for",
          "if things were seen that serve tasks, set scene_graph/" + context.parameter +
              " to about " + roundDown(0.5 * (cosines.highest + cosines.median)) +
              " (or alpha in the model set), and check that tasks and images are embedded by one"
              " model"};
}

Finding describeTooHigh(const scene_graph::CosineSummary& cosines, const CosineContext& context) {
  return {"",
          "each of " + describeCount(cosines, context) + " is above " + context.parameter + " " +
              formatNumber(context.alpha) + " by far: their best cosines lie between " +
              formatNumber(cosines.lowest) + " and " + formatNumber(cosines.highest),
          "usually this encoder's cosines are higher than those that the threshold was made for, so"
          " that nothing is irrelevant to the tasks",
          "set scene_graph/" + context.parameter +
              " between the cosines of what serves a task and"
              " of what does not (here the median is " +
              formatNumber(cosines.median) + ")"};
}

}  // namespace

CosineContext makeObjectContext(const scene_graph::SceneGraph& graph) {
  CosineContext context;
  context.alpha = std::max(graph.config.object_alpha, graph.config.publishedFrom());
  if (context.alpha > graph.config.object_alpha) context.parameter = "min_object_score";
  context.tasks = graph.object_tasks;
  context.num_served = graph.objects.size();
  return context;
}

CosineContext makePlaceContext(const scene_graph::SceneGraph& graph) {
  CosineContext context{"place", "place_alpha", graph.config.place_alpha, graph.place_tasks,
                        0,       kPlacesAlike};
  for (const auto& region : graph.regions) context.num_served += region.task_index >= 0 ? 1 : 0;
  return context;
}

std::optional<Finding> checkCosines(const scene_graph::CosineSummary& cosines,
                                    const CosineContext& context) {
  if (context.tasks.empty()) {
    return describeNoTasks(cosines, context);
  }
  const std::size_t count = cosines.count / context.things_alike;
  if (count < kMinThings) return std::nullopt;
  Finding finding;
  if (context.num_served == 0 && cosines.highest < context.alpha) {
    finding = describeTooLow(cosines, context);
  } else if (count >= kMinThingsForAll && cosines.lowest > context.alpha + kFarAbove) {
    finding = describeTooHigh(cosines, context);
  } else {
    return std::nullopt;
  }
  finding.check = context.things == "place" ? "place cosines" : "cosines";
  return finding;
}

std::vector<Finding> checkGraph(const scene_graph::SceneGraphBuilder& builder,
                                const scene_graph::SceneGraph& graph) {
  std::vector<Finding> findings;
  const auto add = [&](std::optional<Finding> finding) {
    if (finding) findings.push_back(std::move(*finding));
  };
  if (!graph.object_tasks.empty()) {
    add(checkCosines(builder.summarizeObjectCosines(), makeObjectContext(graph)));
  }
  if (!graph.place_tasks.empty()) {
    add(checkCosines(builder.summarizePlaceCosines(), makePlaceContext(graph)));
  }
  return findings;
}

std::optional<Finding> checkTracker(const tracking::TrackerCounters& counters,
                                    const tracking::TrackerConfig& config) {
  if (counters.overlapping_segments < kMinOverlaps) return std::nullopt;
  const double refused = static_cast<double>(counters.refused_by_cosine) /
                         static_cast<double>(counters.overlapping_segments);
  if (refused <= kMaxRefusedShare) return std::nullopt;
  const auto& cosines = counters.overlap_cosines;
  const double min_cosine = tracking::resolveThresholds(config).min_cosine;
  return Finding{
      "tracker cosines",
      "of " + std::to_string(counters.overlapping_segments) +
          " segments that overlapped a track enough, " + formatShare(refused) +
          " were refused by their cosine alone (below min_cosine " + formatNumber(min_cosine) +
          "; the median was " + formatNumber(cosines.quantile(0.5)) + ")",
      "usually this encoder's cosines between views of one thing are lower than those that the"
      " threshold was made for; objects fall into many short tracks",
      "set tracker/min_cosine to about " + roundDown(cosines.quantile(kRefusedByAdvice)) +
          (config.preset == tracking::Preset::kClio ? ", or tracker/preset to khronos (0.7)" : "")};
}

}  // namespace tsg::plausibility
