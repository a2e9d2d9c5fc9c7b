// SPDX-License-Identifier: BSD-3-Clause
#include "scene_graph/region_embedding.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace tsg::scene_graph {
namespace {

constexpr Eigen::Index kSize = 16;

/// Places that come, go and change by chance.
class RandomPlaces {
 public:
  explicit RandomPlaces(unsigned seed) : random_(seed) {}

  void set(std::uint64_t id) {
    places_[id].id = PlaceId{id};
    places_[id].embedding = makeEmbedding();
  }
  void erase(std::uint64_t id) { places_.erase(id); }
  std::uint64_t pickId(std::uint64_t end) { return 1 + random_() % end; }

  std::vector<const Place*> members() const {
    std::vector<const Place*> members;
    for (const auto& [id, place] : places_) members.push_back(&place);
    return members;
  }

 private:
  SharedEmbedding makeEmbedding() {
    const auto kind = random_() % 20;
    if (kind == 0) return {};                                 // none
    if (kind == 1) return Embedding::Zero(kSize).eval();      // no direction
    if (kind == 2) return Embedding::Ones(kSize / 2).eval();  // of another size
    return Embedding::NullaryExpr(kSize, [&](auto) { return spread_(random_); }).eval();
  }

  std::mt19937 random_;
  std::normal_distribution<float> spread_{1.0F, 100.0F};
  std::map<std::uint64_t, Place> places_;
};

Embedding computeMean(const std::vector<const Place*>& members) {
  EmbeddingMean mean;
  for (const Place* place : members) {
    if (place->embedding.hasDirection() && place->embedding.size() == kSize) {
      mean.add(place->embedding);
    }
  }
  return mean.mean();
}

TEST(RegionEmbedding, UpdatedIsTheSameToTheBitAsComputedAnew) {
  RandomPlaces places(7);
  RegionEmbedding kept;
  for (int step = 0; step < 300; ++step) {
    RegionEmbedding::BlockSet changed;
    for (int i = 0; i < 5; ++i) {
      const std::uint64_t id = places.pickId(400 + 10 * static_cast<std::uint64_t>(step));
      changed.insert(RegionEmbedding::blockOf(PlaceId{id}));
      places.set(id);
      places.erase(places.pickId(id));  // an update sees by the ids that it is gone
    }
    const auto members = places.members();
    const Embedding updated = kept.update(members, kSize, changed);
    ASSERT_EQ(updated, RegionEmbedding().update(members, kSize, {})) << step;
    const Embedding expected = computeMean(members);
    ASSERT_LT((updated - expected).norm(), 1e-5F * (1.0F + expected.norm())) << step;
  }
}

TEST(RegionEmbedding, ReadsOnlyBlocksThatChanged) {
  std::vector<Place> places(200);
  std::vector<const Place*> members;
  for (std::uint64_t i = 0; i < places.size(); ++i) {
    places[i].id = PlaceId{i + 1};
    places[i].embedding = Embedding::Ones(kSize).eval();
    members.push_back(&places[i]);
  }
  RegionEmbedding region;
  region.update(members, kSize, {});
  places[5].embedding = Embedding::Constant(kSize, 201.0F).eval();
  EXPECT_EQ(region.update(members, kSize, {})[0], 1.0F) << "nobody said that it changed";
  const Embedding mean = region.update(members, kSize, {RegionEmbedding::blockOf(places[5].id)});
  EXPECT_EQ(mean[0], 2.0F);
}

TEST(RegionEmbedding, FollowsTheSizeThatCounts) {
  std::vector<Place> places(3);
  for (std::uint64_t i = 0; i < places.size(); ++i) places[i].id = PlaceId{i + 1};
  places[1].embedding = Embedding::Ones(4).eval();
  places[2].embedding = Embedding::Ones(8).eval();
  const std::vector<const Place*> members{&places[0], &places[1], &places[2]};
  RegionEmbedding region;
  EXPECT_EQ(region.update(members, 0, {}).size(), 4) << "of the first that has a direction";
  EXPECT_EQ(region.update(members, 8, {}).size(), 8);
  EXPECT_EQ(region.update(members, 4, {}).size(), 4);
  EXPECT_EQ(region.update(members, 16, {}).size(), 0) << "of none";
  EXPECT_EQ(region.update({&places[0]}, 0, {}).size(), 0);
}

}  // namespace
}  // namespace tsg::scene_graph
