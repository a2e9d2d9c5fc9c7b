// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace tsg::scene_graph {

/// Disjoint sets whose roots the caller chooses.
class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  std::size_t find(std::size_t item) {
    while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
    return item;
  }
  /// Puts the set of root `child` under root `root`; nothing if they are the same.
  void attach(std::size_t child, std::size_t root) { parent_[child] = root; }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace tsg::scene_graph
