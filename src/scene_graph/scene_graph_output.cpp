// SPDX-License-Identifier: BSD-3-Clause
// How a scene graph file is written: what has not changed as it was read.
#include <nlohmann/json.hpp>
#include <ostream>

#include "scene_graph_content.h"

namespace tsg::scene_graph {
namespace {

/// Separates the elements of a list, one a line.
class Separator {
 public:
  explicit Separator(std::ostream& out) : out_(out) {}
  std::ostream& next() {
    out_ << (is_first_ ? "\n" : ",\n");
    is_first_ = false;
    return out_;
  }

 private:
  std::ostream& out_;
  bool is_first_ = true;
};

}  // namespace

void SceneGraphFile::Content::write(std::ostream& out) const {
  out << '{';
  Separator fields(out);
  for (const auto& [key, value] : graph.fields()) {
    fields.next() << quoteJson(key) << ':';
    if (key == "nodes") {
      writeNodes(out);
    } else if (key == "edges") {
      writeEdges(out);
    } else if (head.contains(key)) {
      out << head.at(key);
    } else {
      json->write(value, out);
    }
  }
  for (const auto& [key, value] : head.items()) {
    if (graph.find(key) == nullptr) fields.next() << quoteJson(key) << ':' << value;
  }
  out << "}\n";
}

void SceneGraphFile::Content::writeNodes(std::ostream& out) const {
  out << '[';
  Separator elements(out);
  for (const NodeRecord& node : nodes) {
    if (node.is_kept) json->write(node.text, elements.next());
  }
  for (const ObjectNode& object : objects) elements.next() << object.text;
  out << ']';
}

void SceneGraphFile::Content::writeEdges(std::ostream& out) const {
  out << '[';
  Separator elements(out);
  for (const EdgeRecord& edge : edges) {
    if (edge.is_moved) {
      elements.next() << replaceFields(
          *json, json->readObject(edge.text),
          {{"source", std::to_string(edge.source)}, {"target", std::to_string(edge.target)}});
    } else {
      json->write(edge.text, elements.next());
    }
  }
  EdgeInfo info;
  info.has_metadata = has_edge_metadata;
  std::string text;
  for (const NewEdge& edge : new_edges) {
    text.clear();
    appendEdge(edge.parent, edge.child, info, text);
    elements.next() << text;
  }
  out << ']';
}

}  // namespace tsg::scene_graph
