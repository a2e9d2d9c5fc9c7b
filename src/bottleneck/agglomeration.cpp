// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/agglomeration.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace task_scene_graph::bottleneck {
namespace {

using Index = std::uint32_t;

// An edge as it was when it was priced; outdated once either end has changed.
struct Candidate {
  std::int64_t cost;
  Index a;
  Index b;
  Index version_a;
  Index version_b;

  bool operator>(const Candidate& other) const {
    return std::tie(cost, a, b) > std::tie(other.cost, other.a, other.b);
  }
};

class Agglomeration {
 public:
  explicit Agglomeration(const AgglomerationProblem& problem);
  MergeTape run();

 private:
  Index findRoot(Index node);
  void pushEdge(Index u, Index v);
  bool isCurrent(const Candidate& c) const;
  void mergeInto(Index a, Index b);
  std::vector<Index> joinNeighbours(Index a, Index b);
  void compactHeap();

  std::vector<SparseMasses> masses_;
  std::vector<Index> counts_;
  std::vector<Index> versions_;
  std::vector<Index> parents_;
  std::vector<std::vector<Index>> neighbours_;  // may name clusters by a former member
  std::vector<Index> marks_;                    // last merge that saw the cluster
  std::vector<Candidate> heap_;
  std::size_t heap_limit_ = 0;
  MergeTape tape_;
};

constexpr Index kDead = ~Index{0};

Agglomeration::Agglomeration(const AgglomerationProblem& problem)
    : counts_(problem.relevance.size(), 1),
      versions_(problem.relevance.size(), 0),
      parents_(problem.relevance.size()),
      neighbours_(problem.relevance.size()),
      marks_(problem.relevance.size(), 0) {
  std::iota(parents_.begin(), parents_.end(), 0u);
  masses_.reserve(problem.relevance.size());
  for (const SparseMasses* relevance : problem.relevance) masses_.push_back(*relevance);
  heap_.reserve(problem.edges.size());
  for (const auto& [a, b] : problem.edges) {
    neighbours_[a].push_back(b);
    neighbours_[b].push_back(a);
    pushEdge(a, b);
  }
  std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
  heap_limit_ = 2 * heap_.size() + 1024;
}

Index Agglomeration::findRoot(Index node) {
  while (parents_[node] != node) {
    parents_[node] = parents_[parents_[node]];
    node = parents_[node];
  }
  return node;
}

void Agglomeration::pushEdge(Index u, Index v) {
  const Index a = std::min(u, v);
  const Index b = std::max(u, v);
  const double cost = computeMergeCost(masses_[a], counts_[a], masses_[b], counts_[b]);
  heap_.push_back({roundCost(cost), a, b, versions_[a], versions_[b]});
}

bool Agglomeration::isCurrent(const Candidate& c) const {
  return versions_[c.a] == c.version_a && versions_[c.b] == c.version_b;
}

std::vector<Index> Agglomeration::joinNeighbours(Index a, Index b) {
  const Index mark = static_cast<Index>(tape_.size());
  marks_[a] = mark;
  std::vector<Index> joined;
  for (const Index source : {a, b}) {
    for (const Index former : neighbours_[source]) {
      const Index neighbour = findRoot(former);
      if (marks_[neighbour] == mark) continue;
      marks_[neighbour] = mark;
      joined.push_back(neighbour);
    }
  }
  return joined;
}

void Agglomeration::mergeInto(Index a, Index b) {
  masses_[a] = addMasses(masses_[a], masses_[b]);
  counts_[a] += counts_[b];
  parents_[b] = a;
  ++versions_[a];
  versions_[b] = kDead;
  neighbours_[a] = joinNeighbours(a, b);
  std::vector<Index>().swap(neighbours_[b]);
  SparseMasses().swap(masses_[b]);
  for (const Index neighbour : neighbours_[a]) {
    pushEdge(a, neighbour);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  if (heap_.size() > heap_limit_) compactHeap();
}

void Agglomeration::compactHeap() {
  const auto outdated = [this](const Candidate& c) { return !isCurrent(c); };
  heap_.erase(std::remove_if(heap_.begin(), heap_.end(), outdated), heap_.end());
  std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
  heap_limit_ = 2 * heap_.size() + 1024;
}

MergeTape Agglomeration::run() {
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const Candidate best = heap_.back();
    heap_.pop_back();
    if (!isCurrent(best)) continue;
    tape_.push_back({best.a, best.b, best.cost});
    mergeInto(best.a, best.b);
  }
  return std::move(tape_);
}

}  // namespace

MergeTape agglomerate(const AgglomerationProblem& problem) { return Agglomeration(problem).run(); }

}  // namespace task_scene_graph::bottleneck
