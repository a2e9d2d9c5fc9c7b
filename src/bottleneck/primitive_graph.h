// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "box_index.h"
#include "task_scene_graph/bottleneck/distribution.h"
#include "task_scene_graph/bottleneck/graph_types.h"
#include "task_scene_graph/core/box.h"
#include "task_scene_graph/core/embedding.h"

namespace tsg::bottleneck {

/// Index of a primitive in the graph's table; reused after erasure.
using Slot = std::uint32_t;
constexpr Slot kNoSlot = ~Slot{0};

/// Primitives and the merges allowed between them, with a record of which parts have changed.
///
/// Overlaps of new or moved boxes are looked up in `updateAdjacency`, all at once. Not thread-safe.
class PrimitiveGraph {
 public:
  /// Beside the primitive: components are searched along them. A place has five.
  using Neighbours = boost::container::small_vector<Slot, 8>;

  struct Primitive {
    NodeKey key = 0;
    std::uint32_t component = kNoSlot;
    std::uint32_t former_component = kNoSlot;  ///< while its component is being found anew
    bool is_alive = false;
    bool is_box_pending = false;    ///< its overlaps are not looked up yet
    bool is_changed = true;         ///< since its component's tape was made: see FormerRun
    bool is_score_pending = false;  ///< its scores are not those of its embedding yet
    Neighbours neighbours;          ///< ascending by slot
    SparseMasses relevance;         ///< p(y|x); filled by the engine
    std::vector<double> scores;     ///< phi_1..phi_M; filled by the engine
    std::shared_ptr<const Embedding> embedding;  ///< not null while it is alive
    Aabb box;
  };

  explicit PrimitiveGraph(Adjacency adjacency) : adjacency_(adjacency) {}

  /// @throws std::invalid_argument if the key is taken.
  Slot insert(NodeKey key, std::shared_ptr<const Embedding> embedding, const Aabb& box);
  /// Returns whether the embedding changed.
  bool update(Slot slot, std::shared_ptr<const Embedding> embedding, const Aabb& box);
  void erase(Slot slot);
  /// False if the edge was there already. @throws std::invalid_argument if a == b.
  bool insertEdge(Slot a, Slot b);
  /// False if there was no such edge.
  bool eraseEdge(Slot a, Slot b);
  /// Links and unlinks primitives whose boxes are new or have moved.
  void updateAdjacency();

  /// @throws std::invalid_argument naming the key if there is none.
  Slot find(NodeKey key) const;
  std::optional<Slot> findIfThere(NodeKey key) const;
  bool contains(NodeKey key) const { return slots_.count(key) > 0; }
  std::size_t size() const { return slots_.size(); }
  /// One past the largest slot in use.
  Slot tableSize() const { return static_cast<Slot>(table_.size()); }
  Adjacency adjacency() const { return adjacency_; }

  Primitive& operator[](Slot slot) { return table_[slot]; }
  const Primitive& operator[](Slot slot) const { return table_[slot]; }

  /// Says that the clusters around a primitive must be found anew.
  void markTouched(Slot slot);
  /// Components and loose primitives that were touched since the last call; may repeat.
  struct Touched {
    std::vector<std::uint32_t> components;
    std::vector<Slot> slots;
  };
  Touched takeTouched();

 private:
  void setPendingBox(Slot slot, const Aabb& box);
  void unindexBox(Slot slot);
  void markEdge(Slot a, Slot b);
  void link(Slot a, Slot b);
  void unlink(Slot a, Slot b);
  void relink(Slot slot, const std::vector<Slot>& overlapping);

  Adjacency adjacency_;
  std::vector<Primitive> table_;
  std::vector<Slot> free_;
  std::unordered_map<NodeKey, Slot> slots_;
  BoxIndex index_;
  std::vector<Slot> pending_boxes_;
  Touched touched_;
};

/// "primitive 17", for messages.
std::string describeKey(NodeKey key);

}  // namespace tsg::bottleneck
