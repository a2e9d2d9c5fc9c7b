// SPDX-License-Identifier: BSD-3-Clause
// What a robot's programs ask of the scene graph while it grows: other tasks, questions, reasons.
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/GetMesh.h>
#include <task_scene_graph/GetObject.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <map>
#include <set>

#include "support.h"
#include "synthetic_robot.h"
#include "task_scene_graph/scene_graph/builder.h"

namespace tsg::test {
namespace {

using Action = msg::ChangeTasksRequest;
using Members = std::set<std::vector<std::uint64_t>>;

ObjectPrimitivePtr makePrimitive(std::uint64_t id, double x_m, const Embedding& embedding) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {id};
  primitive->track = {id};
  primitive->box = makeAabb({x_m, 0, 0}, {x_m + 1, 1, 1});
  primitive->oriented_box = toOrientedBox(primitive->box);
  primitive->embedding = embedding;
  primitive->first_seen = Stamp::fromSeconds(1.0);
  primitive->last_seen = Stamp::fromSeconds(10.0 + static_cast<double>(id));
  const auto left_m = static_cast<float>(x_m);
  primitive->mesh.vertices = {{left_m, 0, 0}, {left_m + 1, 0, 0}, {left_m, 1, 1}};
  primitive->mesh.colors.assign(3, {10, 20, 30});
  primitive->mesh.triangles = {{0, 1, 2}};
  primitive->thumbnail.image = cv::Mat(4, 6, CV_8UC3, cv::Scalar(1, 2, 3));
  return primitive;
}

/// Two mugs and a book that touch, a plate and a spoon far away.
std::vector<ObjectPrimitivePtr> makePrimitives() {
  return {makePrimitive(1, 0.0, makeUnit(0)), makePrimitive(2, 0.5, makeUnit(0)),
          makePrimitive(3, 1.0, makeUnit(1)), makePrimitive(4, 10.0, makeUnit(2)),
          makePrimitive(5, 20.0, makeUnit(3))};
}

msg::Task makeTask(const std::string& name, int axis = -1) {
  msg::Task task;
  task.name = name;
  if (axis < 0) return task;
  const Embedding embedding = makeUnit(axis);
  task.embedding.assign(embedding.data(), embedding.data() + embedding.size());
  return task;
}

Members listMembers(const msg::SceneGraph& graph) {
  Members members;
  for (const auto& object : graph.objects) members.insert(object.primitives);
  return members;
}

class Interface : public ::testing::Test {
 protected:
  void SetUp() override {
    writeTaskFile(path(), {"mug", "book"}, 0);
    ros::param::set("/scene_graph/object_tasks", path());
    ros::param::del("/scene_graph/place_tasks");
    ASSERT_TRUE(load(loader_, "scene_graph", "SceneGraph"));
    ASSERT_TRUE(waitUntil([&] { return primitives_.getNumSubscribers() > 0; }));
    ASSERT_TRUE(graphs_.waitForPublisher());
    ASSERT_TRUE(ros::service::waitForService("/scene_graph/explain", ros::Duration(30.0)));
  }
  std::string path() const { return (folder_.path() / "objects.yaml").string(); }

  void publishMap() {
    primitives_.publish(
        ros_interface::toMessage(makePrimitives(), Stamp::fromSeconds(15.0), "world"));
    ASSERT_TRUE(graphs_.waitFor([](const msg::SceneGraph& g) { return g.objects.size() == 2; }));
  }

