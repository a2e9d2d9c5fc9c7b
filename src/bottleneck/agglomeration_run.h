// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <tuple>
#include <vector>

#include "hub.h"
#include "task_scene_graph/bottleneck/agglomeration.h"

namespace tsg::bottleneck {

using Index = std::uint32_t;
constexpr Index kDead = ~Index{0};
constexpr Index kNoHub = ~Index{0};

/// A priced edge. It holds while the versions of both ends are those here; or, between equal
/// distributions (cost 0 whatever the sizes), while their distributions are.
struct Candidate {
  std::int64_t cost;
  Index a;
  Index b;
  Index version_a;
  Index version_b;
  bool is_equal;

  bool operator>(const Candidate& other) const {
    return std::tie(cost, a, b) > std::tie(other.cost, other.a, other.b);
  }
};

/// The lower bound of a hub's edges.
struct HubBound {
  std::int64_t bound;
  Index hub;
  std::uint32_t listing;

  bool operator>(const HubBound& other) const {
    return std::tie(bound, hub) > std::tie(other.bound, other.hub);
  }
};

/// A binary heap, smallest first, whose outdated entries are dropped now and then.
template <typename Entry>
class LazyHeap {
 public:
  bool empty() const { return entries_.empty(); }
  const Entry& top() const { return entries_.front(); }

  void pop() {
    std::pop_heap(entries_.begin(), entries_.end(), std::greater<>());
    entries_.pop_back();
  }

  template <typename Predicate>
  void push(const Entry& entry, const Predicate& isOutdated) {
    entries_.push_back(entry);
    std::push_heap(entries_.begin(), entries_.end(), std::greater<>());
    if (entries_.size() <= limit_) return;
    entries_.erase(std::remove_if(entries_.begin(), entries_.end(), isOutdated), entries_.end());
    std::make_heap(entries_.begin(), entries_.end(), std::greater<>());
    limit_ = 2 * entries_.size() + 1024;
  }

 private:
  std::vector<Entry> entries_;
  std::size_t limit_ = 1024;
};

/// Equal up to the rounding of sums, which no cost in kCostUnit can show.
bool isSameDistribution(const SparseMasses& a, double count_a, const SparseMasses& b,
                        double count_b);

/// Runs one agglomeration to the end.
class Agglomeration {
 public:
  explicit Agglomeration(const AgglomerationProblem& problem);
  void priceAllEdges(const AgglomerationProblem& problem);
  MergeTape run();

 protected:
  Index findRoot(Index node);
  double price(Index u, Index v) const;
  void connect(Index u, Index v);
  void pushCandidate(Index u, Index v, double cost, bool is_equal);
  bool isOutdated(const Candidate& c) const;
  bool isOutdated(const HubBound& bound) const;
  bool isElder(Index hub_u, Index hub_v) const { return hubs_[hub_u].age < hubs_[hub_v].age; }

  void deferEdge(Index owner, Index neighbour, double cost);
  void listBound(Index hub);
  void activateLowest(Index hub);
  bool settleHub(std::int64_t limit);

  void merge(Index a, Index b);
  void uniteClusters(Index a, Index b, bool is_equal);
  void appendUnmarked(const std::vector<Index>& formers, std::vector<Index>& joined);
  void mergeSmall(Index a, Index b, bool is_equal);
  void mergeHub(Index a, Index b, bool is_equal);
  void prepareHub(Index winner, Index loser, bool keeps_name, bool is_equal);
  void setElders(Index cluster, const std::vector<Index>& neighbours);
  void connectAll(Index cluster, const std::vector<Index>& neighbours);
  std::vector<Index> listNeighbours(Index cluster);

  std::size_t hub_degree_;
  std::vector<SparseMasses> masses_;
  std::vector<Index> counts_;
  std::vector<Index> versions_;  // counts changes of a cluster
  std::vector<Index> shapes_;    // counts changes of its distribution
  std::vector<Index> parents_;
  std::vector<std::vector<Index>> neighbours_;  // may name clusters by a former member, and twice
  std::vector<Index> marks_;                    // last listing that saw the cluster
  Index mark_ = 0;
  std::vector<std::uint64_t> activations_;  // state of the hub that last activated the cluster
  std::vector<Index> hub_of_;
  std::deque<Hub> hubs_;
  std::vector<Index> hub_clusters_;
  LazyHeap<Candidate> candidates_;
  LazyHeap<HubBound> bounds_;
  std::uint64_t next_state_ = 1;
  MergeTape tape_;
};

}  // namespace tsg::bottleneck
