// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "task_scene_graph/ros/messages.h"

namespace tsg::ros_interface {

/// What makes `after` out of `before`: nodes and edges that are new or differ in anything, and the
/// keys of those that are gone. Its sequence is 0. Both graphs ascend as SceneGraph.msg says.
/// O(before + after).
msg::SceneGraphChanges computeChanges(const msg::SceneGraph& before, const msg::SceneGraph& after);

/// The whole graph in one message, for a subscriber who has nothing.
msg::SceneGraphChanges toWholeGraph(const msg::SceneGraph& graph, std::uint64_t sequence);

/// Makes changes in a graph: applyChanges(computeChanges(a, b), a) leaves b.
/// @throws InputError if something is there twice, is removed that is not there, or a list of edges
/// to be removed has an odd number of ends; the graph is then as it was. O(graph + changes).
void applyChanges(const msg::SceneGraphChanges& changes, msg::SceneGraph& graph);

/// Follows a scene graph by its numbered changes, and notices when one was lost. Not thread-safe.
class SceneGraphReader {
 public:
  enum class Status {
    kApplied,
    kKnown,    ///< not later than what is here already; passed over
    kWaiting,  ///< nothing is here yet, and this is not the whole graph; passed over
    kLost      ///< a message before it is missing, or it does not fit: subscribe anew
  };

  /// After kLost nothing is taken until the whole graph comes.
  Status apply(const msg::SceneGraphChanges& changes);

  /// Waits for the whole graph.
  void reset() { has_graph_ = false; }
  bool hasGraph() const { return has_graph_; }
  /// As of the last change; empty before the first.
  const msg::SceneGraph& graph() const { return graph_; }
  std::uint64_t sequence() const { return sequence_; }

 private:
  msg::SceneGraph graph_;
  std::uint64_t sequence_ = 0;
  bool has_graph_ = false;
};

}  // namespace tsg::ros_interface
