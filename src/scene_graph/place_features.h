// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "place_index.h"
#include "task_scene_graph/core/primitives.h"

namespace tsg::scene_graph {

/// What a place is clustered by.
struct PlaceFeature {
  const Place* place = nullptr;
  Embedding feature;          ///< never empty
  std::uint64_t version = 0;  ///< another one whenever the feature is computed anew
};

/// Places whose embeddings cannot be used.
struct UnusablePlaces {
  std::size_t rejected = 0;  ///< embedding of another size, or not finite
  std::string error;         ///< why the first rejected one was
};

/// The features of a place graph as it changes: the places' own embeddings, or what a step of
/// diffusion along the edges makes of them,
///
///   f_i = (e_i + s sum_j c_ij e_j) / (1 + s sum_j c_ij),
///
/// s per metre, c_ij the clearance of the edge in metres: neighbours across open floor count as
/// much as the place itself, those behind a door or a gap less. A place without an embedding of its
/// own takes those of its neighbours; one whose embedding is rejected has no feature. Not
/// thread-safe.
class PlaceFeatures {
 public:
  /// Computes what changed since the last call. O(places + edges) to compare, and D for each
  /// embedding that is not shared with the last graph; O(changed places and their neighbours * D)
  /// to compute.
  /// @param size  D; 0 = that of the first embedding
  UnusablePlaces update(const PlaceGraphPtr& graph, Eigen::Index size, double smoothing_per_m);

  const PlaceIndex& index() const { return last_.index; }  ///< of the last call's graph
  /// Places that the last call found new, elsewhere, or with another clearance or embedding.
  const std::vector<PlaceId>& changed() const { return changed_; }
  /// Of the places that have one, ascending by id.
  const std::vector<PlaceFeature>& features() const { return features_; }

 private:
  enum class Own : char { kNone, kUsable, kRejected };  ///< embedding of a place

  /// A graph and what is known of it.
  struct Looked {
    PlaceGraphPtr graph;
    PlaceIndex index;
    std::vector<Own> own;          ///< by place
    std::vector<PlaceEdge> edges;  ///< in order
    Eigen::Index embedding_size = 0;
  };

  Looked lookAt(const PlaceGraphPtr& graph, Eigen::Index size, std::vector<char>& has_other,
                UnusablePlaces& unusable);
  void markNeighbours(const Looked& now, std::vector<char>& is_changed) const;
  std::vector<Embedding> computeFeatures(const Looked& now,
                                         const std::vector<char>& is_changed) const;
  void replaceFeatures(const Looked& now, const std::vector<char>& is_changed,
                       std::vector<Embedding> computed);

  double smoothing_per_m_ = 0.0;
  Looked last_;  ///< its graph is null before the first call
  std::vector<PlaceFeature> features_;
  std::vector<PlaceId> changed_;
  std::uint64_t next_version_ = 1;
};

}  // namespace tsg::scene_graph