  static msg::ChangeTasksResponse change(std::uint8_t action, const std::vector<msg::Task>& tasks,
                                         const std::vector<std::string>& new_names = {},
                                         std::uint8_t layer = Action::OBJECTS) {
    msg::ChangeTasks call;
    call.request.action = action;
    call.request.layer = layer;
    call.request.tasks = tasks;
    call.request.new_names = new_names;
    // Persistent: where two threads call at once, roscpp may take the end of the connection, which
    // comes right after the answer, for the end of the call.
    auto client =
        ros::NodeHandle().serviceClient<msg::ChangeTasks>("/scene_graph/change_tasks", true);
    EXPECT_TRUE(client.call(call));
    return call.response;
  }
  static msg::AskResponse ask(const std::string& words, const std::vector<float>& embedding,
                              bool with_thumbnails = false) {
    msg::Ask call;
    call.request.words = words;
    call.request.embedding = embedding;
    call.request.with_thumbnails = with_thumbnails ? 1 : 0;
    EXPECT_TRUE(ros::service::call("/scene_graph/ask", call));
    return call.response;
  }
  static msg::ExplainResponse explain(std::uint8_t what, std::uint64_t a, std::uint64_t b = 0) {
    msg::Explain call;
    call.request.what = what;
    call.request.a = a;
    call.request.b = b;
    EXPECT_TRUE(ros::service::call("/scene_graph/explain", call));
    return call.response;
  }
  /// The newest graph once it is for these tasks.
  boost::shared_ptr<const msg::SceneGraph> graphFor(const std::vector<std::string>& tasks) {
    EXPECT_TRUE(waitUntil([&] { return graphs_.messages().back()->object_tasks == tasks; }));
    return graphs_.messages().back();
  }
  /// What a run from the start with these tasks gives.
  static Members clusterAnew(const scene_graph::TaskList& tasks) {
    scene_graph::SceneGraphConfig config;
    config.object_delta = 0.001;
    config.object_top_k = 1;
    scene_graph::SceneGraphBuilder builder(config);
    builder.setObjectTasks(tasks);
    builder.addPrimitives(makePrimitives());
    Members members;
    for (const auto& object : builder.snapshot()->objects) {
      std::vector<std::uint64_t> ids;
      for (const PrimitiveId id : object.primitives) ids.push_back(id.value);
      members.insert(ids);
    }
    return members;
  }
  /// Primitives -> id of their object.
  static std::map<std::vector<std::uint64_t>, std::uint64_t> listIds(const msg::SceneGraph& graph) {
    std::map<std::vector<std::uint64_t>, std::uint64_t> ids;
    for (const auto& object : graph.objects) ids[object.primitives] = object.id;
    return ids;
  }
  static std::vector<std::string> listNames(const std::vector<msg::Task>& tasks) {
    std::vector<std::string> names;
    for (const auto& task : tasks) names.push_back(task.name);
    return names;
  }
  static void expectContains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
  }

  TemporaryFolder folder_;
  ros::Publisher primitives_ =
      ros::NodeHandle().advertise<msg::ObjectPrimitives>("object_primitives", 10);
  Recorder<msg::SceneGraph> graphs_{"scene_graph"};
  Recorder<msg::TasksInForce> tasks_{"/scene_graph/tasks"};
  nodelet::Loader loader_{false};
};

TEST_F(Interface, OtherTasksGiveWhatARunFromTheStartWithThemGives) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto response = change(Action::SET, {makeTask("plate", 2), makeTask("mug", 0)});
  EXPECT_TRUE(response.success) << response.message;
  expectContains(response.message, "object tasks: plate (1), mug (1)");
  scene_graph::TaskList tasks;
  tasks.names = {"plate", "mug"};
  tasks.embeddings.resize(2, kEmbeddingSize);
  tasks.embeddings << makeUnit(2).transpose(), makeUnit(0).transpose();
  EXPECT_EQ(listMembers(*graphFor(tasks.names)), clusterAnew(tasks));
  EXPECT_EQ(clusterAnew(tasks), (Members{{1, 2}, {4}}));
}

