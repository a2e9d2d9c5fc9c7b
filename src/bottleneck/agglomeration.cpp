// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include "agglomeration_run.h"

namespace tsg::bottleneck {

bool isSameDistribution(const SparseMasses& a, double count_a, const SparseMasses& b,
                        double count_b) {
  constexpr double kTolerance = 1e-12;
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double left = a[i].mass * count_b;
    const double right = b[i].mass * count_a;
    if (a[i].task != b[i].task || std::abs(left - right) > kTolerance * left) return false;
  }
  return true;
}

Agglomeration::Agglomeration(const AgglomerationProblem& problem)
    : hub_degree_(problem.hub_degree),
      counts_(problem.relevance.size(), 1),
      versions_(problem.relevance.size(), 0),
      shapes_(problem.relevance.size(), 0),
      parents_(problem.relevance.size()),
      neighbours_(problem.relevance.size()),
      marks_(problem.relevance.size(), 0),
      activations_(problem.relevance.size(), 0),
      hub_of_(problem.relevance.size(), kNoHub) {
  std::iota(parents_.begin(), parents_.end(), 0u);
  masses_.reserve(problem.relevance.size());
  for (const SparseMasses* relevance : problem.relevance) masses_.push_back(*relevance);
  std::vector<std::size_t> degrees(neighbours_.size(), 0);
  for (const auto& [a, b] : problem.edges) {
    ++degrees[a];
    ++degrees[b];
  }
  for (std::size_t i = 0; i < degrees.size(); ++i) neighbours_[i].reserve(degrees[i]);
  for (const auto& [a, b] : problem.edges) {
    neighbours_[a].push_back(b);
    neighbours_[b].push_back(a);
  }
}

Index Agglomeration::findRoot(Index node) {
  while (parents_[node] != node) {
    parents_[node] = parents_[parents_[node]];
    node = parents_[node];
  }
  return node;
}

bool Agglomeration::isOutdated(const Candidate& c) const {
  const std::vector<Index>& versions = c.is_equal ? shapes_ : versions_;
  return versions[c.a] != c.version_a || versions[c.b] != c.version_b;
}

bool Agglomeration::isOutdated(const HubBound& bound) const {
  return hubs_[bound.hub].listing != bound.listing;
}

void Agglomeration::pushCandidate(Index u, Index v, double cost, bool is_equal) {
  const Index a = std::min(u, v);
  const Index b = std::max(u, v);
  const std::vector<Index>& versions = is_equal ? shapes_ : versions_;
  candidates_.push({roundCost(cost), a, b, versions[a], versions[b], is_equal},
                   [this](const Candidate& c) { return isOutdated(c); });
}

// Prices an edge of a cluster that has just come to be.
void Agglomeration::connect(Index u, Index v) {
  const Index a = std::min(u, v);  // one order, one rounding
  const Index b = std::max(u, v);
  const double cost = computeMergeCost(masses_[a], counts_[a], masses_[b], counts_[b]);  // Eq. 2
  const Index hub_u = hub_of_[u];
  const Index hub_v = hub_of_[v];
  if (hub_u == kNoHub && hub_v == kNoHub) {
    pushCandidate(u, v, cost, false);
  } else if (hub_v == kNoHub || (hub_u != kNoHub && isElder(hub_u, hub_v))) {
    deferEdge(u, v, cost);
  } else {
    deferEdge(v, u, cost);
  }
}

void Agglomeration::deferEdge(Index owner, Index neighbour, double cost) {
  const Index index = hub_of_[owner];
  Hub& hub = hubs_[index];
  const Hub::Edge edge = hub.price(cost, neighbour, versions_[neighbour], counts_[neighbour]);
  hub.defer(edge);
  if (hub_of_[neighbour] != kNoHub) hubs_[hub_of_[neighbour]].elders.push_back(owner);
  if (hub.numDeferred() > hub.size_limit) {
    hub.dropIf([this](const Hub::Edge& e) { return versions_[e.neighbour] != e.version; });
    hub.size_limit = 2 * hub.numDeferred() + 256;
  }
  if (hub.boundOf(edge) < hub.listed_bound) listBound(index);
}

void Agglomeration::listBound(Index hub) {
  Hub& h = hubs_[hub];
  ++h.listing;
  h.listed_bound = h.bound();
  if (h.listed_bound == Hub::kNoBound) return;
  bounds_.push({h.listed_bound, hub, h.listing},
               [this](const HubBound& bound) { return isOutdated(bound); });
}

