// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/object_layer.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "random_world.h"
#include "sample_graph.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/bottleneck/reach.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/scene_graph/scoring.h"

namespace tsg::scene_graph {
namespace {

using Primitives = std::vector<ObjectPrimitivePtr>;
using Ids = std::vector<PrimitiveId>;

double bestCosine(const Embedding& embedding, const TaskList& tasks) {
  return findBestTask(embedding, bottleneck::TaskScorer(tasks.embeddings)).cosine;
}

/// The objects' primitives, to compare partitions.
std::vector<Ids> listMembers(const std::vector<SceneObject>& objects) {
  std::vector<Ids> members;
  for (const auto& object : objects) members.push_back(object.primitives);
  std::sort(members.begin(), members.end());
  return members;
}

std::vector<SceneObject> computeObjects(const SceneGraphConfig& config, const TaskList& tasks,
                                        const Primitives& primitives) {
  ObjectLayer layer(config);
  layer.setTasks(tasks);
  layer.add(primitives);
  return layer.computeObjects();
}

/// Members of the published clusters, straight from the clustering, all primitives at once.
std::vector<Ids> clusterDirectly(const SceneGraphConfig& config, const TaskList& tasks,
                                 const Primitives& primitives) {
  using bottleneck::IncrementalClustering;
  IncrementalClustering clustering(config.objectClustering(),
                                   IncrementalClustering::Adjacency::kBoxOverlap);
  clustering.setTasks(tasks.embeddings);
  std::map<std::uint64_t, Embedding> embeddings;
  for (const auto& primitive : primitives) {
    if (primitive->embedding.size() == 0) continue;
    clustering.insert(primitive->id.value, primitive->embedding,
                      bottleneck::extendUpAndDown(primitive->box, config.object_reach));
    embeddings[primitive->id.value] = primitive->embedding;
  }
  std::vector<Ids> published;
  for (const auto& cluster : clustering.clusters()) {
    Ids ids;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(RandomWorld::kSize);
    for (const auto key : cluster.members) {
      ids.push_back({key});
      sum += embeddings.at(key).cast<double>();
    }
    const Embedding mean = (sum / static_cast<double>(ids.size())).cast<float>();
    if (cluster.task != 0 && bestCosine(mean, tasks) >= config.object_alpha) {
      published.push_back(ids);
    }
  }
  std::sort(published.begin(), published.end());
  return published;
}

class RandomObjects : public ::testing::TestWithParam<unsigned> {
 protected:
  RandomWorld world_{GetParam()};
  Primitives primitives_ = world_.makePrimitives(120, 6.0, 1);
};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomObjects, ::testing::Range(1U, 9U));

TEST_P(RandomObjects, FollowTheReachOfTheirPrimitivesWhenItIsTurned) {
  const TaskList& tasks = world_.tasks();
  Primitives primitives;  // far apart, and above each one like it with a gap
  for (const auto& given : world_.makePrimitives(60, 14.0, 1)) {
    primitives.push_back(given);
    auto above = std::make_shared<ObjectPrimitive>(*given);
    above->id.value += 1000;
    above->box.translate(Eigen::Vector3d(0.0, 0.0, 1.2 * given->box.sizes().z()));
    primitives.push_back(above);
  }
  SceneGraphConfig config;
  config.object_reach = 0.0;
  ObjectLayer layer(config);
  layer.setTasks(tasks);
  layer.add(primitives);
  const auto before = listMembers(layer.computeObjects());
  EXPECT_EQ(before, clusterDirectly(config, tasks, primitives));
  config.object_reach = 0.5;
  layer.setConfig(config);
  const auto reaching = listMembers(layer.computeObjects());
  EXPECT_EQ(reaching, clusterDirectly(config, tasks, primitives));
  EXPECT_LT(reaching.size(), before.size());
  config.object_reach = 0.0;
  layer.setConfig(config);
  EXPECT_EQ(listMembers(layer.computeObjects()), before);
}

TEST_P(RandomObjects, AreTheRelevantClustersOfABatchRunHoweverPrimitivesArrive) {
  SceneGraphConfig config;
  config.object_delta = world_.draw(0, 1) < 0.5 ? 1e-5 : 5e-3;
  Primitives shuffled = primitives_;
  std::shuffle(shuffled.begin(), shuffled.end(), world_.random());
  ObjectLayer layer(config);
  layer.setTasks(world_.tasks());
  for (std::size_t i = 0; i < shuffled.size(); i += 20) {
    layer.add({shuffled.begin() + static_cast<std::ptrdiff_t>(i),
               shuffled.begin() + static_cast<std::ptrdiff_t>(i + 20)});
    const Primitives present(shuffled.begin(),
                             shuffled.begin() + static_cast<std::ptrdiff_t>(i + 20));
    ASSERT_EQ(listMembers(layer.computeObjects()),
              clusterDirectly(config, world_.tasks(), present));
  }
  EXPECT_FALSE(layer.computeObjects().empty());
}

/// The same primitive as it was while its track lived: with another box and embedding.
ObjectPrimitivePtr makeProvisional(const ObjectPrimitive& primitive, RandomWorld& world) {
  auto provisional = std::make_shared<ObjectPrimitive>(primitive);
  provisional->is_provisional = true;
  provisional->box.max() += Eigen::Vector3d::Constant(world.draw(0, 0.3));
  provisional->embedding = Embedding{};
  if (world.draw(0, 1) > 0.2) provisional->embedding = world.makeEmbedding(1.0F);
  return provisional;
}

TEST_P(RandomObjects, AreThoseOfABatchRunOverWhatIsThereWhileProvisionalOnesComeAndGo) {
  ObjectLayer layer({});
  layer.setTasks(world_.tasks());
  std::map<std::uint64_t, ObjectPrimitivePtr> present;
  for (int step = 0; step < 400; ++step) {
    const auto& primitive = primitives_[world_.drawIndex(primitives_.size())];
    const double action = world_.draw(0, 1);
    const auto known = present.find(primitive->id.value);
    const bool is_final = known != present.end() && !known->second->is_provisional;
    if (action < 0.2) {
      if (!is_final) layer.erase({primitive->id});
      if (!is_final) present.erase(primitive->id.value);
      continue;
    }
    const ObjectPrimitivePtr given = action < 0.7 ? makeProvisional(*primitive, world_) : primitive;
    layer.add({given});
    if (!is_final) present[primitive->id.value] = given;
    if (step % 40 != 0) continue;
    Primitives list;
    for (const auto& entry : present) list.push_back(entry.second);
    ASSERT_EQ(listMembers(layer.computeObjects()), clusterDirectly({}, world_.tasks(), list));
  }
  EXPECT_GT(layer.counters().replaced, 0U);
  EXPECT_GT(layer.counters().repeated, 0U);
}

TEST_P(RandomObjects, EndWhereTheyWouldHaveWithoutProvisionalOnes) {
  ObjectLayer layer({});
  layer.setTasks(world_.tasks());
  for (const auto& primitive : primitives_) {
    layer.add({makeProvisional(*primitive, world_)});
    layer.computeObjects();
    layer.add({primitive});
  }
  const auto expected = computeObjects({}, world_.tasks(), primitives_);
  const auto objects = layer.computeObjects();
  EXPECT_EQ(listMembers(objects), listMembers(expected));
  EXPECT_EQ(layer.primitives(), primitives_);
}

TEST_P(RandomObjects, DescribeTheirPrimitives) {
  SceneGraphConfig config;
  config.object_delta = 5e-3;
  for (const auto& object : computeObjects(config, world_.tasks(), primitives_)) {
    Aabb box;
    Eigen::Vector3d centers_m = Eigen::Vector3d::Zero();
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(RandomWorld::kSize);
    Stamp first = Stamp::fromSeconds(1e9);
    Stamp last;
    for (const PrimitiveId id : object.primitives) {
      const ObjectPrimitive& primitive = *primitives_.at(id.value - 1);
      box.extend(primitive.box);
      centers_m += (primitive.box.min() + primitive.box.max()) / 2;
      sum += primitive.embedding.cast<double>();
      first = std::min(first, primitive.first_seen);
      last = std::max(last, primitive.last_seen);
    }
    const auto count = static_cast<double>(object.primitives.size());
    EXPECT_TRUE(object.position_m.isApprox(centers_m / count, 1e-12));
    EXPECT_TRUE(object.box.isApprox(box, 0.0));
    for (const PrimitiveId id : object.primitives) {  // these have no oriented boxes of their own
      for (const auto& corner : toOrientedBox(primitives_.at(id.value - 1)->box).corners()) {
        EXPECT_TRUE(object.oriented_box.contains(corner.cast<double>(), 1e-4));
      }
    }
    EXPECT_LE(object.oriented_box.volume(), 1.001 * box.volume());
    EXPECT_TRUE(object.embedding.isApprox((sum / count).cast<float>(), 1e-6F));
    EXPECT_EQ(object.first_seen, first);
    EXPECT_EQ(object.last_seen, last);
    EXPECT_TRUE(std::is_sorted(object.primitives.begin(), object.primitives.end()));
  }
}

TEST_P(RandomObjects, ServeTheTaskOfHighestCosine) {
  const TaskList& tasks = world_.tasks();
  for (const auto& object : computeObjects({}, tasks, primitives_)) {
    EXPECT_EQ(object.task, tasks.names.at(static_cast<std::size_t>(object.task_index)));
    for (Eigen::Index j = 0; j < tasks.embeddings.rows(); ++j) {
      const Embedding task = tasks.embeddings.row(j).transpose();
      const double cosine =
          static_cast<double>(object.embedding.normalized().dot(task.normalized()));
      EXPECT_LE(cosine, object.score + 1e-6);
      if (j == object.task_index) {
        EXPECT_NEAR(cosine, object.score, 1e-6);
      }
    }
    EXPECT_GE(object.score, SceneGraphConfig().object_alpha);
  }
}

TEST_P(RandomObjects, AreTheRelevantPrimitivesOneByOneForDeltaZero) {
  SceneGraphConfig config;
  config.object_delta = 0.0;
  std::vector<Ids> relevant;
  for (const auto& primitive : primitives_) {
    if (primitive->embedding.size() == 0) continue;
    if (bestCosine(primitive->embedding, world_.tasks()) >= config.object_alpha) {
      relevant.push_back({primitive->id});
    }
  }
  EXPECT_EQ(listMembers(computeObjects(config, world_.tasks(), primitives_)), relevant);
}

TEST_P(RandomObjects, AreGroupsOfOverlappingBoxesForDeltaOne) {
  RandomWorld world(GetParam(), 1);
  Primitives primitives;
  for (const auto& given : world.makePrimitives(60, 8.0, 1)) {
    auto primitive = std::make_shared<ObjectPrimitive>(*given);
    primitive->embedding = world.makeEmbedding(20.0F);
    primitives.push_back(primitive);
  }
  SceneGraphConfig config;
  config.object_reach = 0.0;
  config.object_delta = 1.0;
  std::vector<Ids> expected;
  for (const auto& group : findComponents(primitives.size(), [&](std::size_t i, std::size_t j) {
         return hasOverlap(primitives[i]->box, primitives[j]->box);
       })) {
    expected.emplace_back();
    for (const std::size_t i : group) expected.back().push_back(primitives[i]->id);
  }
  EXPECT_GT(expected.size(), 1U);
  EXPECT_LT(expected.size(), primitives.size());
  EXPECT_EQ(listMembers(computeObjects(config, world.tasks(), primitives)), expected);
}

TEST_P(RandomObjects, KeepTheirIdsWhileTheyKeepTheirPrimitives) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  std::map<Ids, ObjectId> ids;
  std::size_t kept = 0;
  for (int round = 0; round < 6; ++round) {
    layer.add(world_.makePrimitives(20, 8.0, 1 + 20 * static_cast<std::uint64_t>(round)));
    std::map<Ids, ObjectId> now;
    for (const auto& object : layer.computeObjects()) now[object.primitives] = object.id;
    for (const auto& [members, id] : now) {
      const auto before = ids.find(members);
      if (before == ids.end()) continue;
      EXPECT_EQ(id, before->second);
      ++kept;
    }
    ids = now;
  }
  EXPECT_GT(kept, 10U);
}

