// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/visitor.h"

namespace task_scene_graph::scene_graph {

/// What the user tunes of the scene graph stage. alpha and delta may be changed while running.
struct SceneGraphConfig {
  double object_alpha = 0.23;  ///< score of the null task t_0 for objects [Clio24, Sec. IV-B]
  double object_delta = 1e-5;
  int object_top_k = 2;
  /// deviation: 0 in the paper's experiments, 0.21 in the authors' published configuration; with 0
  /// no place is ever irrelevant to all tasks, so corridors get the name of some task.
  double place_alpha = 0.21;
  double place_delta = 0.01;
  int place_top_k = 2;
  bool prune_null = true;
  /// deviation: the authors publish objects from 0.2 (below their alpha of 0.23) and prune at alpha
  /// only when they evaluate; here the default publishes what they evaluate.
  double min_object_score = -1.0;

  /// The least score of a published object: min_object_score, or object_alpha where that is -1.
  double publishedFrom() const {
    return min_object_score == -1.0 ? object_alpha : min_object_score;
  }

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("object_alpha", self.object_alpha, {-1.0, 1.0}, "",
            "cosine below which an object primitive is irrelevant to a task");
    v.field("object_delta", self.object_delta, {0.0, 1.0}, "",
            "share of the information on the tasks that one merge of objects may lose; 0 = no "
            "merge, 1 = all neighbours");
    v.field("object_top_k", self.object_top_k, {1, 1000}, "",
            "number of best tasks that a primitive counts for");
    v.field("place_alpha", self.place_alpha, {-1.0, 1.0}, "",
            "cosine below which a place is irrelevant to a place task; a region below it has no "
            "name");
    v.field("place_delta", self.place_delta, {0.0, 1.0}, "",
            "share of the information on the place tasks that one merge of places may lose");
    v.field("place_top_k", self.place_top_k, {1, 1000}, "",
            "number of best place tasks that a place counts for");
    v.field("prune_null", self.prune_null, {}, "",
            "what is irrelevant to all tasks counts for the null task only");
    v.field("min_object_score", self.min_object_score, {-1.0, 1.0}, "",
            "least cosine of an object's mean embedding to its task to be published; -1 = "
            "object_alpha");
  }
};

}  // namespace task_scene_graph::scene_graph