TEST_F(Interface, ObjectsKeepTheirIdsAndColoursWhileOtherTasksComeAndGo) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto before = listIds(*graphs_.messages().back());
  const auto added = change(Action::ADD, {makeTask("plate", 2)});
  ASSERT_TRUE(added.success) << added.message;
  const auto with_plate = listIds(*graphFor({"mug", "book", "plate"}));
  EXPECT_EQ(with_plate.size(), 3U);
  for (const auto& [primitives, id] : before) EXPECT_EQ(with_plate.at(primitives), id);
  ASSERT_TRUE(change(Action::REMOVE, {makeTask("plate")}).success);
  EXPECT_EQ(listIds(*graphFor({"mug", "book"})), before);
  ASSERT_TRUE(change(Action::REMOVE, {makeTask("mug")}).success);
  const auto back = change(Action::ADD, {makeTask("mug", 0)});
  ASSERT_TRUE(back.success) << back.message;
  EXPECT_EQ(listNames(back.in_force.object_tasks), (std::vector<std::string>{"book", "mug"}));
  EXPECT_EQ(back.in_force.object_tasks[1].id, 1U);
  EXPECT_EQ(back.in_force.object_tasks[0].id, 2U);
  EXPECT_EQ(back.in_force.object_tasks[1].color, added.in_force.object_tasks[0].color);
}

TEST_F(Interface, RenamingATaskKeepsItsIdAndItsObjects) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto before = listIds(*graphs_.messages().back());
  const auto response = change(Action::RENAME, {makeTask("mug")}, {"coffee mug"});
  ASSERT_TRUE(response.success) << response.message;
  EXPECT_EQ(response.in_force.object_tasks[0].id, 1U);
  EXPECT_EQ(response.in_force.object_tasks[0].count, 1U);
  EXPECT_EQ(listIds(*graphFor({"coffee mug", "book"})), before);
}

TEST_F(Interface, PlaceTasksFollowUntilTheyHaveTheirOwn) {
  ASSERT_TRUE(change(Action::ADD, {makeTask("plate", 2)}).success);
  EXPECT_EQ(graphFor({"mug", "book", "plate"})->place_tasks.size(), 3U);
  const auto own = change(Action::SET, {makeTask("kitchen", 3)}, {}, Action::PLACES);
  ASSERT_TRUE(own.success) << own.message;
  EXPECT_FALSE(own.in_force.places_follow_objects);
  const auto after = change(Action::REMOVE, {makeTask("plate")});
  EXPECT_EQ(listNames(after.in_force.place_tasks), (std::vector<std::string>{"kitchen"}));
}

TEST_F(Interface, WhatIsWrongChangesNothing) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto before = listIds(*graphs_.messages().back());
  const auto expectRefused = [&](const msg::ChangeTasksResponse& response,
                                 const std::string& part) {
    EXPECT_FALSE(response.success);
    expectContains(response.message, part);
    EXPECT_EQ(listNames(response.in_force.object_tasks), (std::vector<std::string>{"mug", "book"}));
  };
  msg::Task wide = makeTask("cup", 0);
  wide.embedding.push_back(1.0F);
  msg::Task broken = makeTask("cup", 0);
  broken.embedding[1] = std::nanf("");
  expectRefused(change(Action::ADD, {makeTask("cup", 0), makeTask("mug", 1)}), "'mug' is in force");
  expectRefused(change(Action::ADD, {wide}), "5 numbers");
  expectRefused(change(Action::SET, {wide}), "5 values");
  expectRefused(change(Action::ADD, {broken}), "NaN");
  expectRefused(change(Action::ADD, {makeTask("cup")}), "words need a text encoder");
  expectRefused(change(Action::ADD, {makeTask("c\xff", 0)}), "not valid UTF-8");
  expectRefused(change(Action::ADD, {makeTask(std::string(10240, 'a'), 0)}), "10240 bytes");
  expectRefused(change(Action::SET, {makeTask("cup", 0), makeTask("cup", 1)}), "is there twice");
  expectRefused(change(Action::REMOVE, {makeTask("pen")}), "no task 'pen'");
  expectRefused(change(Action::ADD, {}), "no task is named");
  expectRefused(change(9, {makeTask("cup", 0)}), "action 9");
  expectRefused(change(Action::ADD, {makeTask("cup", 0)}, {}, 9), "layer 9");
  EXPECT_EQ(listIds(*graphs_.messages().back()), before);
}