TEST_P(RandomObjects, AreThoseOfTheOtherPrimitivesAfterSomeAreErased) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  layer.add(primitives_);
  layer.computeObjects();
  Primitives kept;
  Ids erased;
  for (const auto& primitive : primitives_) {
    if (world_.draw(0, 1) < 0.3) {
      erased.push_back(primitive->id);
    } else {
      kept.push_back(primitive);
    }
  }
  erased.push_back({12345});  // not there
  EXPECT_EQ(layer.erase(erased), erased.size() - 1);
  EXPECT_EQ(layer.primitives(), kept);
  EXPECT_EQ(listMembers(layer.computeObjects()), clusterDirectly({}, world_.tasks(), kept));
  layer.add(primitives_);
  EXPECT_EQ(layer.counters().repeated, kept.size());
  EXPECT_EQ(listMembers(layer.computeObjects()), clusterDirectly({}, world_.tasks(), primitives_));
}

TEST_P(RandomObjects, AreThoseOfTheNewPrimitivesAfterSomeAreReplaced) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  layer.add(primitives_);
  layer.computeObjects();
  const Primitives newer = world_.makePrimitives(120, 6.0, 1);
  Primitives present = primitives_;
  Primitives replacements;
  for (std::size_t i = 0; i < present.size(); i += 3) {
    present[i] = newer[i];
    replacements.push_back(newer[i]);
  }
  const PrimitiveUpdate update = layer.add(replacements, Repeated::kReplace);
  EXPECT_EQ(update.counters.replaced, replacements.size());
  EXPECT_EQ(update.counters.repeated, 0U);
  EXPECT_EQ(layer.primitives(), present);
  EXPECT_EQ(listMembers(layer.computeObjects()), clusterDirectly({}, world_.tasks(), present));
}

