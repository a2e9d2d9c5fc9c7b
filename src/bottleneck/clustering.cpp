// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/clustering.h"

#include <memory>
#include <stdexcept>
#include <utility>

#include "clustering_state.h"
#include "task_scene_graph/config/config.h"

namespace tsg::bottleneck {

void ClusteringState::checkDimension(const Embedding& embedding, NodeKey key) const {
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

IncrementalClustering::IncrementalClustering(const ClusteringConfig& config, Adjacency adjacency)
    : state_(std::make_unique<ClusteringState>(config, adjacency)) {}
IncrementalClustering::~IncrementalClustering() = default;
IncrementalClustering::IncrementalClustering(IncrementalClustering&&) noexcept = default;
IncrementalClustering& IncrementalClustering::operator=(IncrementalClustering&&) noexcept = default;

void IncrementalClustering::setTasks(const EmbeddingMatrix& tasks) {
  TaskScorer scorer(tasks);
  if (state_->graph_.size() > 0 && scorer.numTasks() > 0 &&
      scorer.dimension() != state_->dimension_) {
    throw std::invalid_argument("the task embeddings have dimension " +
                                std::to_string(scorer.dimension()) + ", those of the primitives " +
                                std::to_string(state_->dimension_) + "; expected the same");
  }
  state_->scorer_ = std::move(scorer);
  for (const Slot slot : state_->allSlots()) state_->markScoresPending(slot);
  state_->is_cut_stale_ = true;
}

void IncrementalClustering::insert(NodeKey key, const Embedding& embedding, const Aabb& box) {
  insert(key, std::make_shared<const Embedding>(embedding), box);
}

void IncrementalClustering::insert(NodeKey key, std::shared_ptr<const Embedding> embedding,
                                   const Aabb& box) {
  state_->checkDimension(*embedding, key);
  const Eigen::Index dimension = embedding->size();
  state_->markScoresPending(state_->graph_.insert(key, std::move(embedding), box));
  state_->dimension_ = dimension;
  state_->is_cut_stale_ = true;
}

void IncrementalClustering::update(NodeKey key, const Embedding& embedding, const Aabb& box) {
  update(key, std::make_shared<const Embedding>(embedding), box);
}

void IncrementalClustering::update(NodeKey key, std::shared_ptr<const Embedding> embedding,
                                   const Aabb& box) {
  const Slot slot = state_->graph_.find(key);
  state_->checkDimension(*embedding, key);
  if (state_->graph_.update(slot, std::move(embedding), box)) state_->markScoresPending(slot);
}

void IncrementalClustering::erase(NodeKey key) {
  const Slot slot = state_->graph_.find(key);
  if (!state_->graph_[slot].relevance.empty())
    state_->information_.remove(state_->graph_[slot].relevance);
  state_->graph_.erase(slot);
  state_->registry_.forget(slot);
  state_->is_cut_stale_ = true;
}

bool IncrementalClustering::insertEdge(NodeKey a, NodeKey b) {
  if (state_->graph_.adjacency() == Adjacency::kGiven) {
    return state_->graph_.insertEdge(state_->graph_.find(a), state_->graph_.find(b));
  }
  throw std::logic_error("edges follow from the boxes here; expected Adjacency::kGiven");
}

bool IncrementalClustering::eraseEdge(NodeKey a, NodeKey b) {
  if (state_->graph_.adjacency() == Adjacency::kGiven) {
    return state_->graph_.eraseEdge(state_->graph_.find(a), state_->graph_.find(b));
  }
  throw std::logic_error("edges follow from the boxes here; expected Adjacency::kGiven");
}

void IncrementalClustering::setConfig(const ClusteringConfig& config) {
  config::validate(config, "clustering");
  state_->is_relevance_stale_ |= config.alpha != state_->config_.alpha ||
                                 config.top_k != state_->config_.top_k ||
                                 config.prune_null != state_->config_.prune_null ||
                                 config.cumulative != state_->config_.cumulative;
  state_->is_cut_stale_ = true;
  state_->config_ = config;
}

void IncrementalClustering::adoptIds(
    const std::vector<std::pair<std::uint64_t, std::vector<NodeKey>>>& clusters) {
  if (state_->registry_.size() > 0) {
    throw std::logic_error("clusters have ids already; expected none when ids are adopted");
  }
  std::vector<std::pair<std::uint64_t, std::vector<Slot>>> known;
  for (const auto& [id, keys] : clusters) {
    known.push_back({id, {}});
    for (const NodeKey key : keys) {
      if (state_->graph_.contains(key)) known.back().second.push_back(state_->graph_.find(key));
    }
  }
  const auto entries = state_->registry_.adopt(known);
  state_->former_.insert(state_->former_.end(), entries.begin(), entries.end());
}

bool IncrementalClustering::contains(NodeKey key) const { return state_->graph_.contains(key); }

std::size_t IncrementalClustering::size() const { return state_->graph_.size(); }

const ClusteringConfig& IncrementalClustering::config() const { return state_->config_; }

void IncrementalClustering::setAlpha(double alpha) {
  ClusteringConfig changed = config();
  changed.alpha = alpha;
  setConfig(changed);
}

void IncrementalClustering::setDelta(double delta) {
  ClusteringConfig changed = config();
  (changed.normaliser == Normaliser::kPaper ? changed.delta : changed.delta_bits) = delta;
  setConfig(changed);
}

void IncrementalClustering::setTopK(int top_k) {
  ClusteringConfig changed = config();
  changed.top_k = top_k;
  setConfig(changed);
}

}  // namespace tsg::bottleneck
