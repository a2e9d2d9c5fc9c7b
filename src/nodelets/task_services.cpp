// SPDX-License-Identifier: BSD-3-Clause
#include "task_services.h"

#include <ros/console.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/scene_graph_markers.h"
#include "task_scene_graph/ros/task_loader.h"

namespace tsg::nodelets {
namespace {

using scene_graph::SceneGraphBuilder;
using scene_graph::TaskChange;
using scene_graph::TaskList;

TaskChange::Action toAction(std::uint8_t action) {
  switch (action) {
    case msg::ChangeTasksRequest::SET:
      return TaskChange::Action::kSet;
    case msg::ChangeTasksRequest::ADD:
      return TaskChange::Action::kAdd;
    case msg::ChangeTasksRequest::REMOVE:
      return TaskChange::Action::kRemove;
    case msg::ChangeTasksRequest::RENAME:
      return TaskChange::Action::kRename;
    default:
      throw std::invalid_argument("action " + std::to_string(action) +
                                  ", expected SET (0), ADD (1), REMOVE (2) or RENAME (3)");
  }
}

bool isForPlaces(std::uint8_t layer) {
  if (layer <= msg::ChangeTasksRequest::PLACES) return layer == msg::ChangeTasksRequest::PLACES;
  throw std::invalid_argument("layer " + std::to_string(layer) +
                              ", expected OBJECTS (0) or PLACES (1)");
}

/// How many of `items` serve each task.
template <typename Items>
std::vector<msg::Task> describeTasks(const std::vector<std::string>& names, const Items& items,
                                     ros_interface::TaskNumbers& numbers) {
  std::vector<msg::Task> tasks;
  for (std::size_t i = 0; i < names.size(); ++i) {
    msg::Task task;
    task.id = numbers.find(names[i]);
    task.name = names[i];
    task.color = ros_interface::computeColor(static_cast<int>(task.id) - 1, 1.0F);
    task.count =
        static_cast<std::uint32_t>(std::count_if(items.begin(), items.end(), [&](const auto& item) {
          return item.task_index == static_cast<int>(i);
        }));
    tasks.push_back(std::move(task));
  }
  return tasks;
}

/// Both lists, or, if the second does not fit, neither.
void setTasks(SceneGraphBuilder& builder, const TaskList& objects, const TaskList& places) {
  const TaskList before = builder.objectTasks();
  builder.setObjectTasks(objects);
  try {
    builder.setPlaceTasks(places);
  } catch (...) {
    builder.setObjectTasks(before);
    throw;
  }
}

std::string listTasks(const std::vector<msg::Task>& tasks) {
  std::string text;
  for (const auto& task : tasks) {
    text += (text.empty() ? "" : ", ") + task.name + " (" + std::to_string(task.count) + ")";
  }
  return text.empty() ? "none" : text;
}

}  // namespace

TaskServices::TaskServices(ros::NodeHandle& services, GraphAccess access,
                           std::shared_ptr<language::WordEncoder> encoder, const Files& files)
    : access_(std::move(access)),
      encoder_(std::move(encoder)),
      files_(files),
      places_follow_objects_(files.places.empty()),
      publisher_(services, "tasks") {
  servers_.push_back(services.advertiseService("change_tasks", &TaskServices::serveChange, this));
  servers_.push_back(services.advertiseService("reload_tasks", &TaskServices::serveReload, this));
}

msg::TasksInForce TaskServices::describe(const scene_graph::SceneGraph& graph) {
  msg::TasksInForce message;
  message.object_tasks = describeTasks(graph.object_tasks, graph.objects, numbers_);
  message.place_tasks = describeTasks(graph.place_tasks, graph.regions, numbers_);
  message.places_follow_objects = places_follow_objects_ ? 1 : 0;
  message.can_encode = encoder_->canEncode() ? 1 : 0;
  message.model_set = encoder_->modelSetName();
  message.header.frame_id = graph.world_frame;
  return message;
}

void TaskServices::publish(const scene_graph::SceneGraph& graph) {
  // Without a file they are a saved map's: both lists as that has them.
  const bool are_of_a_map = files_.objects.empty() && std::exchange(is_first_, false);
  if (are_of_a_map) places_follow_objects_ = graph.place_tasks == graph.object_tasks;
  msg::TasksInForce message = describe(graph);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    message.header.stamp = in_force_.header.stamp;  // only what is said counts
    message.header.seq = in_force_.header.seq;
    const bool is_same = has_published_ && message == in_force_;
    message.header.stamp = ros_interface::toRosTime(graph.stamp);
    in_force_ = message;
    has_published_ = true;
    if (is_same) return;
  }
  publisher_.publish(message);
}

