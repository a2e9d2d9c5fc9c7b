// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <utility>

#include "task_scene_graph/core/embedding.h"

namespace tsg {

/// An embedding whose values never change: copies share them. So a copy of a graph costs no
/// embeddings, and what is the same in two graphs that share it is told by its address, without
/// being read. To change one is to assign another. Safe to share between threads.
class SharedEmbedding {
 public:
  SharedEmbedding() = default;  ///< no embedding
  SharedEmbedding(Embedding values) {
    if (values.size() == 0) return;
    const bool has_direction = tsg::hasDirection(values);
    shared_ = std::make_shared<const Shared>(Shared{std::move(values), has_direction});
  }

  operator const Embedding&() const { return **this; }
  const Embedding& operator*() const { return shared_ ? shared_->values : none(); }
  const Embedding* operator->() const { return &**this; }
  Eigen::Index size() const { return (*this)->size(); }  ///< 0: no embedding

  /// True if every value is finite and at least one is not 0. O(1): found when it was made.
  bool hasDirection() const { return shared_ && shared_->has_direction; }

  /// Bit for bit: NaN equals itself, 0 does not equal -0. O(1) if the two share their values or
  /// differ in size, else O(D).
  friend bool operator==(const SharedEmbedding& a, const SharedEmbedding& b) {
    if (a.shared_ == b.shared_) return true;
    const auto bytes = static_cast<std::size_t>(a.size()) * sizeof(float);
    return a.size() == b.size() && std::memcmp(a->data(), b->data(), bytes) == 0;
  }
  friend bool operator!=(const SharedEmbedding& a, const SharedEmbedding& b) { return !(a == b); }

 private:
  struct Shared {
    Embedding values;
    bool has_direction = false;
  };

  static const Embedding& none() {
    static const Embedding empty;
    return empty;
  }

  std::shared_ptr<const Shared> shared_;  ///< null: no embedding; else not empty
};

}  // namespace tsg
