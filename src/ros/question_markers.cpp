// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/question_markers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/marker_colors.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kText_m = 0.22;
constexpr double kDot_m = 0.1;
constexpr double kAround_m = 0.02;  // so that boxes lie around those of scene_graph_markers

/// A thing with an embedding.
struct Scored {
  std::uint64_t id = 0;
  double score = 0.0;
  OrientedBox box;
};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(const std::vector<Scored>& things) {
    for (const Scored& thing : things) {
      low = std::min(low, thing.score);
      high = std::max(high, thing.score);
    }
  }
  double partOf(double score) const { return high > low ? (score - low) / (high - low) : 1.0; }
};

void sortByScore(std::vector<Scored>& things) {
  std::sort(things.begin(), things.end(), [](const Scored& a, const Scored& b) {
    return a.score > b.score || (a.score == b.score && a.id < b.id);
  });
}

std::vector<Scored> listObjects(const scene_graph::SceneGraph& graph,
                                const std::vector<double>& scores) {
  std::vector<Scored> things;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const auto& object = graph.objects[i];
    if (std::isnan(scores[i])) continue;
    things.push_back(
        {object.id.value, scores[i],
         object.oriented_box.isEmpty() ? tsg::toOrientedBox(object.box) : object.oriented_box});
  }
  return things;
}

/// Primitives that are part of no object, best first.
std::vector<Scored> listPrimitives(const scene_graph::SceneGraph& graph,
                                   const std::vector<double>& scores) {
  std::set<PrimitiveId> members;
  for (const auto& object : graph.objects) {
    members.insert(object.primitives.begin(), object.primitives.end());
  }
  std::vector<Scored> things;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const ObjectPrimitive& primitive = *graph.primitives[i];
    if (std::isnan(scores[i]) || members.count(primitive.id) > 0) continue;
    things.push_back({primitive.id.value, scores[i], primitive.oriented_box});
  }
  sortByScore(things);
  return things;
}

std::string formatScore(double score) {
  std::ostringstream text;
  text.precision(2);
  text << std::fixed << score;
  return text.str();
}

class Painter {
 public:
  Painter(std::string frame, const Range& range) : frame_(std::move(frame)), range_(range) {
    add("", 0, Marker::CUBE).action = Marker::DELETEALL;
  }

  void addBox(const char* ns, const Scored& thing) {
    Marker& marker = add(ns, static_cast<int>(thing.id), Marker::CUBE);
    const msg::BoundingBox box = toBoundingBox(thing.box);
    marker.pose = box.pose;
    marker.scale.x = box.size.x + kAround_m;
    marker.scale.y = box.size.y + kAround_m;
    marker.scale.z = box.size.z + kAround_m;
    marker.color = computeScoreColor(range_.partOf(thing.score), 0.65F);
  }

  void addDots(const std::vector<Scored>& things, std::size_t first) {
    if (first >= things.size()) return;
    Marker& dots = add("question_others", 0, Marker::SPHERE_LIST);
    dots.scale.x = dots.scale.y = dots.scale.z = kDot_m;
    dots.color.a = 1.0F;
    for (std::size_t i = first; i < things.size(); ++i) {
      dots.points.push_back(toPoint(things[i].box.center_m));
      dots.colors.push_back(computeScoreColor(range_.partOf(things[i].score), 1.0F));
    }
  }

  void addText(const char* ns, int id, const Eigen::Vector3d& p_world, double height_m,
               const std::string& text) {
    Marker& marker = add(ns, id, Marker::TEXT_VIEW_FACING);
    marker.pose.position = toPoint(p_world);
    marker.scale.z = height_m;
    marker.color.a = 1.0F;
    marker.text = text;
  }

  MarkerArray take() { return std::move(array_); }

 private:
  Marker& add(const char* ns, int id, int type) {
    Marker marker;
    marker.header.frame_id = frame_;  // stamp 0: rviz takes the newest transform
    marker.ns = ns;
    marker.id = id;
    marker.type = type;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1.0;
    array_.markers.push_back(std::move(marker));
    return array_.markers.back();
  }

  std::string frame_;
  Range range_;
  MarkerArray array_;
};

void addLabels(const std::vector<Scored>& objects, const std::vector<Scored>& primitives,
               Painter& painter) {
  std::vector<Scored> best = objects;
  best.insert(best.end(), primitives.begin(),
              primitives.begin() +
                  static_cast<std::ptrdiff_t>(std::min(primitives.size(), kNumQuestionLabels)));
  sortByScore(best);
  best.resize(std::min(best.size(), kNumQuestionLabels));
  for (std::size_t i = 0; i < best.size(); ++i) {
    const Eigen::Vector3d top(0.0, 0.0, 0.5 * best[i].box.size_m.z() + kText_m);
    painter.addText("question_labels", static_cast<int>(i), best[i].box.center_m + top, kText_m,
                    formatScore(best[i].score));
  }
}

/// In front of the map, on its floor.
void addLegend(const std::vector<Scored>& objects, const std::vector<Scored>& primitives,
               const std::string& asked, const Range& range, Painter& painter) {
  Aabb bounds;
  for (const auto* things : {&objects, &primitives}) {
    for (const Scored& thing : *things) {
      bounds.extend(Eigen::Vector3d(thing.box.center_m - 0.5 * thing.box.size_m));
      bounds.extend(Eigen::Vector3d(thing.box.center_m + 0.5 * thing.box.size_m));
    }
  }
  const Eigen::Vector3d front(bounds.center().x(), bounds.min().y() - 1.5, bounds.min().z());
  painter.addText("question_legend", 0, front, 1.5 * kText_m,
                  (asked.empty() ? std::string("last question") : "'" + asked + "'") + ": blue " +
                      formatScore(range.low) + ", red " + formatScore(range.high));
}

}  // namespace

MarkerArray makeQuestionMarkers(const scene_graph::SceneGraph& graph,
                                const scene_graph::QuestionScores& scores,
                                const std::string& asked) {
  const std::vector<Scored> objects = listObjects(graph, scores.objects);
  const std::vector<Scored> primitives = listPrimitives(graph, scores.primitives);
  Range range;
  range.add(objects);
  range.add(primitives);
  Painter painter(graph.world_frame, range);
  if (objects.empty() && primitives.empty()) return painter.take();
  for (const Scored& object : objects) painter.addBox("question_objects", object);
  const std::size_t num_boxes = std::min(primitives.size(), kMaxQuestionBoxes);
  for (std::size_t i = 0; i < num_boxes; ++i) {
    painter.addBox("question_primitives", primitives[i]);
  }
  painter.addDots(primitives, num_boxes);
  addLabels(objects, primitives, painter);
  addLegend(objects, primitives, asked, range, painter);
  return painter.take();
}

}  // namespace tsg::ros_interface
