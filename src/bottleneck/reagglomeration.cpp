// SPDX-License-Identifier: BSD-3-Clause
#include <numeric>
#include <tuple>

#include "agglomeration_run.h"

namespace tsg::bottleneck {
namespace {

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

}  // namespace tsg::bottleneck
