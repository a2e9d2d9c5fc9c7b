// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/embedding_space.h"

#include <gtest/gtest.h>

#include <set>

#include "task_scene_graph/simulation/ground_truth.h"
#include "task_scene_graph/simulation/segment_simulator.h"

namespace tsg::simulation {
namespace {

/// Every phrase that any room can hold.
std::set<std::string> listPhrases() {
  std::set<std::string> phrases;
  for (int seed = 1; seed <= 4; ++seed) {
    for (const Instance& instance : buildApartment({seed, 8}).instances)
      phrases.insert(instance.phrase);
  }
  return phrases;
}

TEST(EmbeddingSpace, AnImageFitsItsOwnPhraseAndNoOtherAsInClip) {
  const EmbeddingSpace space;
  const std::set<std::string> phrases = listPhrases();
  ASSERT_GT(phrases.size(), 45U);
  for (const std::string& shown : phrases) {
    for (std::uint64_t view = 0; view < 3; ++view) {
      const Embedding image = space.encodeImage({{shown, 1.0}}, shown, view * 31 + 7, view);
      for (const std::string& asked : phrases) {
        const double cosine = computeCosine(image, space.encodeText(asked));
        if (asked == shown) {
          EXPECT_GT(cosine, 0.24) << shown;
          EXPECT_LT(cosine, 0.31) << shown;
        } else {
          EXPECT_GT(cosine, 0.13) << shown << " / " << asked;
          EXPECT_LT(cosine, 0.235) << shown << " / " << asked;
        }
      }
    }
  }
}

TEST(EmbeddingSpace, OnlyPhrasesWithACommonHeadComeNearToEachOther) {
  const EmbeddingSpace space;
  const Embedding table = space.encodeImage({{"coffee table", 1.0}}, "coffee table", 1, 1);
  const double head = computeCosine(table, space.encodeText("dining table"));
  EXPECT_GT(head, 0.19);
  EXPECT_LT(head, 0.23);
  EXPECT_LT(computeCosine(table, space.encodeText("coffee mug")), 0.22);
}

TEST(EmbeddingSpace, PartsFitThePhraseOfTheWholeThing) {
  const Apartment apartment = buildApartment({1, 6});
  const SegmentSimulator segments(apartment, SegmentConfig{});
  const EmbeddingSpace space;
  for (std::uint16_t part = 1; part <= apartment.parts.size(); ++part) {
    const Instance& thing = apartment.instances[apartment.parts[part - 1U].instance - 1U];
    const double cosine =
        computeCosine(segments.embedPart(part, 3), space.encodeText(thing.phrase));
    EXPECT_GT(cosine, 0.235) << thing.phrase << " " << apartment.parts[part - 1U].name;
    EXPECT_LT(cosine, 0.31);
  }
}

TEST(EmbeddingSpace, ViewsOfAThingAreCloserThanThingsOfAClassThanOthers) {
  const EmbeddingSpace space;
  const Embedding a = space.encodeImage({{"bottle", 1.0}}, "bottle", 1, 1);
  EXPECT_GT(computeCosine(a, space.encodeImage({{"bottle", 1.0}}, "bottle", 1, 2)), 0.95);
  const double same_class = computeCosine(a, space.encodeImage({{"bottle", 1.0}}, "bottle", 2, 3));
  EXPECT_GT(same_class, 0.75);
  EXPECT_LT(same_class, 0.9);
  const double other = computeCosine(a, space.encodeImage({{"sofa", 1.0}}, "sofa", 3, 4));
  EXPECT_GT(other, 0.45);
  EXPECT_LT(other, 0.7);
}

TEST(EmbeddingSpace, TasksOfSeveralPhrasesFitEachOfThem) {
  const EmbeddingSpace space;
  const Embedding task = space.encodeText({{"book", 1.0}, {"magazine", 1.0}});
  for (const char* phrase : {"book", "magazine"}) {
    const double cosine = computeCosine(space.encodeImage({{phrase, 1.0}}, phrase, 5, 6), task);
    EXPECT_GT(cosine, 0.235);
    EXPECT_LT(cosine, 0.31);
  }
}

TEST(EmbeddingSpace, VectorsAreUnitAndFollowFromWords) {
  const EmbeddingSpace space;
  EXPECT_NEAR(space.encodeText("sofa").norm(), 1.0F, 1e-5F);
  EXPECT_NEAR(space.encodeImage({{"sofa", 1.0}}, "sofa", 1, 2).norm(), 1.0F, 1e-5F);
  EXPECT_EQ(space.encodeText("sofa"), EmbeddingSpace().encodeText("sofa"));
  EXPECT_GT(computeCosine(space.encodeText("sofa"), space.encodeText("toilet")), 0.5);
}

TEST(EmbeddingSpace, ImagesOfAMixtureLieBetweenTheirRooms) {
  const EmbeddingSpace space;
  const Embedding half = space.encodeImage({{"kitchen", 1.0}, {"corridor", 1.0}}, "scene", 1, 2);
  const Embedding whole = space.encodeImage({{"kitchen", 2.0}}, "scene", 1, 2);
  const Embedding kitchen = space.encodeText("kitchen");
  EXPECT_GT(computeCosine(whole, kitchen), computeCosine(half, kitchen) + 0.03);
  EXPECT_GT(computeCosine(half, kitchen), 0.2);
}

}  // namespace
}  // namespace tsg::simulation
