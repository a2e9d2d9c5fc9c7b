// SPDX-License-Identifier: BSD-3-Clause
#include "primitive_graph.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace tsg::bottleneck {
namespace {

using Neighbours = PrimitiveGraph::Neighbours;

bool insertSorted(Neighbours& list, Slot value) {
  const auto place = std::lower_bound(list.begin(), list.end(), value);
  if (place != list.end() && *place == value) return false;
  list.insert(place, value);
  return true;
}

template <typename List>
bool eraseSorted(List& list, Slot value) {
  const auto place = std::lower_bound(list.begin(), list.end(), value);
  if (place == list.end() || *place != value) return false;
  list.erase(place);
  return true;
}

void checkBox(const Aabb& box, NodeKey key) {
  const bool is_finite = box.min().allFinite() && box.max().allFinite();
  if (is_finite) return;
  throw std::invalid_argument("the box of " + describeKey(key) +
                              " has a corner that is not finite; expected metres");
}

bool isSame(const Aabb& a, const Aabb& b) { return a.min() == b.min() && a.max() == b.max(); }

bool isSame(const Embedding& a, const Embedding& b) { return a.size() == b.size() && a == b; }

}  // namespace

std::string describeKey(NodeKey key) { return "primitive " + std::to_string(key); }

Slot PrimitiveGraph::insert(NodeKey key, std::shared_ptr<const Embedding> embedding,
                            const Aabb& box) {
  if (contains(key)) throw std::invalid_argument(describeKey(key) + " is already there");
  checkBox(box, key);
  if (free_.empty()) {
    free_.push_back(tableSize());
    table_.emplace_back();
  }
  const Slot slot = free_.back();
  free_.pop_back();
  slots_[key] = slot;
  table_[slot].key = key;
  table_[slot].embedding = std::move(embedding);
  table_[slot].is_alive = true;
  setPendingBox(slot, box);
  markTouched(slot);
  return slot;
}

bool PrimitiveGraph::update(Slot slot, std::shared_ptr<const Embedding> embedding,
                            const Aabb& box) {
  Primitive& primitive = table_[slot];
  checkBox(box, primitive.key);
  if (!isSame(box, primitive.box)) {
    unindexBox(slot);
    setPendingBox(slot, box);
  }
  const bool has_changed = !isSame(*primitive.embedding, *embedding);
  primitive.embedding = std::move(embedding);  // also an equal one: the former owner may go
  return has_changed;
}

void PrimitiveGraph::erase(Slot slot) {
  markTouched(slot);
  unindexBox(slot);
  table_[slot].is_changed = true;
  const Neighbours neighbours = table_[slot].neighbours;
  for (const Slot neighbour : neighbours) unlink(slot, neighbour);
  slots_.erase(table_[slot].key);
  table_[slot] = Primitive();
  free_.push_back(slot);
}

void PrimitiveGraph::setPendingBox(Slot slot, const Aabb& box) {
  table_[slot].box = box;
  if (adjacency_ != Adjacency::kBoxOverlap || table_[slot].is_box_pending) return;
  table_[slot].is_box_pending = true;
  pending_boxes_.push_back(slot);
}

void PrimitiveGraph::unindexBox(Slot slot) {
  if (adjacency_ != Adjacency::kBoxOverlap) return;
  if (table_[slot].is_box_pending) {
    table_[slot].is_box_pending = false;  // its place in the list of pending boxes is now void
  } else {
    index_.remove({table_[slot].box, slot});
  }
}

void PrimitiveGraph::updateAdjacency() {
  std::vector<BoxIndex::Entry> entries;
  entries.reserve(pending_boxes_.size());
  for (const Slot slot : pending_boxes_) {
    if (!table_[slot].is_box_pending) continue;
    table_[slot].is_box_pending = false;
    entries.emplace_back(table_[slot].box, slot);
  }
  pending_boxes_.clear();
  index_.insert(entries);
  for (const auto& [box, slot] : entries) {
    std::vector<Slot> overlapping = index_.findOverlapping(box);
    eraseSorted(overlapping, slot);
    table_[slot].neighbours.reserve(overlapping.size());
    relink(slot, overlapping);
  }
}

void PrimitiveGraph::relink(Slot slot, const std::vector<Slot>& overlapping) {
  const Neighbours former = table_[slot].neighbours;
  std::vector<Slot> changed;
  changed.reserve(std::max(former.size(), overlapping.size()));
  std::set_difference(former.begin(), former.end(), overlapping.begin(), overlapping.end(),
                      std::back_inserter(changed));
  for (const Slot other : changed) unlink(slot, other);
  changed.clear();
  std::set_difference(overlapping.begin(), overlapping.end(), former.begin(), former.end(),
                      std::back_inserter(changed));
  for (const Slot other : changed) link(slot, other);
}

bool PrimitiveGraph::insertEdge(Slot a, Slot b) {
  if (a == b) {
    throw std::invalid_argument("an edge from " + describeKey(table_[a].key) +
                                " to itself; expected two primitives");
  }
  const auto& list = table_[a].neighbours;
  if (std::binary_search(list.begin(), list.end(), b)) return false;
  link(a, b);
  return true;
}

bool PrimitiveGraph::eraseEdge(Slot a, Slot b) {
  const auto& list = table_[a].neighbours;
  if (!std::binary_search(list.begin(), list.end(), b)) return false;
  unlink(a, b);
  return true;
}

// A changed edge needs one changed end.
void PrimitiveGraph::markEdge(Slot a, Slot b) {
  if (!table_[b].is_changed) table_[a].is_changed = true;
  markTouched(a);
  markTouched(b);
}

void PrimitiveGraph::link(Slot a, Slot b) {
  insertSorted(table_[a].neighbours, b);
  insertSorted(table_[b].neighbours, a);
  markEdge(a, b);
}

void PrimitiveGraph::unlink(Slot a, Slot b) {
  eraseSorted(table_[a].neighbours, b);
  eraseSorted(table_[b].neighbours, a);
  markEdge(a, b);
}

Slot PrimitiveGraph::find(NodeKey key) const {
  if (const auto slot = findIfThere(key)) return *slot;
  throw std::invalid_argument("there is no " + describeKey(key));
}

std::optional<Slot> PrimitiveGraph::findIfThere(NodeKey key) const {
  const auto place = slots_.find(key);
  return place == slots_.end() ? std::nullopt : std::make_optional(place->second);
}

void PrimitiveGraph::markTouched(Slot slot) {
  if (table_[slot].component == kNoSlot) {
    touched_.slots.push_back(slot);
  } else {
    touched_.components.push_back(table_[slot].component);
  }
}

PrimitiveGraph::Touched PrimitiveGraph::takeTouched() {
  const auto makeUnique = [](auto& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  makeUnique(touched_.components);
  makeUnique(touched_.slots);
  Touched taken;
  std::swap(taken, touched_);
  return taken;
}

}  // namespace tsg::bottleneck
