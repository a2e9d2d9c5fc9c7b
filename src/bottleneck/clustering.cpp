// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/clustering.h"

#include "engine.h"

namespace tsg::bottleneck {

IncrementalClustering::IncrementalClustering(const ClusteringConfig& config, Adjacency adjacency)
    : engine_(std::make_unique<ClusteringEngine>(config, adjacency)) {}
IncrementalClustering::~IncrementalClustering() = default;
IncrementalClustering::IncrementalClustering(IncrementalClustering&&) noexcept = default;
IncrementalClustering& IncrementalClustering::operator=(IncrementalClustering&&) noexcept = default;

void IncrementalClustering::setTasks(const EmbeddingMatrix& tasks) { engine_->setTasks(tasks); }

void IncrementalClustering::insert(NodeKey key, const Embedding& embedding, const Aabb& box) {
  engine_->insert(key, embedding, box);
}

void IncrementalClustering::update(NodeKey key, const Embedding& embedding, const Aabb& box) {
  engine_->update(key, embedding, box);
}

void IncrementalClustering::erase(NodeKey key) { engine_->erase(key); }

bool IncrementalClustering::contains(NodeKey key) const { return engine_->graph().contains(key); }

std::size_t IncrementalClustering::size() const { return engine_->graph().size(); }

bool IncrementalClustering::insertEdge(NodeKey a, NodeKey b) { return engine_->insertEdge(a, b); }

bool IncrementalClustering::eraseEdge(NodeKey a, NodeKey b) { return engine_->eraseEdge(a, b); }

const ClusteringConfig& IncrementalClustering::config() const { return engine_->config(); }

void IncrementalClustering::setConfig(const ClusteringConfig& config) {
  engine_->setConfig(config);
}

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

ClusteringUpdate IncrementalClustering::applyChanges() {
  engine_->apply();
  return engine_->takeUpdate();
}

std::vector<Cluster> IncrementalClustering::clusters() {
  engine_->apply();
  return engine_->makeClusters();
}

std::uint64_t IncrementalClustering::clusterOf(NodeKey key) {
  const Slot slot = engine_->graph().find(key);
  engine_->apply();
  return engine_->registry()[engine_->registry().clusterOf(slot)].id;
}

const std::vector<double>& IncrementalClustering::scores(NodeKey key) {
  const Slot slot = engine_->graph().find(key);
  engine_->apply();
  return engine_->graph()[slot].scores;
}

const SparseMasses& IncrementalClustering::relevance(NodeKey key) {
  const Slot slot = engine_->graph().find(key);
  engine_->apply();
  return engine_->graph()[slot].relevance;
}

double IncrementalClustering::information() {
  engine_->apply();
  return size() == 0 ? 0.0 : engine_->totalBits() / static_cast<double>(size());
}

std::vector<Merge> IncrementalClustering::mergeSequence() {
  engine_->apply();
  return engine_->makeMergeSequence();
}

ClusterExplanation IncrementalClustering::explainCluster(std::uint64_t id) {
  engine_->apply();
  return engine_->explainCluster(id);
}

PairExplanation IncrementalClustering::explainPair(NodeKey a, NodeKey b) {
  engine_->apply();
  return engine_->explainPair(a, b);
}

PrimitiveExplanation IncrementalClustering::explainPrimitive(NodeKey key) {
  engine_->apply();
  return engine_->explainPrimitive(key);
}

ClusteringStatistics IncrementalClustering::statistics() {
  engine_->apply();
  return engine_->computeStatistics();
}

}  // namespace tsg::bottleneck
