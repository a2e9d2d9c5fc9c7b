// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/question_conversions.h"

#include <map>

#include "task_scene_graph/core/find_by_id.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"

namespace tsg::ros_interface {
namespace {

using scene_graph::Answer;

/// Looks up what answers name.
class Names {
 public:
  explicit Names(const scene_graph::SceneGraph& graph) : graph_(graph) {
    for (const auto& region : graph.regions) region_tasks_[region.id] = region.task;
  }

  std::string regionTask(RegionId id) const {
    const auto found = region_tasks_.find(id);
    return found == region_tasks_.end() ? "" : found->second;
  }

  const ObjectPrimitive* findPrimitive(PrimitiveId id) const {
    const auto found =
        findById(graph_.primitives, id, [](const auto& primitive) { return primitive->id; });
    return found != graph_.primitives.end() ? found->get() : nullptr;
  }

  /// The primitive of an object that was seen largest.
  const ObjectPrimitive* findLargest(ObjectId id) const {
    const ObjectPrimitive* largest = nullptr;
    for (const auto& object : graph_.objects) {
      if (!(object.id == id)) continue;
      for (const PrimitiveId member : object.primitives) {
        const ObjectPrimitive* primitive = findPrimitive(member);
        if (primitive == nullptr || primitive->thumbnail.image.empty()) continue;
        if (largest == nullptr || primitive->views.best_pixels > largest->views.best_pixels) {
          largest = primitive;
        }
      }
    }
    return largest;
  }

 private:
  const scene_graph::SceneGraph& graph_;
  std::map<RegionId, std::string> region_tasks_;
};

msg::Answer toMessage(const Answer& answer, const Names& names, const ObjectPrimitive* picture) {
  msg::Answer message;
  message.id = answer.id;
  message.task = answer.task;
  message.score = static_cast<float>(answer.score);
  message.margin = static_cast<float>(answer.margin);
  message.pose.orientation.w = 1.0;
  message.pose.position = toPoint(answer.position_m);
  if (!answer.box.isEmpty()) {
    const msg::BoundingBox box = toBoundingBox(answer.box);
    message.pose = box.pose;
    message.size = box.size;
  }
  message.object = answer.object.value;
  message.place = answer.place.value;
  message.region = answer.region.value;
  message.region_task = names.regionTask(answer.region);
  message.last_seen = toRosTime(answer.last_seen);
  if (picture != nullptr) message.thumbnail = toThumbnailMessage(picture->thumbnail);
  return message;
}

}  // namespace

msg::AskResponse toMessage(const scene_graph::Answers& answers,
                           const scene_graph::SceneGraph& graph, bool with_thumbnails) {
  const Names names(graph);
  msg::AskResponse message;
  for (const auto& answer : answers.objects) {
    const auto* picture = with_thumbnails ? names.findLargest({answer.id}) : nullptr;
    message.objects.push_back(toMessage(answer, names, picture));
  }
  for (const auto& answer : answers.primitives) {
    const auto* picture = with_thumbnails ? names.findPrimitive({answer.id}) : nullptr;
    message.primitives.push_back(toMessage(answer, names, picture));
  }
  for (const auto& answer : answers.places) {
    message.places.push_back(toMessage(answer, names, nullptr));
  }
  for (const auto& answer : answers.regions) {
    message.regions.push_back(toMessage(answer, names, nullptr));
  }
  message.is_found = scene_graph::isFound(answers, graph.config) ? 1 : 0;
  message.alpha = static_cast<float>(graph.config.object_alpha);
  message.place_alpha = static_cast<float>(graph.config.place_alpha);
  message.header.frame_id = graph.world_frame;
  message.header.stamp = toRosTime(graph.stamp);
  return message;
}

}  // namespace tsg::ros_interface