TEST_F(Interface, TwoClientsAtOnceLoseNoChange) {
  const auto add = [](const std::string& prefix) {
    bool all = true;
    for (int i = 0; i < 20; ++i) {
      all = change(Action::ADD, {makeTask(prefix + std::to_string(i), i % 4)}).success && all;
    }
    return all;
  };
  auto first = std::async(std::launch::async, add, "a");
  auto second = std::async(std::launch::async, add, "b");
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(second.get());
  EXPECT_EQ(change(Action::REMOVE, {makeTask("mug")}).in_force.object_tasks.size(), 41U);
}

TEST_F(Interface, ReloadedTasksAreThoseOfTheFile) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  writeTaskFile(path(), {"plate"}, 2);
  std_srvs::Trigger reload;
  ASSERT_TRUE(ros::service::call("/scene_graph/reload_tasks", reload));
  EXPECT_TRUE(reload.response.success) << reload.response.message;
  EXPECT_EQ(listMembers(*graphFor({"plate"})), (Members{{4}}));
  std::ofstream(path()) << "tasks: {";
  ASSERT_TRUE(ros::service::call("/scene_graph/reload_tasks", reload));
  EXPECT_FALSE(reload.response.success);
  expectContains(reload.response.message, path());
  EXPECT_EQ(graphs_.messages().back()->object_tasks, (std::vector<std::string>{"plate"}));
}

TEST_F(Interface, ALateSubscriberLearnsTheTasksInForce) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  Recorder<msg::TasksInForce> late("/scene_graph/tasks");
  ASSERT_TRUE(late.waitFor([](const msg::TasksInForce& tasks) {
    return tasks.object_tasks.size() == 2 && tasks.object_tasks[0].count == 1;
  }));
  EXPECT_FALSE(late.messages().back()->can_encode);
}

TEST_F(Interface, QuestionsFindAlsoWhatServesNoTask) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto spoon = ask("", makeTask("", 3).embedding, true);
  ASSERT_TRUE(spoon.success) << spoon.message;
  EXPECT_TRUE(spoon.is_found);
  ASSERT_FALSE(spoon.primitives.empty());
  EXPECT_EQ(spoon.primitives[0].id, 5U);
  EXPECT_EQ(spoon.primitives[0].object, 0U);
  EXPECT_FLOAT_EQ(static_cast<float>(spoon.primitives[0].pose.position.x), 20.5F);
  EXPECT_EQ(spoon.primitives[0].thumbnail.width, 6U);
  expectContains(spoon.message, "primitive 5 at (20.50, 0.50, 0.50) m, score 1.000");
  const auto mug = ask("", makeTask("", 0).embedding);
  ASSERT_FALSE(mug.objects.empty());
  EXPECT_EQ(mug.objects[0].task, "mug");
  EXPECT_TRUE(mug.objects[0].thumbnail.data.empty());
}

TEST_F(Interface, TheScoresOfTheLastQuestionAreShownAlsoToWhoComesLater) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto isBest = [](int primitive, const visualization_msgs::MarkerArray& array) {
    return std::any_of(array.markers.begin(), array.markers.end(), [&](const auto& marker) {
      return marker.ns == "question_primitives" && marker.id == primitive &&
             marker.color.r == 1.0F && marker.color.b == 0.0F;
    });
  };
  const auto awaitBest = [&](int primitive, const Recorder<visualization_msgs::MarkerArray>& got) {
    return waitUntil([&] {
      const auto all = got.messages();
      return !all.empty() && isBest(primitive, *all.back());
    });
  };
  ASSERT_TRUE(ask("", makeTask("", 2).embedding).success);  // the plate: nobody looks
  ASSERT_TRUE(ask("", makeTask("", 3).embedding).success);
  {
    const Recorder<visualization_msgs::MarkerArray> late("/scene_graph/question_markers");
    EXPECT_TRUE(awaitBest(5, late));  // the spoon
    ASSERT_TRUE(ask("", makeTask("", 2).embedding).success);
    EXPECT_TRUE(awaitBest(4, late));
  }
  const Recorder<visualization_msgs::MarkerArray> later("/scene_graph/question_markers");
  EXPECT_TRUE(awaitBest(4, later));
}

