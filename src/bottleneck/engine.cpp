// SPDX-License-Identifier: BSD-3-Clause
#include "engine.h"

#include <algorithm>
#include <chrono>
#include <queue>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/parallel.h"

namespace tsg::bottleneck {
namespace {

class Stopwatch {
 public:
  /// Seconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

ClusteringEngine::ClusteringEngine(const ClusteringConfig& config, Adjacency adjacency)
    : config_(config), graph_(adjacency) {
  config::validate(config, "clustering");
}

void ClusteringEngine::setTasks(const EmbeddingMatrix& tasks) {
  TaskScorer scorer(tasks);
  if (graph_.size() > 0 && scorer.numTasks() > 0 && scorer.dimension() != dimension_) {
    throw std::invalid_argument("the task embeddings have dimension " +
                                std::to_string(scorer.dimension()) + ", those of the primitives " +
                                std::to_string(dimension_) + "; expected the same");
  }
  scorer_ = std::move(scorer);
  for (const Slot slot : allSlots()) markScoresPending(slot);
  is_cut_stale_ = true;
}

void ClusteringEngine::setConfig(const ClusteringConfig& config) {
  config::validate(config, "clustering");
  is_relevance_stale_ |= config.alpha != config_.alpha || config.top_k != config_.top_k ||
                         config.prune_null != config_.prune_null ||
                         config.cumulative != config_.cumulative;
  is_cut_stale_ = true;
  config_ = config;
}

void ClusteringEngine::checkDimension(const Embedding& embedding, NodeKey key) const {
  checkEmbedding(embedding, describeKey(key));
  const Eigen::Index expected = scorer_.numTasks() > 0 ? scorer_.dimension()
                                : graph_.size() > 0    ? dimension_
                                                       : embedding.size();
  if (embedding.size() == expected) return;
  throw std::invalid_argument("the embedding of " + describeKey(key) + " has dimension " +
                              std::to_string(embedding.size()) + "; expected " +
                              std::to_string(expected) +
                              (scorer_.numTasks() > 0 ? " as the tasks" : " as the others"));
}

void ClusteringEngine::insert(NodeKey key, const Embedding& embedding, const Aabb& box) {
  checkDimension(embedding, key);
  markScoresPending(graph_.insert(key, embedding, box));
  dimension_ = embedding.size();
  is_cut_stale_ = true;
}

void ClusteringEngine::update(NodeKey key, const Embedding& embedding, const Aabb& box) {
  const Slot slot = graph_.find(key);
  checkDimension(embedding, key);
  if (graph_.update(slot, embedding, box)) markScoresPending(slot);
}

void ClusteringEngine::erase(NodeKey key) {
  const Slot slot = graph_.find(key);
  if (!graph_[slot].relevance.empty()) information_.remove(graph_[slot].relevance);
  graph_.erase(slot);
  is_cut_stale_ = true;
}

bool ClusteringEngine::insertEdge(NodeKey a, NodeKey b) {
  if (graph_.adjacency() == Adjacency::kGiven) {
    return graph_.insertEdge(graph_.find(a), graph_.find(b));
  }
  throw std::logic_error("edges follow from the boxes here; expected Adjacency::kGiven");
}

bool ClusteringEngine::eraseEdge(NodeKey a, NodeKey b) {
  if (graph_.adjacency() == Adjacency::kGiven) {
    return graph_.eraseEdge(graph_.find(a), graph_.find(b));
  }
  throw std::logic_error("edges follow from the boxes here; expected Adjacency::kGiven");
}

void ClusteringEngine::markScoresPending(Slot slot) {
  if (graph_[slot].is_score_pending) return;
  graph_[slot].is_score_pending = true;
  pending_scores_.push_back(slot);
}

std::vector<Slot> ClusteringEngine::allSlots() const {
  std::vector<Slot> slots;
  slots.reserve(graph_.size());
  for (Slot slot = 0; slot < graph_.tableSize(); ++slot) {
    if (graph_[slot].is_alive) slots.push_back(slot);
  }
  return slots;
}

double ClusteringEngine::totalBits() const {
  return information_.computeTotalBits(config_.prior, scorer_.numTasks());
}

void ClusteringEngine::apply() {
  ClusteringStatistics times;
  Stopwatch watch;
  updateScores();
  times.scoring_s = watch.lap();
  graph_.updateAdjacency();
  times.adjacency_s = watch.lap();
  const std::vector<Slot> loose = dissolve(graph_.takeTouched());
  const std::vector<ComponentIndex> rerun = rebuild(findComponents(loose));
  times.agglomeration_s = watch.lap();
  if (rerun.empty() && former_.empty() && !is_cut_stale_) return;
  nameClusters(rerun);
  times.naming_s = watch.lap();
  times_ = times;
  is_cut_stale_ = false;
}

void ClusteringEngine::updateScores() {
  std::vector<Slot> slots;
  for (const Slot slot : pending_scores_) {
    if (std::exchange(graph_[slot].is_score_pending, false)) slots.push_back(slot);
  }
  pending_scores_.clear();
  parallelFor(slots.size(), config_.num_threads, [&](std::size_t i) {
    graph_[slots[i]].scores = scorer_.computeScores(graph_[slots[i]].embedding);
  });
  updateRelevance(std::exchange(is_relevance_stale_, false) ? allSlots() : slots);
}

void ClusteringEngine::updateRelevance(const std::vector<Slot>& slots) {
  for (const Slot slot : slots) {
    SparseMasses relevance = computeRelevance(graph_[slot].scores, config_);
    SparseMasses& former = graph_[slot].relevance;
    if (relevance == former) continue;
    if (!former.empty()) information_.remove(former);
    information_.add(relevance);
    former = std::move(relevance);
    graph_[slot].is_changed = true;
    graph_.markTouched(slot);
    is_cut_stale_ = true;
  }
}

std::vector<Slot> ClusteringEngine::dissolve(const PrimitiveGraph::Touched& touched) {
  std::vector<Slot> loose;
  for (const Slot slot : touched.slots) {
    if (graph_[slot].is_alive && graph_[slot].component == kNoSlot) loose.push_back(slot);
  }
  for (const ComponentIndex index : touched.components) {
    const Component& component = dissolved_[index] = components_.release(index);
    for (const Slot slot : component.nodes) {
      if (graph_[slot].component != index) continue;  // erased meanwhile
      graph_[slot].component = kNoSlot;
      graph_[slot].former_component = index;
      loose.push_back(slot);
    }
    former_.insert(former_.end(), component.clusters.begin(), component.clusters.end());
  }
  return loose;
}

std::vector<std::vector<Slot>> ClusteringEngine::findComponents(const std::vector<Slot>& loose) {
  std::vector<std::vector<Slot>> parts;
  local_.resize(std::max<std::size_t>(local_.size(), graph_.tableSize()), kNoSlot);
  for (const Slot slot : loose) local_[slot] = kNoSlot;  // not reached yet
  for (const Slot seed : loose) {
    if (local_[seed] != kNoSlot) continue;
    std::vector<Slot> nodes{seed};
    local_[seed] = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (const Slot neighbour : graph_[nodes[i]].neighbours) {
        if (local_[neighbour] != kNoSlot) continue;
        local_[neighbour] = 0;
        nodes.push_back(neighbour);
      }
    }
    std::sort(nodes.begin(), nodes.end(),
              [this](Slot a, Slot b) { return graph_[a].key < graph_[b].key; });
    parts.push_back(std::move(nodes));
  }
  return parts;
}

AgglomerationProblem ClusteringEngine::makeProblem(const std::vector<Slot>& nodes) const {
  AgglomerationProblem problem;
  problem.relevance.reserve(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    problem.relevance.push_back(&graph_[nodes[i]].relevance);
    for (const Slot neighbour : graph_[nodes[i]].neighbours) {
      if (i < local_[neighbour]) problem.edges.emplace_back(i, local_[neighbour]);
    }
  }
  return problem;
}

// The dissolved component that nearly all of these primitives were in, unchanged; none if following
// its tape would not pay.
const Component* ClusteringEngine::findFormer(const std::vector<Slot>& nodes) const {
  constexpr std::size_t kMinSize = 500;
  constexpr double kMinShare = 0.9;
  if (nodes.size() < kMinSize) return nullptr;
  std::map<ComponentIndex, std::size_t> counts;
  for (const Slot slot : nodes) {
    if (!graph_[slot].is_changed) ++counts[graph_[slot].former_component];
  }
  for (const auto& [index, count] : counts) {
    const auto place = dissolved_.find(index);
    if (place == dissolved_.end()) continue;
    const auto size = static_cast<double>(std::max(nodes.size(), place->second.nodes.size()));
    if (static_cast<double>(count) >= kMinShare * size) return &place->second;
  }
  return nullptr;
}

FormerRun ClusteringEngine::makeFormerRun(const Component& former,
                                          const std::vector<Slot>& nodes) const {
  FormerRun run;
  run.tape = former.tape;
  run.index_of.assign(former.nodes.size(), FormerRun::kGone);
  run.is_changed.assign(nodes.size(), true);
  for (std::uint32_t i = 0; i < former.nodes.size(); ++i) {
    const Slot slot = former.nodes[i];
    const bool was_there = graph_[slot].is_alive && graph_[slot].former_component != kNoSlot;
    if (!was_there) continue;
    const std::uint32_t present = local_[slot];
    if (present >= nodes.size() || nodes[present] != slot) continue;  // in another part now
    run.index_of[i] = present;
    run.is_changed[present] = graph_[slot].is_changed;
  }
  return run;
}

MergeTape ClusteringEngine::runTape(const std::vector<Slot>& nodes) const {
  const AgglomerationProblem problem = makeProblem(nodes);
  const Component* former = findFormer(nodes);
  return former ? reagglomerate(problem, makeFormerRun(*former, nodes)) : agglomerate(problem);
}

std::vector<ComponentIndex> ClusteringEngine::rebuild(std::vector<std::vector<Slot>> parts) {
  for (const std::vector<Slot>& nodes : parts) {
    for (std::uint32_t i = 0; i < nodes.size(); ++i) local_[nodes[i]] = i;
  }
  std::vector<MergeTape> tapes(parts.size());
  parallelFor(parts.size(), config_.num_threads,
              [&](std::size_t i) { tapes[i] = runTape(parts[i]); });
  std::vector<ComponentIndex> rerun;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::vector<Slot> nodes = parts[i];
    rerun.push_back(components_.insert(std::move(parts[i]), std::move(tapes[i])));
    for (const Slot slot : nodes) {
      graph_[slot].component = rerun.back();
      graph_[slot].former_component = kNoSlot;
      graph_[slot].is_changed = false;
    }
  }
  dissolved_.clear();
  return rerun;
}

void ClusteringEngine::nameClusters(const std::vector<ComponentIndex>& rerun) {
  std::vector<ComponentIndex> changed = components_.recut(rule().limit());
  for (const ComponentIndex index : changed) {
    const auto& clusters = components_[index].clusters;
    former_.insert(former_.end(), clusters.begin(), clusters.end());
  }
  changed.insert(changed.end(), rerun.begin(), rerun.end());
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  std::vector<bool> is_rerun;
  for (const ComponentIndex index : changed)
    is_rerun.push_back(components_[index].clusters.empty());
  const auto names =
      registry_.assign(changed, is_rerun, std::exchange(former_, {}), graph_, components_);
  changed_.insert(names.changed.begin(), names.changed.end());
  removed_.insert(names.removed.begin(), names.removed.end());
  for (const std::uint64_t id : names.removed) changed_.erase(id);
}

Cluster ClusteringEngine::makeCluster(std::uint32_t entry, const std::vector<Slot>& members) {
  Cluster cluster;
  cluster.id = registry_[entry].id;
  cluster.members.reserve(members.size());
  dense_.assign(static_cast<std::size_t>(scorer_.numTasks()) + 1, 0.0);
  for (const Slot slot : members) {
    cluster.members.push_back(graph_[slot].key);
    for (const TaskMass& entry_y : graph_[slot].relevance) dense_[entry_y.task] += entry_y.mass;
  }
  const auto best = std::max_element(dense_.begin(), dense_.end());
  cluster.task = static_cast<int>(best - dense_.begin());
  for (std::uint32_t y = 0; y < dense_.size(); ++y) {
    if (dense_[y] > 0.0) cluster.relevance.push_back({y, dense_[y]});
  }
  cluster.relevance = toDistribution(cluster.relevance);
  return cluster;
}

void ClusteringEngine::appendClusters(ComponentIndex index, std::vector<Cluster>& clusters) {
  const Component& component = components_[index];
  std::vector<std::vector<Slot>> members(component.clusters.size());
  for (const Slot slot : component.nodes) {
    members[registry_[graph_[slot].cluster].label].push_back(slot);
  }
  for (std::size_t label = 0; label < members.size(); ++label) {
    clusters.push_back(makeCluster(component.clusters[label], members[label]));
  }
}

std::vector<Cluster> ClusteringEngine::makeClusters() {
  std::vector<Cluster> clusters;
  clusters.reserve(registry_.size());
  for (ComponentIndex index = 0; index < components_.tableSize(); ++index) {
    if (components_[index].is_alive) appendClusters(index, clusters);
  }
  std::sort(clusters.begin(), clusters.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  changed_.clear();
  removed_.clear();
  return clusters;
}

ClusteringUpdate ClusteringEngine::takeUpdate() {
  std::set<ComponentIndex> touched;
  for (const std::uint64_t id : changed_) touched.insert(registry_.find(id).component);
  ClusteringUpdate update;
  for (const ComponentIndex index : touched) appendClusters(index, update.changed);
  const auto is_old = [this](const Cluster& cluster) { return changed_.count(cluster.id) == 0; };
  update.changed.erase(std::remove_if(update.changed.begin(), update.changed.end(), is_old),
                       update.changed.end());
  std::sort(update.changed.begin(), update.changed.end(),
            [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  update.removed.assign(removed_.begin(), removed_.end());
  changed_.clear();
  removed_.clear();
  return update;
}

std::vector<Merge> ClusteringEngine::makeMergeSequence() const {
  using Head = std::tuple<std::int64_t, NodeKey, NodeKey, ComponentIndex, std::size_t>;
  std::priority_queue<Head, std::vector<Head>, std::greater<>> heads;
  const auto push = [&](ComponentIndex index, std::size_t i) {
    const Component& component = components_[index];
    if (i >= component.cut) return;
    const MergeStep& step = component.tape[i];
    heads.emplace(step.cost, graph_[component.nodes[step.a]].key,
                  graph_[component.nodes[step.b]].key, index, i);
  };
  for (ComponentIndex index = 0; index < components_.tableSize(); ++index) push(index, 0);
  const MergeRule rule(config_, totalBits());
  const double count = static_cast<double>(graph_.size());
  std::vector<Merge> merges;
  while (!heads.empty()) {
    const auto [cost, a, b, index, i] = heads.top();
    heads.pop();
    merges.push_back(
        {a, b, static_cast<double>(cost) * kCostUnit / count, rule.computeDelta(cost)});
    push(index, i + 1);
  }
  return merges;
}

}  // namespace tsg::bottleneck
