// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/core/embedding.h"

namespace tsg::simulation {

/// Stands in for a joint image-text network: vectors of phrases and of image segments whose cosines
/// are distributed as CLIP's. Text and image vectors lie in two narrow cones (the modality gap), so
/// a segment and the phrase that fits it have a cosine of about 0.24 to 0.31, others 0.13 to 0.22;
/// segments among each other 0.5 to 0.9. Everything follows from hashes of the words.
///
///   text(q)  = a g_text  + sqrt(1 - a^2) c(q)
///   image(s) = b g_image + s c(mixture of phrases) + class and instance appearance + view noise
///
/// c(q) is a unit vector: random directions of the phrase's last word (its head), of the words
/// before it and of the whole phrase, so "coffee table" is a little like "dining table" and like
/// "coffee mug", and not the same.
/// Appearance lies in a subspace that text does not reach.
class EmbeddingSpace {
 public:
  static constexpr int kSize = 512;
  using Mixture = std::vector<std::pair<std::string, double>>;  ///< phrases and their weights

  EmbeddingSpace();

  /// Unit vector of a phrase.
  Embedding encodeText(const std::string& phrase) const { return encodeText({{phrase, 1.0}}); }
  /// Unit vector of a task that several phrases serve ("something to read": book, magazine).
  Embedding encodeText(const Mixture& phrases) const;

  /// Unit vector of an image segment. `phrases`: what is seen (weights are normalised);
  /// `appearance`: names the thing, the same for all views of it, with `kind` shared by things of
  /// one class; `view_seed`: names the view.
  Embedding encodeImage(const Mixture& phrases, const std::string& kind, std::uint64_t appearance,
                        std::uint64_t view_seed) const;

  /// A segment that shows part `part` of the thing: near the whole thing's phrase.
  static Mixture makePart(const std::string& phrase, const std::string& part);

 private:
  Embedding mixConcepts(const Mixture& phrases) const;

  Embedding text_direction_;
  Embedding image_direction_;
};

}  // namespace tsg::simulation