TEST_P(RandomObjects, AreAllAmongTheClustersAndNothingIsForgottenBetweenTheTwo) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  for (std::size_t i = 0; i < primitives_.size(); i += 40) {
    const auto begin = primitives_.begin() + static_cast<std::ptrdiff_t>(i);
    layer.add({begin, begin + 40});
    const auto clusters = layer.computeClusters();
    std::map<ObjectId, Ids> members;
    std::size_t count = 0;
    for (const auto& cluster : clusters) {
      members[cluster.id] = cluster.primitives;
      count += cluster.primitives.size();
    }
    EXPECT_EQ(members.size(), clusters.size());
    EXPECT_EQ(count, layer.counters().clustered);
    const auto objects = layer.computeObjects();
    EXPECT_EQ(listMembers(objects),
              clusterDirectly({}, world_.tasks(), {primitives_.begin(), begin + 40}));
    for (const auto& object : objects) EXPECT_EQ(members.at(object.id), object.primitives);
  }
}

TEST_P(RandomObjects, AreNoneWithAlphaAboveAllScores) {
  SceneGraphConfig config;
  config.object_alpha = 1.0;
  EXPECT_TRUE(computeObjects(config, world_.tasks(), primitives_).empty());
}

TEST_P(RandomObjects, FollowEveryChangeOfTheConfigurationAsIfItHadBeenSoFromTheStart) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  layer.add(primitives_);
  for (int i = 0; i < 10; ++i) {
    SceneGraphConfig config;
    config.object_alpha = world_.draw(0.1, 0.7);
    config.object_delta = std::pow(10.0, world_.draw(-6, -1));
    config.object_top_k = 1 + i % 4;
    config.prune_null = i % 3 != 0;
    layer.setConfig(config);
    EXPECT_EQ(listMembers(layer.computeObjects()),
              clusterDirectly(config, world_.tasks(), primitives_));
  }
}

