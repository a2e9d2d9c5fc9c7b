// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "task_scene_graph/bottleneck/distribution.h"

namespace tsg::bottleneck {

/// The edges of a cluster with many neighbours, priced anew only when they may have become the
/// best.
///
/// When a hub u absorbs k, the costs D(u, j) of all its edges change, but boundedly. h (see
/// computeMixingBits) is concave and ascends in either mass, hence
///
///     D(u + k, j) - D(u, j) >= n_k log2(1 + n_j / (n_u + n_k))
///                              - sum_y min(m_j(y) log2(1 + m_k(y) / m_u(y)), h(m_k(y), m_j(y)))
///
/// and >= 0 if u and k have the same distribution. With n_j known within a factor of two, the
/// right-hand side depends on the class of n_j only: its sum over the merges is the potential A of
/// the class, and D_then - (A_now - A_then) is a lower bound of D now. A heap by D_then + A_then
/// thus stays in order however the hub grows.
class Hub {
 public:
  struct Edge {
    double key = 0.0;  ///< D + A of its class when priced
    std::uint32_t neighbour = 0;
    std::uint32_t version = 0;  ///< of the neighbour when priced
    std::uint8_t size_class = 0;
  };
  static constexpr std::int64_t kNoBound = std::numeric_limits<std::int64_t>::max();

  /// Files an edge of cost D (unrounded) to a neighbour of `count` primitives; returns it.
  Edge price(double cost, std::uint32_t neighbour, std::uint32_t version, double count) const;
  void defer(const Edge& edge);
  /// The edge's rounded cost is not below this.
  std::int64_t boundOf(const Edge& edge) const;
  /// No rounded cost of a deferred edge is below this; kNoBound without one.
  std::int64_t bound() const;
  /// Takes out the edge that `bound` is about.
  Edge takeLowest();

  /// Says that the hub (as it was) absorbs a cluster of another distribution.
  void absorb(const SparseMasses& own, double own_count, const SparseMasses& other,
              double other_count);

  std::size_t numDeferred() const { return num_deferred_; }
  /// Drops edges for which `is_outdated(edge)`.
  void dropIf(const std::function<bool(const Edge&)>& is_outdated);

  std::vector<Edge> active;           ///< priced as the hub is now, and not deferred
  std::vector<Edge> equals;           ///< likewise; neighbours of the hub's own distribution
  std::vector<std::uint32_t> elders;  ///< neighbouring hubs that hold the common edge
  std::uint32_t age = 0;              ///< order of becoming a hub: elders first
  std::uint64_t state = 0;            ///< changes whenever the hub does
  std::uint32_t listing = 0;          ///< number of the last listing of `bound`
  std::int64_t listed_bound = kNoBound;
  std::size_t size_limit = 256;  ///< of deferred edges, before outdated ones are looked for

 private:
  static constexpr std::size_t kNumClasses = 32;
  std::size_t findLowestClass() const;

  std::array<double, kNumClasses> potentials_{};
  std::array<std::vector<Edge>, kNumClasses> heaps_;
  std::size_t num_deferred_ = 0;
};

}  // namespace tsg::bottleneck
