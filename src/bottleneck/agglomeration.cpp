// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/bottleneck/agglomeration.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <tuple>

#include "hub.h"

namespace task_scene_graph::bottleneck {
namespace {

using Index = std::uint32_t;
constexpr Index kDead = ~Index{0};
constexpr Index kNoHub = ~Index{0};

// A priced edge. It holds while the versions of both ends are those here; or, between equal
// distributions (cost 0 whatever the sizes), while their distributions are.
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

// The lower bound of a hub's edges.
struct HubBound {
  std::int64_t bound;
  Index hub;
  std::uint32_t listing;

  bool operator>(const HubBound& other) const {
    return std::tie(bound, hub) > std::tie(other.bound, other.hub);
  }
};

// A binary heap, smallest first, whose outdated entries are dropped now and then.
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

// Equal up to the rounding of sums, which no cost in kCostUnit can show.
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

void Agglomeration::priceAllEdges(const AgglomerationProblem& problem) {
  for (const auto& [a, b] : problem.edges) connect(a, b);
}

Index Agglomeration::findRoot(Index node) {
  while (parents_[node] != node) {
    parents_[node] = parents_[parents_[node]];
    node = parents_[node];
  }
  return node;
}

double Agglomeration::price(Index u, Index v) const {
  const Index a = std::min(u, v);  // one order, one rounding
  const Index b = std::max(u, v);
  return computeMergeCost(masses_[a], counts_[a], masses_[b], counts_[b]);
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
  const double cost = price(u, v);
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
    const double cost = price(u, v);
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
  SparseMasses().swap(masses_[b]);
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

// Follows a former run. A cluster of this run is in step while the former run, as far as it has
// been followed, has a cluster of the same, unchanged primitives; else it is out of step, and all
// its edges are priced.
class Reagglomeration : private Agglomeration {
 public:
  Reagglomeration(const AgglomerationProblem& problem, const FormerRun& former);
  MergeTape run();

 private:
  // What identifies a set of primitives, in either run.
  struct Identity {
    std::uint64_t hash = 0;
    Index count = 1;
    bool has_changed = false;

    void add(const Identity& other) {
      hash += other.hash;
      count += other.count;
      has_changed = has_changed || other.has_changed;
    }
    bool isSame(const Identity& other) const {
      return hash == other.hash && count == other.count && !has_changed && !other.has_changed;
    }
  };

  bool isFollowable(const MergeStep& step) const;
  bool advance();
  void follow(const MergeStep& step);
  void passBy(const MergeStep& step);
  void mergeBest();
  void leaveStep(Index cluster);
  void priceOutOfStep(Index cluster);
  void tryFallInStep(Index cluster, Index former);
  Index findFormerRoot(Index former);
  void uniteFormer(const MergeStep& step);

  const FormerRun& former_;
  std::size_t position_ = 0;
  std::vector<Identity> identities_;
  std::vector<Identity> former_identities_;
  std::vector<Index> former_parents_;
  std::vector<Index> former_of_;                 // by primitive
  std::vector<char> is_in_step_;                 // by cluster
  std::vector<std::vector<Index>> out_of_step_;  // by cluster in step: such neighbours
};

std::uint64_t hashIndex(std::uint64_t x) {
  x = (x + 0x9e3779b97f4a7c15u) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 29)) * 0x94d049bb133111ebu;
  return x ^ (x >> 32);
}

Reagglomeration::Reagglomeration(const AgglomerationProblem& problem, const FormerRun& former)
    : Agglomeration(problem),
      former_(former),
      identities_(counts_.size()),
      former_identities_(former.index_of.size()),
      former_parents_(former.index_of.size()),
      former_of_(counts_.size(), FormerRun::kGone),
      is_in_step_(counts_.size(), 0),
      out_of_step_(counts_.size()) {
  std::iota(former_parents_.begin(), former_parents_.end(), 0u);
  for (Index i = 0; i < counts_.size(); ++i) {
    identities_[i] = {hashIndex(i), 1, former.is_changed[i]};
    is_in_step_[i] = !former.is_changed[i];
  }
  for (Index i = 0; i < former.index_of.size(); ++i) {
    const Index present = former.index_of[i];
    former_identities_[i] = {0, 1, true};
    if (present == FormerRun::kGone) continue;
    former_identities_[i] = identities_[present];
    former_of_[present] = i;
  }
  for (Index i = 0; i < counts_.size(); ++i) {
    if (!is_in_step_[i]) priceOutOfStep(i);
  }
}

Index Reagglomeration::findFormerRoot(Index former) {
  while (former_parents_[former] != former) {
    former_parents_[former] = former_parents_[former_parents_[former]];
    former = former_parents_[former];
  }
  return former;
}

void Reagglomeration::uniteFormer(const MergeStep& step) {
  former_parents_[step.b] = step.a;
  former_identities_[step.a].add(former_identities_[step.b]);
  ++position_;
}

// Both clusters of the step are there in this run, too.
bool Reagglomeration::isFollowable(const MergeStep& step) const {
  const auto isThere = [this](Index former) {
    const Index present = former_.index_of[former];
    return present != FormerRun::kGone && parents_[present] == present && is_in_step_[present] &&
           identities_[present].isSame(former_identities_[former]);
  };
  return isThere(step.a) && isThere(step.b);
}

void Reagglomeration::priceOutOfStep(Index cluster) {
  const std::vector<Index> neighbours = listNeighbours(cluster);
  connectAll(cluster, neighbours);
  for (const Index neighbour : neighbours) {
    if (is_in_step_[neighbour]) out_of_step_[neighbour].push_back(cluster);
  }
}

void Reagglomeration::leaveStep(Index cluster) {
  is_in_step_[cluster] = 0;
  for (const Index neighbour : listNeighbours(cluster)) {
    if (is_in_step_[neighbour]) out_of_step_[neighbour].push_back(cluster);
  }
}

void Reagglomeration::tryFallInStep(Index cluster, Index former) {
  if (is_in_step_[cluster] || !identities_[cluster].isSame(former_identities_[former])) return;
  is_in_step_[cluster] = 1;
  out_of_step_[cluster].clear();
  for (const Index neighbour : listNeighbours(cluster)) {
    if (!is_in_step_[neighbour]) out_of_step_[cluster].push_back(neighbour);
  }
}

// The same merge in both runs; only edges to clusters out of step are priced.
void Reagglomeration::follow(const MergeStep& step) {
  const Index a = former_.index_of[step.a];
  const Index b = former_.index_of[step.b];
  tape_.push_back({a, b, step.cost});
  const bool is_equal = isSameDistribution(masses_[a], counts_[a], masses_[b], counts_[b]);
  for (const Index part : {a, b}) {
    if (hub_of_[part] == kNoHub) continue;
    Hub& hub = hubs_[hub_of_[part]];
    const std::uint32_t listing = hub.listing + 1;
    hub = Hub();
    hub.listing = listing;
    hub_of_[part] = kNoHub;
  }
  uniteClusters(a, b, is_equal);
  identities_[a].add(identities_[b]);
  if (neighbours_[a].size() < neighbours_[b].size()) std::swap(neighbours_[a], neighbours_[b]);
  neighbours_[a].insert(neighbours_[a].end(), neighbours_[b].begin(), neighbours_[b].end());
  std::vector<Index>().swap(neighbours_[b]);
  std::vector<Index> priced;
  appendUnmarked(out_of_step_[a], priced);
  appendUnmarked(out_of_step_[b], priced);
  out_of_step_[a].clear();
  for (const Index neighbour : priced) {
    if (is_in_step_[neighbour]) continue;
    connect(a, neighbour);
    out_of_step_[a].push_back(neighbour);
  }
  uniteFormer(step);
}

// A merge of the former run that this one cannot, or does not yet, make.
void Reagglomeration::passBy(const MergeStep& step) {
  for (const Index former : {step.a, step.b}) {
    const Index present = former_.index_of[former];
    if (present == FormerRun::kGone || parents_[present] != present) continue;
    if (!is_in_step_[present] || !identities_[present].isSame(former_identities_[former])) continue;
    is_in_step_[present] = 0;
    priceOutOfStep(present);
  }
  uniteFormer(step);
  const Index present = former_.index_of[step.a];
  if (present == FormerRun::kGone) return;
  const Index root = findRoot(present);
  if (root == present) tryFallInStep(root, step.a);
}

void Reagglomeration::mergeBest() {
  const Candidate best = candidates_.top();
  candidates_.pop();
  tape_.push_back({best.a, best.b, best.cost});
  for (const Index part : {best.a, best.b}) {
    if (is_in_step_[part]) leaveStep(part);
  }
  merge(best.a, best.b);
  identities_[best.a].add(identities_[best.b]);
  const Index former = former_of_[best.a];
  if (former != FormerRun::kGone) tryFallInStep(best.a, findFormerRoot(former));
}

bool Reagglomeration::advance() {
  const bool has_step = position_ < former_.tape.size();
  const MergeStep step = has_step ? former_.tape[position_] : MergeStep();
  while (settleHub(has_step ? step.cost : Hub::kNoBound)) {
  }
  if (!has_step && candidates_.empty()) return false;
  bool is_first = !has_step;
  if (has_step && !candidates_.empty()) {
    const Index a = former_.index_of[step.a];
    const Index b = former_.index_of[step.b];
    const Candidate& best = candidates_.top();
    const bool is_named = a != FormerRun::kGone && b != FormerRun::kGone;
    is_first = best.cost < step.cost ||
               (best.cost == step.cost && is_named && std::tie(best.a, best.b) < std::tie(a, b));
  }
  if (is_first) {
    mergeBest();
  } else if (isFollowable(step)) {
    follow(step);
  } else {
    passBy(step);
  }
  return true;
}

MergeTape Reagglomeration::run() {
  while (advance()) {
  }
  return std::move(tape_);
}

}  // namespace

MergeTape reagglomerate(const AgglomerationProblem& problem, const FormerRun& former) {
  return Reagglomeration(problem, former).run();
}

MergeTape agglomerate(const AgglomerationProblem& problem) {
  Agglomeration agglomeration(problem);
  agglomeration.priceAllEdges(problem);
  return agglomeration.run();
}

}  // namespace task_scene_graph::bottleneck