TEST_P(RandomObjects, FollowAChangeOfTasks) {
  RandomWorld other(GetParam() + 100, 3);
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(world_.tasks());
  layer.add(primitives_);
  layer.computeObjects();
  layer.setTasks(other.tasks());
  EXPECT_EQ(listMembers(layer.computeObjects()), clusterDirectly({}, other.tasks(), primitives_));
  layer.setTasks({});
  EXPECT_TRUE(layer.computeObjects().empty());
}

TaskList makeTwoTasks() {
  TaskList tasks;
  tasks.names = {"cup", "sofa"};
  tasks.embeddings.resize(2, 3);
  tasks.embeddings << 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F;
  return tasks;
}

TEST(Objects, KeepTheirIdWhileTheirPrimitiveIsReplacedAndLoseItWithItsEmbedding) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(makeTwoTasks());
  layer.add({makePrimitive(1, {0, 0, 0}, makeEmbedding({0.6F, 0, 0.8F})),
             makePrimitive(2, {9, 0, 0}, makeEmbedding({0.6F, 0, 0.8F}))});
  const auto before = layer.computeObjects();
  ASSERT_EQ(before.size(), 2U);
  layer.add({makePrimitive(2, {5, 0, 0}, makeEmbedding({0, 0.8F, 0.6F}))}, Repeated::kReplace);
  const auto after = layer.computeObjects();
  ASSERT_EQ(after.size(), 2U);
  EXPECT_EQ(after[1].id, before[1].id);
  EXPECT_EQ(after[1].task, "sofa");
  EXPECT_EQ(after[1].position_m.x(), 5.5);
  layer.add({makePrimitive(2, {5, 0, 0}, Embedding())}, Repeated::kReplace);
  EXPECT_EQ(layer.computeObjects().size(), 1U);
  layer.erase({{1}, {2}});
  EXPECT_TRUE(layer.computeObjects().empty());
  EXPECT_EQ(layer.newest(), Stamp{});
  layer.add({makePrimitive(3, {0, 0, 0}, Embedding())});
  EXPECT_EQ(layer.primitives().size(), 1U);
}

