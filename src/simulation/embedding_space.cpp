// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/embedding_space.h"

#include <cmath>
#include <sstream>

#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

constexpr int kConceptSize = 320;  ///< first axes: meaning; the rest: appearance
// The parts of a vector's squared length; the cosine of a fitting pair is
// kTextCommon kImageCommon kGap + sqrt(1 - kTextCommon^2) kConcept, over the image vector's length
// of 0.97 before it is normalised: 0.177 + 0.109.
constexpr float kTextCommon = 0.80F;
constexpr float kImageCommon = 0.74F;
constexpr float kGap = 0.29F;  ///< cosine between the two cones' axes
constexpr float kConcept = 0.177F;
constexpr float kKind = 0.46F;      ///< appearance that a class shares
constexpr float kInstance = 0.36F;  ///< appearance of the one thing
constexpr float kView = 0.16F;      ///< of the view
constexpr float kHeadShare = 0.3F;  ///< of a phrase's meaning, in squared length
constexpr float kBeforeShare = 0.3F;
constexpr double kPartWeight = 0.3;

/// A random unit vector in axes [from, to).
Embedding makeDirection(std::uint64_t seed, int from, int to) {
  Embedding v = Embedding::Zero(EmbeddingSpace::kSize);
  for (int i = from; i < to; ++i)
    v[i] = static_cast<float>(toNormal(combineSeeds(seed, static_cast<std::uint64_t>(i))));
  return v.normalized();
}

std::vector<std::string> splitWords(const std::string& phrase) {
  std::istringstream stream(phrase);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// Two axes are kept for the cones, so that concepts do not disturb them.
Embedding makeConceptDirection(const std::string& name) {
  return makeDirection(hashText(name), 2, kConceptSize);
}

Embedding computeConcept(const std::string& phrase) {
  const std::vector<std::string> words = splitWords(phrase);
  if (words.empty()) return Embedding::Zero(EmbeddingSpace::kSize);
  if (words.size() == 1) return makeConceptDirection("word " + words.front());
  std::string before;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) before += words[i] + " ";
  const Embedding v =
      std::sqrt(kHeadShare) * makeConceptDirection("head " + words.back()) +
      std::sqrt(kBeforeShare) * makeConceptDirection("before " + before) +
      std::sqrt(1.0F - kHeadShare - kBeforeShare) * makeConceptDirection("phrase " + phrase);
  return v.normalized();
}

}  // namespace

EmbeddingSpace::EmbeddingSpace()
    : text_direction_(Embedding::Zero(kSize)), image_direction_(Embedding::Zero(kSize)) {
  text_direction_[0] = 1.0F;
  image_direction_[0] = kGap;
  image_direction_[1] = std::sqrt(1.0F - kGap * kGap);
}

Embedding EmbeddingSpace::mixConcepts(const Mixture& phrases) const {
  Embedding sum = Embedding::Zero(kSize);
  for (const auto& [phrase, weight] : phrases) {
    sum += static_cast<float>(weight) * computeConcept(phrase);
  }
  return sum;
}

Embedding EmbeddingSpace::encodeText(const Mixture& phrases) const {
  const Embedding concept_part = mixConcepts(phrases).normalized();
  return (kTextCommon * text_direction_ +
          std::sqrt(1.0F - kTextCommon * kTextCommon) * concept_part)
      .normalized();
}

Embedding EmbeddingSpace::encodeImage(const Mixture& phrases, const std::string& kind,
                                      std::uint64_t appearance, std::uint64_t view_seed) const {
  double total = 0.0;
  for (const auto& phrase : phrases) total += phrase.second;
  const auto scale = static_cast<float>(total > 0.0 ? 1.0 / total : 0.0);
  Embedding v = kImageCommon * image_direction_ + kConcept * scale * mixConcepts(phrases);
  v += kKind * makeDirection(hashText("kind " + kind), kConceptSize, kSize);
  v += kInstance * makeDirection(combineSeeds(appearance, 1), kConceptSize, kSize);
  // The view moves the meaning a little, too.
  v += kView * makeDirection(combineSeeds(view_seed, 2), 2, kSize);
  return v.normalized();
}

EmbeddingSpace::Mixture EmbeddingSpace::makePart(const std::string& phrase,
                                                 const std::string& part) {
  if (part.empty() || part == phrase) return {{phrase, 1.0}};
  return {{phrase, 1.0}, {phrase + "'s " + part, kPartWeight}};
}

}  // namespace tsg::simulation