void Agglomeration::activateLowest(Index hub) {
  Hub& h = hubs_[hub];
  const Hub::Edge edge = h.takeLowest();
  const Index u = hub_clusters_[hub];
  const Index v = edge.neighbour;
  const bool is_void = versions_[v] != edge.version || activations_[v] == h.state;
  if (!is_void) {
    activations_[v] = h.state;
    const Index a = std::min(u, v);  // one order, one rounding
    const Index b = std::max(u, v);
    const double cost = computeMergeCost(masses_[a], counts_[a], masses_[b], counts_[b]);  // Eq. 2
    const bool is_equal = isSameDistribution(masses_[u], counts_[u], masses_[v], counts_[v]);
    pushCandidate(u, v, is_equal ? 0.0 : cost, is_equal);
    (is_equal ? h.equals : h.active).push_back(h.price(cost, v, edge.version, counts_[v]));
  }
  listBound(hub);
}

// Prices one edge that may be better than the best candidate and not above `limit`; false if there
// is none.
bool Agglomeration::settleHub(std::int64_t limit) {
  while (!candidates_.empty() && isOutdated(candidates_.top())) candidates_.pop();
  while (!bounds_.empty() && isOutdated(bounds_.top())) bounds_.pop();
  if (bounds_.empty()) return false;
  const HubBound lowest = bounds_.top();
  if (lowest.bound > limit) return false;
  if (!candidates_.empty() && candidates_.top().cost < lowest.bound) return false;
  activateLowest(lowest.hub);
  return true;
}

MergeTape Agglomeration::run() {
  while (true) {
    while (settleHub(Hub::kNoBound)) {
    }
    if (candidates_.empty()) return std::move(tape_);
    const Candidate best = candidates_.top();
    candidates_.pop();
    tape_.push_back({best.a, best.b, best.cost});
    merge(best.a, best.b);
  }
}

void Agglomeration::merge(Index a, Index b) {
  const bool is_equal = isSameDistribution(masses_[a], counts_[a], masses_[b], counts_[b]);
  if (hub_of_[a] == kNoHub && hub_of_[b] == kNoHub) {
    mergeSmall(a, b, is_equal);
  } else {
    mergeHub(a, b, is_equal);
  }
}

void Agglomeration::uniteClusters(Index a, Index b, bool is_equal) {
  masses_[a] = addMasses(masses_[a], masses_[b]);
  masses_[b].clear();
  masses_[b].shrink_to_fit();
  counts_[a] += counts_[b];
  parents_[b] = a;
  ++versions_[a];
  activations_[a] = 0;
  if (!is_equal) ++shapes_[a];
  versions_[b] = shapes_[b] = kDead;
  marks_[a] = ++mark_;
}

void Agglomeration::appendUnmarked(const std::vector<Index>& formers, std::vector<Index>& joined) {
  for (const Index former : formers) {
    const Index neighbour = findRoot(former);
    if (marks_[neighbour] == mark_) continue;
    marks_[neighbour] = mark_;
    joined.push_back(neighbour);
  }
}

void Agglomeration::setElders(Index cluster, const std::vector<Index>& neighbours) {
  const Index hub = hub_of_[cluster];
  hubs_[hub].elders.clear();
  for (const Index neighbour : neighbours) {
    const Index other = hub_of_[neighbour];
    if (other != kNoHub && isElder(other, hub)) hubs_[hub].elders.push_back(neighbour);
  }
}

// Prices all edges of a cluster, which becomes a hub if they are many.
void Agglomeration::connectAll(Index cluster, const std::vector<Index>& neighbours) {
  if (hub_of_[cluster] == kNoHub && neighbours.size() > hub_degree_) {
    hub_of_[cluster] = static_cast<Index>(hubs_.size());
    hubs_.emplace_back();
    hubs_.back().age = hub_of_[cluster];
    hubs_.back().state = next_state_++;
    hub_clusters_.push_back(cluster);
  }
  for (const Index neighbour : neighbours) connect(cluster, neighbour);
  if (hub_of_[cluster] != kNoHub) setElders(cluster, neighbours);
}

void Agglomeration::mergeSmall(Index a, Index b, bool is_equal) {
  uniteClusters(a, b, is_equal);
  std::vector<Index> joined;
  joined.reserve(neighbours_[a].size() + neighbours_[b].size());
  appendUnmarked(neighbours_[a], joined);
  appendUnmarked(neighbours_[b], joined);
  std::vector<Index>().swap(neighbours_[b]);
  connectAll(a, joined);
  neighbours_[a] = std::move(joined);
}