TEST(Objects, OfScoreBelowMinObjectScoreAreNotPublished) {
  // cosine 0.6 to "cup"
  const Primitives primitives = {makePrimitive(1, {0, 0, 0}, makeEmbedding({0.6F, 0, 0.8F}))};
  SceneGraphConfig config;
  EXPECT_EQ(computeObjects(config, makeTwoTasks(), primitives).size(), 1U);
  config.min_object_score = 0.59;
  EXPECT_EQ(computeObjects(config, makeTwoTasks(), primitives).size(), 1U);
  config.min_object_score = 0.61;
  EXPECT_TRUE(computeObjects(config, makeTwoTasks(), primitives).empty());
}

TEST(Objects, BackgroundIsNotPublishedHoweverLowTheMinimum) {
  const Primitives primitives = {makePrimitive(1, {0, 0, 0}, makeEmbedding({0.22F, 0, 0.975F}))};
  SceneGraphConfig config;
  config.min_object_score = 0.2;
  EXPECT_TRUE(computeObjects(config, makeTwoTasks(), primitives).empty());
}

TEST(Objects, TakeTheNewNamesOfRenamedTasks) {
  ObjectLayer layer(SceneGraphConfig{});
  TaskList tasks = makeTwoTasks();
  layer.setTasks(tasks);
  layer.add({makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 0, 0}))});
  EXPECT_EQ(layer.computeObjects().at(0).task, "cup");
  tasks.names[0] = "mug";
  layer.setTasks(tasks);
  EXPECT_EQ(layer.computeObjects().at(0).task, "mug");
}

TEST(Objects, OfWhichTheEmbeddingsCancelOutAreNotPublished) {
  SceneGraphConfig config;
  config.object_alpha = 0.0;
  config.object_delta = 1.0;
  config.min_object_score = 0.0;
  const auto objects = computeObjects(config, makeTwoTasks(),
                                      {makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 1, 0})),
                                       makePrimitive(2, {0.5, 0, 0}, makeEmbedding({-1, -1, 0}))});
  EXPECT_TRUE(objects.empty());
}

TEST(Objects, ChangeWithMinObjectScoreAloneAtOnce) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(makeTwoTasks());
  layer.add({makePrimitive(1, {0, 0, 0}, makeEmbedding({0.6F, 0, 0.8F}))});
  EXPECT_EQ(layer.computeObjects().size(), 1U);
  SceneGraphConfig config;
  config.min_object_score = 0.9;
  layer.setConfig(config);
  EXPECT_TRUE(layer.computeObjects().empty());
  layer.setConfig(SceneGraphConfig{});
  EXPECT_EQ(layer.computeObjects().size(), 1U);
}

