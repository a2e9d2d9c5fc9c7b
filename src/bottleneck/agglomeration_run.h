// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <deque>
#include <tuple>
#include <vector>

#include "agglomeration.h"
#include "hub.h"

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

  std::uint64_t pair() const { return (std::uint64_t{a} << 32) | b; }
  bool operator<(const Candidate& other) const {
    return cost < other.cost || (cost == other.cost && pair() < other.pair());
  }
};

/// The lower bound of a hub's edges.
struct HubBound {
  std::int64_t bound;
  Index hub;
  std::uint32_t listing;

  bool operator<(const HubBound& other) const {
    return std::tie(bound, hub) < std::tie(other.bound, other.hub);
  }
};

/// A heap, smallest first, whose outdated entries are dropped now and then. Four children to a
/// parent: half the levels of a binary one, and the children share a cache line or two.
template <typename Entry>
class LazyHeap {
 public:
  bool empty() const { return entries_.empty(); }
  const Entry& top() const { return entries_.front(); }

  void pop() {
    const Entry last = entries_.back();
    entries_.pop_back();
    if (!entries_.empty()) sink(0, last);
  }

  template <typename Predicate>
  void push(const Entry& entry, const Predicate& isOutdated) {
    entries_.push_back(entry);
    rise(entries_.size() - 1, entry);
    if (entries_.size() <= limit_) return;
    entries_.erase(std::remove_if(entries_.begin(), entries_.end(), isOutdated), entries_.end());
    for (std::size_t i = entries_.size() / kNumChildren + 1; i-- > 0;) {
      if (i < entries_.size()) sink(i, Entry(entries_[i]));
    }
    limit_ = 2 * entries_.size() + 1024;
  }

 private:
  static constexpr std::size_t kNumChildren = 4;

  void rise(std::size_t i, const Entry& entry) {
    for (; i > 0 && entry < entries_[(i - 1) / kNumChildren]; i = (i - 1) / kNumChildren) {
      entries_[i] = entries_[(i - 1) / kNumChildren];
    }
    entries_[i] = entry;
  }

  void sink(std::size_t i, const Entry& entry) {
    while (true) {
      const std::size_t first = kNumChildren * i + 1;
      const std::size_t end = std::min(first + kNumChildren, entries_.size());
      if (first >= end) break;
      std::size_t best = first;
      for (std::size_t child = first + 1; child < end; ++child) {
        if (entries_[child] < entries_[best]) best = child;
      }
      if (!(entries_[best] < entry)) break;
      entries_[i] = entries_[best];
      i = best;
    }
    entries_[i] = entry;
  }

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
  /// Prices an edge of a cluster that has just come to be.
  void connect(Index u, Index v);
  MergeTape run();

 protected:
  Index findRoot(Index node);
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
