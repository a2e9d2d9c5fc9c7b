// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/explanations.h"

#include <algorithm>
#include <numeric>
#include <sstream>

namespace tsg::scene_graph {
namespace {

constexpr std::size_t kListed = 5;  // merges, tasks: more are counted

std::string nameTask(std::size_t y, const std::vector<std::string>& tasks) {
  if (y == 0) return "no task";
  return y <= tasks.size() ? "'" + tasks[y - 1] + "'" : "task " + std::to_string(y);
}

std::string formatNumber(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

/// "'mug' 0.67, 'plate' 0.33"
std::string formatMasses(const bottleneck::SparseMasses& masses,
                         const std::vector<std::string>& tasks) {
  bottleneck::SparseMasses sorted = masses;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.mass > b.mass; });
  std::string text;
  for (std::size_t i = 0; i < std::min(sorted.size(), kListed); ++i) {
    text +=
        (i == 0 ? "" : ", ") + nameTask(sorted[i].task, tasks) + " " + formatNumber(sorted[i].mass);
  }
  return text;
}

/// "3 and 7 (a loss of 2.1e-06): 'mug' 0.67 with 'mug' 0.6, 'plate' 0.4"
std::string formatMerge(const bottleneck::ExplainedMerge& merge,
                        const std::vector<std::string>& tasks) {
  return std::to_string(merge.a) + " and " + std::to_string(merge.b) + " (a loss of " +
         formatNumber(merge.delta) + "): " + formatMasses(merge.before_a, tasks) + " with " +
         formatMasses(merge.before_b, tasks);
}

}  // namespace

std::string describeExplanation(const bottleneck::ClusterExplanation& explanation,
                                const std::vector<std::string>& tasks, const ClusterWords& words) {
  const auto& merges = explanation.merges;
  std::string text = words.cluster + " " + std::to_string(explanation.id) + " serves " +
                     nameTask(static_cast<std::size_t>(explanation.task), tasks) + ": ";
  text += merges.empty()
              ? "one " + words.member + ", nothing was merged"
              : std::to_string(merges.size() + 1) + " " + words.member + "s in " +
                    std::to_string(merges.size()) + (merges.size() == 1 ? " merge" : " merges");
  for (std::size_t i = 0; i < std::min(merges.size(), kListed); ++i) {
    text += "\nmerged " + formatMerge(merges[i], tasks);
  }
  if (merges.size() > kListed) {
    text += "\n... and " + std::to_string(merges.size() - kListed) + " more";
  }
  text += explanation.stop
              ? "\nnot merged, for the loss is above " + formatNumber(explanation.threshold) +
                    ": " + formatMerge(*explanation.stop, tasks)
              : "\nnothing around it was left to merge with";
  return text;
}

std::string describeExplanation(const bottleneck::PairExplanation& explanation, std::uint64_t a,
                                std::uint64_t b, const std::vector<std::string>& tasks,
                                const ClusterWords& words) {
  using Verdict = bottleneck::PairExplanation::Verdict;
  std::string text =
      words.member + "s " + std::to_string(a) + " and " + std::to_string(b) + " are ";
  if (explanation.verdict == Verdict::kNotConnected) {
    return text + "apart: no chain of neighbours that serve a task leads from one to the other";
  }
  const bool is_together = explanation.verdict == Verdict::kTogether;
  text += is_together ? "in one " + words.cluster + "; joined by the merge of "
                      : "apart; it would take the merge of ";
  if (explanation.merge) text += formatMerge(*explanation.merge, tasks);
  text += "; the loss may be " + formatNumber(explanation.threshold);
  if (!is_together && explanation.stop) {
    text += "\nmerging ended at " + formatMerge(*explanation.stop, tasks);
  }
  return text;
}

std::string describeExplanation(const bottleneck::PrimitiveExplanation& explanation,
                                const std::vector<std::string>& tasks, const ClusterWords& words) {
  std::vector<std::size_t> order(explanation.scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return explanation.scores[a] > explanation.scores[b];
  });
  std::string text = words.member + " " + std::to_string(explanation.key) + ": cosines ";
  for (std::size_t i = 0; i < std::min(order.size(), kListed); ++i) {
    text += (i == 0 ? "" : ", ") + nameTask(order[i] + 1, tasks) + " " +
            formatNumber(explanation.scores[order[i]]);
  }
  if (order.empty()) text += "none, for there is no task";
  if (explanation.is_pruned) {
    return text + "\nthe best is below alpha " + formatNumber(explanation.alpha) +
           ": it serves no task";
  }
  return text + "\nit counts for " + formatMasses(explanation.relevance, tasks);
}

}  // namespace tsg::scene_graph
