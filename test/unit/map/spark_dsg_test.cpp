// SPDX-License-Identifier: BSD-3-Clause
// Maps whose scene graph the PyPI package spark_dsg has read, edited and written.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>

#include "../scene_graph/random_world.h"
#include "support.h"
#include "task_scene_graph/map/files.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;

constexpr int kCannotImport = 77;

/// Exit status and output of a shell command.
std::pair<int, std::string> runCommand(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string output;
  for (int byte = std::fgetc(pipe); byte != EOF; byte = std::fgetc(pipe)) {
    output += static_cast<char>(byte);
  }
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output};
}

Map makeRandomMap(unsigned seed) {
  scene_graph::RandomWorld world(seed);
  scene_graph::SceneGraphConfig config;
  config.object_alpha = 0.1;
  scene_graph::SceneGraphBuilder builder(config, "odom");
  builder.setObjectTasks(world.tasks());
  builder.setPlaceTasks(world.tasks());
  builder.addPrimitives(world.makePrimitives(30, 6.0, 1));
  builder.setPlaces(std::make_shared<const PlaceGraph>(world.makePlaces(40)));
  return makeMap(builder);
}

class RewrittenMap : public testing::Test {
 protected:
  /// False if the package is not here.
  bool rewrite(const Map& map, const std::string& edits = "") {
    writeMap(folder(), map);
    const std::string script =
        std::string(TSG_SOURCE_DIR) + "/test/unit/map/" + "spark_dsg_rewrite.py";
    const auto [status, output] =
        runCommand("'" + script + "' '" + (folder() / "scene_graph.json").string() + "' " + edits);
    output_ = output;
    EXPECT_TRUE(status == 0 || status == kCannotImport) << output;
    return status != kCannotImport;
  }
  fs::path folder() const { return temporary_.path() / "map"; }

  test::TemporaryFolder temporary_;
  std::string output_;
};

TEST_F(RewrittenMap, RandomMapsAreThoseOfBefore) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Map map = makeRandomMap(seed);
    if (!rewrite(map)) GTEST_SKIP() << output_;
    const LoadedMap loaded = loadMap(folder());
    ASSERT_FALSE(loaded.notes.empty());
    EXPECT_NE(loaded.notes.front().find("as they were"), std::string::npos)
        << "seed " << seed << ": " << loaded.notes.front();
    ASSERT_EQ(loaded.map.primitives().size(), map.primitives().size());
    for (std::size_t i = 0; i < map.primitives().size(); ++i) {
      EXPECT_EQ(loaded.map.primitives()[i]->embedding, map.primitives()[i]->embedding);
      EXPECT_EQ(loaded.map.primitives()[i]->box.min(), map.primitives()[i]->box.min());
    }
    EXPECT_EQ(computeSceneGraph(loaded.map).objects.size(), computeSceneGraph(map).objects.size());
  }
}

TEST_F(RewrittenMap, APrimitiveThatWasErasedIsGone) {
  const Map map = makeRandomMap(7);
  if (!rewrite(map, "--erase s4")) GTEST_SKIP() << output_;
  const LoadedMap loaded = loadMap(folder());
  EXPECT_EQ(loaded.map.findPrimitive({4}), nullptr);
  EXPECT_EQ(loaded.map.primitives().size() + 1, map.primitives().size());
}

TEST_F(RewrittenMap, APrimitiveThatWasMovedIsElsewhere) {
  const Map map = makeRandomMap(8);
  PrimitiveId id;
  for (const auto& primitive : map.primitives()) {
    if (primitive->embedding.size() > 0) id = primitive->id;
  }
  if (!rewrite(map, "--move s" + std::to_string(id.value) + " 2.5")) GTEST_SKIP() << output_;
  const Aabb before = map.findPrimitive(id)->box;
  const Aabb after = loadMap(folder()).map.findPrimitive(id)->box;
  EXPECT_NEAR(after.center().x(), before.center().x() + 2.5, 1e-4);
  EXPECT_NEAR(after.center().y(), before.center().y(), 1e-4);
}

}  // namespace
}  // namespace tsg::map