msg::TasksInForce TaskServices::inForce() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return in_force_;
}

EmbeddingMatrix TaskServices::readEmbeddings(const std::vector<msg::Task>& tasks) {
  std::vector<std::string> names;
  for (const auto& task : tasks) {
    if (task.embedding.empty()) names.push_back(task.name);
  }
  EmbeddingMatrix encoded;
  if (!names.empty()) encoded = encoder_->encode(names);
  const Eigen::Index size =
      names.empty() ? static_cast<Eigen::Index>(tasks.front().embedding.size()) : encoded.cols();
  EmbeddingMatrix all(static_cast<Eigen::Index>(tasks.size()), size);
  Eigen::Index next = 0;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const auto& given = tasks[i].embedding;
    if (given.empty()) {
      all.row(row) = encoded.row(next++);
    } else if (static_cast<Eigen::Index>(given.size()) == size) {
      all.row(row) = Eigen::Map<const Eigen::RowVectorXf>(given.data(), size);
    } else {
      throw std::invalid_argument("task '" + tasks[i].name + "' has an embedding of " +
                                  std::to_string(given.size()) + " numbers, expected " +
                                  std::to_string(size) + " as the others have");
    }
  }
  return all;
}

TaskChange TaskServices::readChange(const msg::ChangeTasksRequest& request) {
  TaskChange change;
  change.action = toAction(request.action);
  for (const auto& task : request.tasks) change.tasks.names.push_back(task.name);
  change.new_names = request.new_names;
  change.tasks.validate("change of the tasks");
  const bool has_embeddings =
      change.action == TaskChange::Action::kSet || change.action == TaskChange::Action::kAdd;
  if (has_embeddings && !request.tasks.empty()) {
    change.tasks.embeddings = readEmbeddings(request.tasks);
  }
  return change;
}

void TaskServices::change(const TaskChange& change, bool is_for_places) {
  access_.run([&](SceneGraphBuilder& builder) {
    const TaskList after =
        applyChange(is_for_places ? builder.placeTasks() : builder.objectTasks(), change);
    const bool follows = places_follow_objects_ && !is_for_places;
    setTasks(builder, is_for_places ? builder.objectTasks() : after,
             is_for_places || follows ? after : builder.placeTasks());
    if (is_for_places) places_follow_objects_ = false;
    if (change.action != TaskChange::Action::kRename) return;
    for (std::size_t i = 0; i < change.tasks.size(); ++i) {
      numbers_.rename(change.tasks.names[i], change.new_names[i]);
    }
  });
}

bool TaskServices::serveChange(msg::ChangeTasksRequest& request,
                               msg::ChangeTasksResponse& response) {
  try {
    const bool is_for_places = isForPlaces(request.layer);
    change(readChange(request), is_for_places);
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("tasks not changed: ") + e.what();
    ROS_WARN_STREAM("[change_tasks] " << response.message);
  }
  response.in_force = inForce();
  if (response.success != 0) {
    response.message = "object tasks: " + listTasks(response.in_force.object_tasks) +
                       "; place tasks: " + listTasks(response.in_force.place_tasks);
    ROS_INFO_STREAM("[change_tasks] " << response.message);
  }
  return true;
}

bool TaskServices::serveReload(std_srvs::TriggerRequest&, std_srvs::TriggerResponse& response) {
  try {
    const auto tasks =
        ros_interface::loadChainTasks(files_.objects.string(), files_.places.string(), *encoder_);
    access_.run([&](SceneGraphBuilder& builder) {
      setTasks(builder, tasks.objects, tasks.places);
      places_follow_objects_ = files_.places.empty();
    });
    const msg::TasksInForce in_force = inForce();
    response.message = "object tasks: " + listTasks(in_force.object_tasks) +
                       "; place tasks: " + listTasks(in_force.place_tasks);
    for (const auto& warning : tasks.warnings) response.message += "\n" + warning;
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("tasks not changed: ") + e.what();
    ROS_WARN_STREAM("[reload_tasks] " << response.message);
  }
  return true;
}

}  // namespace tsg::nodelets
