// SPDX-License-Identifier: BSD-3-Clause
// What is asked of the running chain: save, pause, reset, time that jumps back, and a backlog.
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "support.h"
#include "synthetic_robot.h"

namespace tsg::test {
namespace {

/// The chain in this process; each test has its own.
class Control : public ::testing::Test {
 protected:
  void SetUp() override {
    setChainParameters(folder_.path(), mapPath());
    ASSERT_NO_FATAL_FAILURE(startStages(loader_, robot_, tracks_, graphs_));
    ASSERT_TRUE(primitives_.waitForPublisher());
  }

  std::string mapPath() const { return (folder_.path() / "map").string(); }

  /// Once the tracker has answered to it.
  void show(const RobotMessages& messages) {
    const std::size_t before = tracks_.messages().size();
    robot_.publish(messages);
    ASSERT_TRUE(waitUntil([&] {
      const auto all = tracks_.messages();
      return std::any_of(all.begin() + static_cast<std::ptrdiff_t>(before), all.end(),
                         [&](const auto& tracks) {
                           return ros_interface::toStamp(tracks->header.stamp) == messages.stamp;
                         });
    })) << "no tracks for "
        << messages.stamp.ns << " ns";
  }
  void play(int first, int end) {
    for (int i = first; i < end; ++i) ASSERT_NO_FATAL_FAILURE(show(makeMessages(i)));
  }

  /// The first frame of a pass: it finds tf cleared, as all would that come before that is done.
  void jumpBack() {
    const auto before = static_cast<std::ptrdiff_t>(tracks_.messages().size());
    robot_.publish(makeMessages(0));
    ASSERT_TRUE(waitUntil([&] {
      const auto all = tracks_.messages();
      return std::any_of(all.begin() + before, all.end(), [](const auto& tracks) {
        return tracks->live.empty() && !tracks->finished.empty();
      });
    })) << "the tracker has not ended the tracks of the pass before";
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // mesh_fusion's own tf
  }

  static std_srvs::TriggerResponse call(const std::string& service) {
    std_srvs::Trigger trigger;
    EXPECT_TRUE(ros::service::call(service, trigger)) << service;
    return trigger.response;
  }
  static msg::FlushResponse flush(const std::string& stage, std::uint8_t mode) {
    msg::Flush flush;
    flush.request.mode = mode;
    EXPECT_TRUE(ros::service::call(stage + "/flush", flush)) << stage;
    return flush.response;
  }
  /// All tracks end and are in the graph.
  static void endTracks() {
    const auto flushed = flush("/scene_graph", msg::FlushRequest::END);
    EXPECT_TRUE(flushed.success) << (flushed.missing.empty() ? "" : flushed.missing.front());
  }

  /// What a listener of the topic knows: id -> is it provisional.
  std::map<std::uint64_t, bool> knownPrimitives() const {
    std::map<std::uint64_t, bool> known;
    for (const auto& message : primitives_.messages()) {
      if (message->is_reset) known.clear();
      for (const auto id : message->withdrawn) known.erase(id);
      for (const auto& primitive : message->primitives) {
        known[primitive.id] = primitive.is_provisional != 0;
      }
    }
    return known;
  }
  std::size_t countProvisional() const {
    const auto known = knownPrimitives();
    return static_cast<std::size_t>(
        std::count_if(known.begin(), known.end(), [](const auto& entry) { return entry.second; }));
  }
  std::size_t numLiveTracks() const { return tracks_.messages().back()->live.size(); }
  std::size_t numObjects() const { return graphs_.messages().back()->objects.size(); }
  std::string diagnosticsOf(const std::string& stage, const std::string& key) {
    const auto lines = findDiagnostics(diagnostics_, stage);
    const auto found = lines.find(key);
    return found == lines.end() ? "" : found->second;
  }