TEST_F(Interface, QuestionsThatAreNoneAreRefused) {
  EXPECT_FALSE(ask("", {}).success);
  ASSERT_NO_FATAL_FAILURE(publishMap());
  expectContains(ask("", {}).message, "has 0 of words, an embedding and an image");
  expectContains(ask("mug", {1, 0, 0, 0}).message, "expected one of them");
  expectContains(ask("mug", {}).message, "words need a text encoder");
  expectContains(ask("", {1, 0}).message, "2 numbers, expected 4");
  expectContains(ask("", {0, 0, 0, 0}).message, "without a direction");
}

TEST_F(Interface, AnObjectIsGivenAsPointsForPcl) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto ids = listIds(*graphs_.messages().back());
  const auto get = [](std::uint8_t what, std::uint64_t id) {
    msg::GetObject call;
    call.request.what = what;
    call.request.id = id;
    EXPECT_TRUE(ros::service::call("/scene_graph/get_object", call));
    return call.response;
  };
  const auto mug = get(msg::GetObject::Request::OBJECT, ids.at({1, 2}));
  ASSERT_TRUE(mug.success) << mug.message;
  EXPECT_EQ(mug.task, "mug");
  EXPECT_EQ(mug.primitives, (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(mug.points.width, 6U);
  EXPECT_EQ(mug.points.header.frame_id, "world");
  EXPECT_EQ(mug.thumbnail.width, 6U);
  EXPECT_DOUBLE_EQ(mug.box.size.x, 1.5);
  const auto spoon = get(msg::GetObject::Request::PRIMITIVE, 5);
  ASSERT_TRUE(spoon.success) << spoon.message;
  EXPECT_EQ(spoon.points.width, 3U);
  EXPECT_FALSE(get(msg::GetObject::Request::OBJECT, 99).success);
  expectContains(get(msg::GetObject::Request::PRIMITIVE, 99).message, "no primitive 99");
}

TEST_F(Interface, TheMeshOfAStageAloneIsRefusedWithTheReason) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  msg::GetMesh call;
  ASSERT_TRUE(ros::service::call("/scene_graph/get_mesh", call));
  EXPECT_FALSE(call.response.success);
  expectContains(call.response.message, "mesh_fusion has the mesh: none of the stages");
}

TEST_F(Interface, ObjectsOfChosenTasksHaveFrames) {
  Recorder<tf2_msgs::TFMessage> frames("/tf");
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto ids = listIds(*graphs_.messages().back());
  const std::string mug = "object_" + std::to_string(ids.at({1, 2}));
  ASSERT_TRUE(frames.waitFor([&](const tf2_msgs::TFMessage& message) {
    return message.transforms.size() == 1 && message.transforms[0].child_frame_id == mug &&
           message.transforms[0].header.frame_id == "world" &&
           std::abs(message.transforms[0].transform.translation.x - 0.75) < 1e-9;
  }));
}

TEST_F(Interface, ReasonsAreGivenInWords) {
  ASSERT_NO_FATAL_FAILURE(publishMap());
  const auto ids = listIds(*graphs_.messages().back());
  const auto object = explain(msg::ExplainRequest::OBJECT, ids.at({1, 2}));
  EXPECT_TRUE(object.success);
  expectContains(object.message, "serves 'mug': 2 primitives in 1 merge");
  expectContains(explain(msg::ExplainRequest::PRIMITIVES, 2, 3).message, "are apart");
  expectContains(explain(msg::ExplainRequest::PRIMITIVE, 4).message, "it serves no task");
  const auto unknown = explain(msg::ExplainRequest::OBJECT, 99);
  EXPECT_FALSE(unknown.success);
  expectContains(unknown.message, "no object 99 is in the map");
  EXPECT_FALSE(explain(9, 1).success);
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "interface_test"); }
