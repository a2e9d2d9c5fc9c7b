// SPDX-License-Identifier: BSD-3-Clause
// What people change in a saved scene graph, taken over into the map.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "task_scene_graph/map/files.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"

namespace tsg::map {
namespace {

using scene_graph::FilePrimitive;

constexpr int kSymbolShift = 56;
constexpr std::uint64_t kPrimitiveLetter = std::uint64_t{'s'} << kSymbolShift;
constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << kSymbolShift) - 1;
// Other programs keep positions and vectors in single precision.
constexpr double kSameLength_m = 1e-4;
constexpr double kSameShare = 2e-7;  ///< of a coordinate, which may be that of a survey
constexpr double kSameNumber = 1e-5;

bool isPrimitive(const FilePrimitive& node) {
  return (node.id & ~kIndexMask) == kPrimitiveLetter && (node.id & kIndexMask) != 0;
}

bool isSamePoint(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).cwiseAbs().maxCoeff() < kSameLength_m + kSameShare * a.cwiseAbs().maxCoeff();
}

bool isSameBox(const Aabb& a, const Aabb& b) {
  return isSamePoint(a.min(), b.min()) && isSamePoint(a.max(), b.max());
}

bool isSameEmbedding(const Embedding& a, const Embedding& b) {
  if (a.size() != b.size()) return false;
  return a.size() == 0 ||
         static_cast<double>((a - b).cwiseAbs().maxCoeff()) <
             kSameNumber * std::max(1.0, static_cast<double>(a.cwiseAbs().maxCoeff()));
}

bool isUsable(const FilePrimitive& node) {
  return !node.box.isEmpty() && node.box.min().allFinite() && node.box.max().allFinite();
}

void move(ObjectPrimitive& primitive, const Eigen::Vector3d& step_m) {
  for (auto& vertex : primitive.mesh.vertices) vertex += step_m.cast<float>();
  primitive.box.translate(step_m);
  primitive.oriented_box.center_m += step_m;
}

/// The primitive as the file has it; the same pointer if nothing is different.
ObjectPrimitivePtr edit(const ObjectPrimitivePtr& before, const FilePrimitive& node) {
  const bool is_same_box = !isUsable(node) || isSameBox(before->box, node.box);
  const bool is_same_embedding =
      node.embedding.size() == 0 || isSameEmbedding(before->embedding, node.embedding);
  if (is_same_box && is_same_embedding) return before;
  auto after = std::make_shared<ObjectPrimitive>(*before);
  if (!is_same_embedding) after->embedding = node.embedding;
  if (is_same_box) return after;
  move(*after, node.box.center() - before->box.center());
  const Eigen::Vector3d change_m = node.box.sizes() - before->box.sizes();
  if (change_m.cwiseAbs().maxCoeff() < kSameLength_m) return after;
  after->box = node.box;
  after->oriented_box = toOrientedBox(node.box);
  return after;
}

ObjectPrimitivePtr make(const FilePrimitive& node, Stamp stamp) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id.value = node.id & kIndexMask;
  primitive->box = node.box;
  primitive->oriented_box = toOrientedBox(node.box);
  primitive->embedding = node.embedding;
  primitive->first_seen = primitive->last_seen = stamp;
  return primitive;
}

std::string listIds(const std::vector<PrimitiveId>& ids) {
  constexpr std::size_t kMaxListed = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(ids.size(), kMaxListed); ++i) {
    text += (i == 0 ? "" : ", ") + ("s" + std::to_string(ids[i].value));
  }
  return ids.size() > kMaxListed ? text + ", ..." : text;
}

/// Clusters without the primitives that are gone; their ids stay.
void dropFromClusters(const std::vector<PrimitiveId>& gone, Map& map) {
  const std::set<PrimitiveId> is_gone(gone.begin(), gone.end());
  std::vector<scene_graph::ObjectCluster> kept;
  for (auto cluster : map.objectClusters()) {
    auto& members = cluster.primitives;
    members.erase(std::remove_if(members.begin(), members.end(),
                                 [&](PrimitiveId id) { return is_gone.count(id) > 0; }),
                  members.end());
    if (!members.empty()) kept.push_back(std::move(cluster));
  }
  map.setClusters(std::move(kept), map.regionClusters());
}

}  // namespace

std::vector<std::string> applyEdits(const std::filesystem::path& scene_graph_json, Map& map) {
  const scene_graph::SceneGraphFile file(scene_graph_json.string(), map.embeddingSize());
  const auto all_ids = file.nodeIds();  // also of primitives without an embedding
  std::map<PrimitiveId, const FilePrimitive*> nodes;
  for (const FilePrimitive& node : file.primitives()) {
    if (isPrimitive(node)) nodes[{node.id & kIndexMask}] = &node;
  }
  std::vector<PrimitiveId> gone;
  std::vector<PrimitiveId> changed;
  std::vector<PrimitiveId> added;
  std::vector<ObjectPrimitivePtr> edited;
  for (const auto& primitive : map.primitives()) {
    const auto node = nodes.find(primitive->id);
    if (node == nodes.end()) {
      if (all_ids.count(kPrimitiveLetter | primitive->id.value) == 0) gone.push_back(primitive->id);
      continue;
    }
    ObjectPrimitivePtr after = edit(primitive, *node->second);
    if (after != primitive) {
      changed.push_back(primitive->id);
      edited.push_back(std::move(after));
    }
    nodes.erase(node);
  }
  for (const auto& [id, node] : nodes) {
    if (!isUsable(*node)) continue;
    added.push_back(id);
    edited.push_back(make(*node, map.stamp()));
  }
  dropFromClusters(gone, map);
  for (const PrimitiveId id : gone) map.erasePrimitive(id);
  map.addPrimitives(std::move(edited));
  const std::string where = scene_graph_json.filename().string() + " was edited: ";
  std::vector<std::string> notes;
  const auto note = [&](const char* what, const std::vector<PrimitiveId>& ids) {
    if (!ids.empty()) notes.push_back(where + what + " primitives " + listIds(ids));
  };
  note("erased", gone);
  note("changed", changed);
  note("added", added);
  if (notes.empty()) notes.push_back(where + "its primitives are as they were");
  notes.push_back(
      "objects, places and regions follow from primitives and free space; edits of "
      "them do not count");
  for (const auto& line : file.notes())
    notes.push_back(scene_graph_json.filename().string() + ": " + line);
  return notes;
}

}  // namespace tsg::map