TEST(Primitives, WithoutEmbeddingAreGeometryOnly) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(makeTwoTasks());
  const PrimitiveUpdate update =
      layer.add({makePrimitive(3, {0, 0, 0}, makeEmbedding({1, 0, 0})),
                 makePrimitive(2, {0.5, 0, 0}, Embedding()),
                 makePrimitive(1, {0.5, 0, 0}, makeEmbedding({0, 0, 0}))});
  EXPECT_EQ(update.counters.clustered, 1U);
  EXPECT_EQ(update.counters.without_embedding, 2U);
  EXPECT_EQ(update.error, "");
  EXPECT_EQ(listMembers(layer.computeObjects()), (std::vector<Ids>{{{3}}}));
  ASSERT_EQ(layer.primitives().size(), 3U);
  EXPECT_EQ(layer.primitives().front()->id, PrimitiveId{1});
}

TEST(Primitives, OfAnotherEmbeddingSizeAreDroppedNamingBothSizes) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(makeTwoTasks());
  PrimitiveUpdate update = layer.add({makePrimitive(7, {0, 0, 0}, makeEmbedding({1, 0})),
                                      makePrimitive(8, {0, 0, 0}, makeEmbedding({1, 0, 0}))});
  EXPECT_EQ(update.counters.rejected, 1U);
  EXPECT_EQ(update.counters.clustered, 1U);
  EXPECT_EQ(update.error,
            "primitive 7 has an embedding of 2 values, expected 3 as the object tasks have");
  EXPECT_EQ(layer.primitives().size(), 1U);

  update = layer.add({makePrimitive(9, {0, 0, 0}, makeEmbedding({1, 0, 0, 0}))});
  EXPECT_EQ(update.error,
            "primitive 9 has an embedding of 4 values, expected 3 as the primitives before have");
  EXPECT_EQ(layer.counters().rejected, 2U);
}

TEST(Primitives, WithoutIdBoxOrFiniteEmbeddingAreDropped) {
  const auto rejected = [](ObjectPrimitive primitive) {
    ObjectLayer layer(SceneGraphConfig{});
    const PrimitiveUpdate update = layer.add({std::make_shared<ObjectPrimitive>(primitive)});
    EXPECT_FALSE(update.error.empty());
    EXPECT_TRUE(layer.primitives().empty());
    return update.counters.rejected == 1;
  };
  const ObjectPrimitive good = *makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 0, 0}));
  ObjectPrimitive bad = good;
  bad.id = {};
  EXPECT_TRUE(rejected(bad));
  bad = good;
  bad.box = Aabb();
  EXPECT_TRUE(rejected(bad));
  bad = good;
  bad.box.max().x() = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(rejected(bad));
  bad = good;
  bad.embedding[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(rejected(bad));
  ObjectLayer layer(SceneGraphConfig{});
  EXPECT_EQ(layer.add({nullptr}).counters.rejected, 1U);
}

TEST(Primitives, GivenTwiceAreTakenOnce) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(makeTwoTasks());
  const auto primitive = makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 0, 0}));
  layer.add({primitive});
  EXPECT_EQ(layer.add({primitive, primitive}).counters.repeated, 2U);
  EXPECT_EQ(layer.computeObjects().size(), 1U);
}

TEST(ObjectTasks, OfAnotherSizeAreRefusedAndTheOldStayInForce) {
  ObjectLayer layer(SceneGraphConfig{});
  layer.setTasks(makeTwoTasks());
  layer.add({makePrimitive(1, {0, 0, 0}, makeEmbedding({1, 0, 0}))});
  TaskList wrong = makeTwoTasks();
  wrong.embeddings = EmbeddingMatrix::Ones(2, 5);
  try {
    layer.setTasks(wrong);
    FAIL() << "accepted tasks of another model";
  } catch (const config::ConfigError& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("object tasks"), std::string::npos) << message;
    EXPECT_NE(message.find("have 5 values, expected 3"), std::string::npos) << message;
  }
  wrong.embeddings.resize(0, 0);
  EXPECT_THROW(layer.setTasks(wrong), config::ConfigError);
  EXPECT_EQ(layer.computeObjects().size(), 1U);
}

}  // namespace
}  // namespace tsg::scene_graph