// Prices that the merge makes wrong go back under their bounds.
void Agglomeration::prepareHub(Index winner, Index loser, bool keeps_name, bool is_equal) {
  Hub& hub = hubs_[hub_of_[winner]];
  for (const Hub::Edge& edge : hub.active) hub.defer(edge);
  hub.active.clear();
  if (!is_equal || !keeps_name) {
    for (const Hub::Edge& edge : hub.equals) hub.defer(edge);
    hub.equals.clear();
  }
  if (!is_equal) hub.absorb(masses_[winner], counts_[winner], masses_[loser], counts_[loser]);
  hub.state = next_state_++;
}

void Agglomeration::mergeHub(Index a, Index b, bool is_equal) {
  const bool is_larger = neighbours_[a].size() >= neighbours_[b].size();
  const bool a_wins = hub_of_[b] == kNoHub || (hub_of_[a] != kNoHub && is_larger);
  const Index winner = a_wins ? a : b;
  const Index loser = a_wins ? b : a;
  const Index index = hub_of_[winner];
  prepareHub(winner, loser, a_wins, is_equal);
  if (hub_of_[loser] != kNoHub) {
    Hub& lost = hubs_[hub_of_[loser]];
    hubs_[index].age = std::min(hubs_[index].age, lost.age);
    const std::uint32_t listing = lost.listing + 1;
    lost = Hub();
    lost.listing = listing;
  }
  uniteClusters(a, b, is_equal);
  hub_of_[a] = index;
  hub_of_[b] = kNoHub;
  hub_clusters_[index] = a;
  if (!a_wins) std::swap(neighbours_[a], neighbours_[b]);
  std::vector<Index> touched;
  appendUnmarked(neighbours_[b], touched);
  appendUnmarked(hubs_[index].elders, touched);
  for (const Index neighbour : touched) connect(a, neighbour);
  setElders(a, touched);
  neighbours_[a].insert(neighbours_[a].end(), neighbours_[b].begin(), neighbours_[b].end());
  std::vector<Index>().swap(neighbours_[b]);
  listBound(index);
}

std::vector<Index> Agglomeration::listNeighbours(Index cluster) {
  ++mark_;
  marks_[cluster] = mark_;
  std::vector<Index> neighbours;
  appendUnmarked(neighbours_[cluster], neighbours);
  return neighbours;
}

namespace {

/// The neighbours of each primitive, one after the other.
class Neighbours {
 public:
  explicit Neighbours(const AgglomerationProblem& problem)
      : begins_(problem.relevance.size() + 2, 0), ends_(2 * problem.edges.size()) {
    for (const auto& [a, b] : problem.edges) {
      ++begins_[a + 2];
      ++begins_[b + 2];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    for (const auto& [a, b] : problem.edges) {
      ends_[begins_[a + 1]++] = b;
      ends_[begins_[b + 1]++] = a;
    }
  }

  template <typename Visit>
  void forEach(Index node, const Visit& visit) const {
    for (std::size_t i = begins_[node]; i < begins_[node + 1]; ++i) visit(ends_[i]);
  }

 private:
  std::vector<std::size_t> begins_;  // by node, once filled; counted one further on meanwhile
  std::vector<Index> ends_;
};

// Of merges that all cost nothing the first is that of the smallest two ids: the smallest primitive
// that has a neighbour left takes in its smallest one, until there is none.
MergeTape agglomerateAlike(const AgglomerationProblem& problem) {
  const Neighbours neighbours(problem);
  std::vector<char> is_reached(problem.relevance.size(), 0);
  MergeTape tape;
  std::priority_queue<Index, std::vector<Index>, std::greater<>> reached;
  const auto reach = [&](Index node) {
    if (std::exchange(is_reached[node], char{1}) == 0) reached.push(node);
  };
  for (Index seed = 0; seed < is_reached.size(); ++seed) {
    if (std::exchange(is_reached[seed], char{1}) != 0) continue;
    neighbours.forEach(seed, reach);
    while (!reached.empty()) {
      const Index next = reached.top();
      reached.pop();
      tape.push_back({seed, next, 0});
      neighbours.forEach(next, reach);
    }
  }
  return tape;
}

}  // namespace

bool areAlike(const AgglomerationProblem& problem) {
  return std::all_of(problem.relevance.begin(), problem.relevance.end(),
                     [&](const SparseMasses* p) { return *p == *problem.relevance.front(); });
}

MergeTape agglomerate(const AgglomerationProblem& problem) {
  if (areAlike(problem)) return agglomerateAlike(problem);
  Agglomeration agglomeration(problem);
  for (const auto& [a, b] : problem.edges) agglomeration.connect(a, b);
  return agglomeration.run();
}

}  // namespace tsg::bottleneck