  TemporaryFolder folder_;
  Robot robot_;
  Recorder<msg::Tracks> tracks_{"tracks"};
  Recorder<msg::ObjectPrimitives> primitives_{"object_primitives"};
  Recorder<msg::SceneGraph> graphs_{"scene_graph"};
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{"/diagnostics"};
  nodelet::Loader loader_{false};
};

TEST_F(Control, ObjectsAreInTheGraphWhileTheRobotLooksAtThem) {
  ASSERT_NO_FATAL_FAILURE(play(0, 8));
  EXPECT_TRUE(waitUntil([&] { return numObjects() == 2; }));
  EXPECT_GE(numLiveTracks(), 2U);
  EXPECT_GE(countProvisional(), 2U);
  EXPECT_EQ(countProvisional(), knownPrimitives().size());
}

TEST_F(Control, SavingInMidRunEndsNothingAndChangesNothing) {
  ASSERT_NO_FATAL_FAILURE(play(0, 12));
  const std::size_t live = numLiveTracks();
  const auto saved = call("/scene_graph/save_map");
  EXPECT_TRUE(saved.success) << saved.message;
  const auto summary = nlohmann::json::parse(std::ifstream(mapPath() + "/summary.json"));
  EXPECT_EQ(summary.at("counts").at("objects"), 2);
  ASSERT_NO_FATAL_FAILURE(play(12, 13));
  EXPECT_EQ(numLiveTracks(), live);
  ASSERT_NO_FATAL_FAILURE(play(13, 24));
  EXPECT_TRUE(call("/scene_graph/save_map").success);
  const std::size_t live_at_end = numLiveTracks();
  EXPECT_LE(knownPrimitives().size(), live_at_end);
  endTracks();
  EXPECT_LE(knownPrimitives().size(), live_at_end);
  EXPECT_EQ(countProvisional(), 0U);
  EXPECT_EQ(numObjects(), 2U);
  const auto end = nlohmann::json::parse(std::ifstream(mapPath() + "/summary.json"));
  EXPECT_EQ(end.at("counts").at("objects"), 2);
}

TEST_F(Control, SaveMapSaysStageByStageWhatTheMapHolds) {
  ASSERT_NO_FATAL_FAILURE(play(0, 8));
  const auto saved = call("/scene_graph/save_map");
  const std::string live = "/tracker: " + std::to_string(numLiveTracks()) + " live tracks";
  const std::string primitives = std::to_string(countProvisional());
  EXPECT_EQ(saved.message.substr(0, saved.message.find('\n')), mapPath());
  for (const auto& part : {live,
                           "/mesh_fusion: " + primitives + " object primitives, " + primitives +
                               " of them provisional",
                           std::string("/scene_graph: 2 objects")}) {
    EXPECT_NE(saved.message.find(part), std::string::npos) << saved.message;
  }
}

TEST_F(Control, EachPassOfABagInALoopGivesItsOwnPrimitives) {
  ASSERT_NO_FATAL_FAILURE(play(1, 16));
  const std::size_t live = numLiveTracks();
  ASSERT_GE(live, 2U);
  for (int pass = 0; pass < 2; ++pass) {
    ASSERT_NO_FATAL_FAILURE(jumpBack());
    ASSERT_NO_FATAL_FAILURE(play(1, 16));
  }
  endTracks();
  EXPECT_EQ(knownPrimitives().size(), 3 * live);
  EXPECT_EQ(countProvisional(), 0U);
  EXPECT_EQ(diagnosticsOf("mesh_fusion", "tracks without an object: no frames"), "");
  std::set<std::uint32_t> epochs;
  for (const auto& tracks : tracks_.messages()) epochs.insert(tracks->epoch);
  EXPECT_EQ(epochs, (std::set<std::uint32_t>{1, 2, 3}));
}

TEST_F(Control, PausedStagesTakeNothingInUntilTheyGoOn) {
  ASSERT_NO_FATAL_FAILURE(play(0, 6));
  EXPECT_TRUE(call("/scene_graph/pause").success);
  EXPECT_TRUE(waitUntil([&] { return diagnosticsOf("mesh_fusion", "paused") == "yes"; }));
  const std::size_t before = tracks_.messages().size();
  for (int i = 6; i < 10; ++i) robot_.publish(makeMessages(i));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(tracks_.messages().size(), before);
  EXPECT_TRUE(call("/scene_graph/resume").success);
  ASSERT_NO_FATAL_FAILURE(play(10, 14));
  endTracks();
  EXPECT_EQ(knownPrimitives().size(), 2U);
}

TEST_F(Control, ResetForgetsTheMapAndTheRobotGoesOn) {
  ASSERT_NO_FATAL_FAILURE(play(0, 8));
  ASSERT_TRUE(waitUntil([&] { return numObjects() == 2; }));
  const auto reset = call("/scene_graph/reset");
  EXPECT_TRUE(reset.success) << reset.message;
  EXPECT_TRUE(waitUntil([&] { return numObjects() == 0; }));
  EXPECT_TRUE(knownPrimitives().empty());
  ASSERT_NO_FATAL_FAILURE(play(8, 20));
  endTracks();
  EXPECT_EQ(knownPrimitives().size(), 2U);
  EXPECT_EQ(numObjects(), 2U);
}

TEST_F(Control, OrdersAreCarriedOutHoweverFullTheQueuesAre) {
  for (int i = 0; i < 40; ++i) robot_.publish(makeMessages(i));
  for (int i = 0; i < 4; ++i) {
    const std::size_t before = tracks_.messages().size();
    EXPECT_TRUE(flush("/tracker", msg::FlushRequest::END).success);
    EXPECT_TRUE(waitUntil([&] {
      const auto all = tracks_.messages();
      return std::any_of(all.begin() + static_cast<std::ptrdiff_t>(before), all.end(),
                         [](const auto& tracks) {
                           return tracks->segment_tracks.empty() && tracks->live.empty();
                         });
    }));
  }
}

TEST_F(Control, WhatComesAfterAFlushAtTheEndIsInTheFilesOfAStageThatIsUnloaded) {
  const auto readStamp = [&] {
    return nlohmann::json::parse(std::ifstream(mapPath() + "/summary.json"))
        .at("stamp_s")
        .get<double>();
  };
  ASSERT_NO_FATAL_FAILURE(play(0, 8));
  endTracks();
  const double stamp_s = readStamp();
  ASSERT_NO_FATAL_FAILURE(play(8, 30));
  flush("/tracker", msg::FlushRequest::SNAPSHOT);
  flush("/mesh_fusion", msg::FlushRequest::SNAPSHOT);
  flush("/scene_graph", msg::FlushRequest::SNAPSHOT);
  ASSERT_TRUE(waitUntil([&] {
    return ros_interface::toStamp(graphs_.messages().back()->header.stamp).seconds() > stamp_s;
  }));
  loader_.unload("/scene_graph");
  EXPECT_GT(readStamp(), stamp_s);
}

TEST_F(Control, ABacklogOfAHundredTracksIsInTheMapThatIsSaved) {
  for (int i = 0; i < 8; ++i) ASSERT_NO_FATAL_FAILURE(show(makeGridMessages(i)));
  ASSERT_GE(numLiveTracks(), 100U);
  const std::size_t live = numLiveTracks();
  EXPECT_TRUE(flush("/tracker", msg::FlushRequest::END).success);
  const auto saved = call("/scene_graph/save_map");
  EXPECT_TRUE(saved.success) << saved.message;
  std::size_t without_object = 0;
  ASSERT_TRUE(waitUntil([&] {
    without_object = 0;
    for (const auto& [key, value] : findDiagnostics(diagnostics_, "mesh_fusion")) {
      if (key.rfind("tracks without an object", 0) == 0) without_object += std::stoul(value);
    }
    return knownPrimitives().size() + without_object == live;
  })) << knownPrimitives().size()
      << " + " << without_object << " of " << live;
  EXPECT_GE(knownPrimitives().size(), 80U);
  EXPECT_EQ(countProvisional(), 0U);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "control_test"); }
