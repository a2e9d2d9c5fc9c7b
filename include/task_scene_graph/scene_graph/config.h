// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/bottleneck/config.h"
#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/scene_graph/geometric_rooms.h"

namespace tsg::scene_graph {

/// What regions are.
enum class RegionMethod {
  kTaskDriven,  ///< clusters of places by the place tasks [Clio24, Sec. IV-B]
  kGeometric    ///< rooms by the shape of free space alone (computeGeometricRooms())
};

/// What the user tunes of the scene graph stage. All of it may be changed while running.
struct SceneGraphConfig {
  double object_alpha = 0.23;  ///< score of the null task t_0 for objects [Clio24, Sec. IV-B]
  double object_delta = 1e-5;
  int object_top_k = 2;
  bottleneck::Normaliser object_normaliser = bottleneck::Normaliser::kPaper;
  double object_delta_bits = 0.03;
  double object_reach = 0.1;  ///< deviation: 0 in the paper; see bottleneck::extendUpAndDown()
  /// deviation: 0 in the paper's experiments, 0.21 in the authors' published configuration; with 0
  /// no place is ever irrelevant to all tasks, so corridors get the name of some task.
  double place_alpha = 0.21;
  double place_delta = 0.01;
  /// deviation: 2 in the paper. The second task of a place is that of the room beside it, or
  /// chance, and splits rooms.
  int place_top_k = 1;
  /// deviation: the paper's threshold grows with the map, until rooms are merged.
  bottleneck::Normaliser place_normaliser = bottleneck::Normaliser::kSizeInvariant;
  double place_delta_bits = 0.5;
  double place_smoothing_per_m = 1.0;  ///< deviation: none in the paper
  int min_region_places = 3;           ///< deviation: 1 in the paper
  RegionMethod region_method = RegionMethod::kTaskDriven;
  GeometricRoomsConfig rooms;
  bool prune_null = true;
  bottleneck::Prior prior = bottleneck::Prior::kUniform;
  /// Objects are published from here on; -1 stands for object_alpha. The paper publishes what is
  /// not background, that is not below alpha.
  /// deviation: the authors' program publishes from 0.2, below their alpha of 0.23, and their
  /// evaluation prunes at alpha; the default here publishes what they evaluate.
  double min_object_score = -1.0;
  int num_threads = 1;

  /// The least score of a published object.
  double publishedFrom() const {
    return min_object_score == -1.0 ? object_alpha : min_object_score;
  }

  bottleneck::ClusteringConfig objectClustering() const;
  bottleneck::ClusteringConfig placeClustering() const;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("object_alpha", self.object_alpha, {0.0, 1.0}, "",
            "cosine below which an object primitive is irrelevant to a task");
    v.field("object_delta", self.object_delta, {0.0, 1.0}, "",
            "share of the information on the tasks that one merge of objects may lose; 0: no "
            "merge, 1: all neighbours (object_normaliser: paper)");
    v.field("object_top_k", self.object_top_k, {1, 1000}, "",
            "best tasks, the null task included, that a primitive counts for");
    v.choice("object_normaliser", self.object_normaliser,
             {{"paper", bottleneck::Normaliser::kPaper},
              {"size_invariant", bottleneck::Normaliser::kSizeInvariant}},
             "what the loss of a merge of objects is compared with: object_delta, which drifts as "
             "the map grows, or object_delta_bits, which does not");
    v.field("object_delta_bits", self.object_delta_bits, {0.0, 1.0}, "bits",
            "half the bits that one merge of objects may lose; 0: no merge, 1: all neighbours "
            "(object_normaliser: size_invariant)");
    v.field("object_reach", self.object_reach, {0.0, 1.0}, "",
            "object primitives are neighbours where their boxes overlap, each as much higher and "
            "deeper as this share of its middle side");
    v.field("place_alpha", self.place_alpha, {0.0, 1.0}, "",
            "cosine below which a place is irrelevant to a place task; a region below it has no "
            "name");
    v.field("place_delta", self.place_delta, {0.0, 1.0}, "",
            "share of the information on the place tasks that one merge of places may lose; 0: no "
            "merge, 1: all that is joined (place_normaliser: paper)");
    v.field("place_top_k", self.place_top_k, {1, 1000}, "",
            "best place tasks, the null task included, that a place counts for");
    v.choice(
        "place_normaliser", self.place_normaliser,
        {{"paper", bottleneck::Normaliser::kPaper},
         {"size_invariant", bottleneck::Normaliser::kSizeInvariant}},
        "what the loss of a merge of places is compared with: place_delta, which drifts as the "
        "map grows, or place_delta_bits, which does not");
    v.field("place_delta_bits", self.place_delta_bits, {0.0, 1.0}, "bits",
            "half the bits that one merge of places may lose; 0: no merge, 1: all that is joined "
            "(place_normaliser: size_invariant)");
    v.field("place_smoothing_per_m", self.place_smoothing_per_m, {0.0, 100.0}, "1/m",
            "how much the features of a place's neighbours count beside its own, for each metre of "
            "clearance between them; 0: not at all");
    v.field("min_region_places", self.min_region_places, {1, 1000}, "",
            "regions of fewer places join the neighbour with the widest connection");
    v.choice("region_method", self.region_method,
             {{"task_driven", RegionMethod::kTaskDriven}, {"geometric", RegionMethod::kGeometric}},
             "regions are clusters of places by the place tasks, or rooms by the shape of free "
             "space alone, which need no image embeddings");
    v.group("rooms", self.rooms);
    v.field("prune_null", self.prune_null, {}, "",
            "what is irrelevant to all tasks counts for the null task alone");
    v.choice("prior", self.prior,
             {{"uniform", bottleneck::Prior::kUniform}, {"marginal", bottleneck::Prior::kMarginal}},
             "p(y) in the information that losses are shares of");
    v.field("min_object_score", self.min_object_score, {-1.0, 1.0}, "",
            "least cosine of an object's mean embedding to its task to be published; -1: "
            "object_alpha");
    v.field("num_threads", self.num_threads, {1, 256}, "",
            "threads; the result does not depend on it");
  }
};

}  // namespace tsg::scene_graph
