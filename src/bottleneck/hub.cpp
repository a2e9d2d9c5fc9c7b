// SPDX-License-Identifier: BSD-3-Clause
#include "hub.h"

#include <algorithm>
#include <cmath>

namespace tsg::bottleneck {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the bound, for the rounding of costs and of the arithmetic: absolute, and relative to the key.
constexpr double kMargin = 2.0 * kCostUnit;
constexpr double kRelativeMargin = 1e-11;

struct IsLaterEdge {
  bool operator()(const Hub::Edge& a, const Hub::Edge& b) const { return a.key > b.key; }
};

// Masses of the hub and of what it absorbs, for one task.
struct Growth {
  double added;
  double log_ratio;  // log2((m_u + m_k) / m_u)
};

std::vector<Growth> findGrowth(const SparseMasses& own, const SparseMasses& other) {
  std::vector<Growth> growth;
  auto i = own.begin();
  for (const TaskMass& entry : other) {
    while (i != own.end() && i->task < entry.task) ++i;
    const bool is_shared = i != own.end() && i->task == entry.task;
    growth.push_back({entry.mass, is_shared ? std::log2(1.0 + entry.mass / i->mass) : kInfinity});
  }
  return growth;
}

// Upper bound of what neighbours of `min_count` to `max_count` primitives may become cheaper by.
double computeDrop(const std::vector<Growth>& growth, double own_count, double other_count,
                   double min_count, double max_count) {
  double largest_ratio = 0.0;
  double sum = 0.0;
  for (const Growth& task : growth) {
    largest_ratio = std::max(largest_ratio, task.log_ratio);
    sum += std::min(max_count * task.log_ratio, computeMixingBits(task.added, max_count));
  }
  const double drop = std::min(max_count * largest_ratio, sum);
  return std::max(drop - other_count * std::log2(1.0 + min_count / (own_count + other_count)), 0.0);
}

}  // namespace

Hub::Edge Hub::price(double cost, std::uint32_t neighbour, std::uint32_t version,
                     double count) const {
  const auto size_class = static_cast<std::uint8_t>(std::ilogb(count));
  return {cost + potentials_[size_class], neighbour, version, size_class};
}

void Hub::defer(const Edge& edge) {
  std::vector<Edge>& heap = heaps_[edge.size_class];
  heap.push_back(edge);
  ++num_deferred_;
  std::push_heap(heap.begin(), heap.end(), IsLaterEdge());
}

std::size_t Hub::findLowestClass() const {
  std::size_t lowest = kNumClasses;
  double smallest = kInfinity;
  for (std::size_t c = 0; c < kNumClasses; ++c) {
    if (heaps_[c].empty()) continue;
    const double bound = heaps_[c].front().key - potentials_[c];
    if (lowest == kNumClasses || bound < smallest) {
      smallest = bound;
      lowest = c;
    }
  }
  return lowest;
}

std::int64_t Hub::boundOf(const Edge& edge) const {
  const double lowest =
      edge.key - potentials_[edge.size_class] - kMargin - kRelativeMargin * edge.key;
  return static_cast<std::int64_t>(std::floor(std::max(lowest, -1.0) / kCostUnit));
}

std::int64_t Hub::bound() const {
  const std::size_t c = findLowestClass();
  return c == kNumClasses ? kNoBound : boundOf(heaps_[c].front());
}

Hub::Edge Hub::takeLowest() {
  std::vector<Edge>& heap = heaps_[findLowestClass()];
  std::pop_heap(heap.begin(), heap.end(), IsLaterEdge());
  const Edge edge = heap.back();
  heap.pop_back();
  --num_deferred_;
  return edge;
}

void Hub::absorb(const SparseMasses& own, double own_count, const SparseMasses& other,
                 double other_count) {
  const std::vector<Growth> growth = findGrowth(own, other);
  for (std::size_t c = 0; c < kNumClasses; ++c) {
    if (heaps_[c].empty()) continue;
    const double min_count = std::ldexp(1.0, static_cast<int>(c));
    potentials_[c] += computeDrop(growth, own_count, other_count, min_count, 2.0 * min_count - 1.0);
  }
}

void Hub::dropIf(const std::function<bool(const Edge&)>& is_outdated) {
  num_deferred_ = 0;
  for (auto& heap : heaps_) {
    heap.erase(std::remove_if(heap.begin(), heap.end(), is_outdated), heap.end());
    std::make_heap(heap.begin(), heap.end(), IsLaterEdge());
    num_deferred_ += heap.size();
  }
}

}  // namespace tsg::bottleneck
