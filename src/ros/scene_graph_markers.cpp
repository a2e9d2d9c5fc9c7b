// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/scene_graph_markers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "task_scene_graph/ros/geometry_conversions.h"

namespace tsg::ros_interface {
namespace {

using visualization_msgs::Marker;

/// A rectangle of a polygon's inside.
struct Strip {
  double x0_m = 0.0;
  double x1_m = 0.0;
  double y0_m = 0.0;
  double y1_m = 0.0;
};

constexpr double kStrip_m = 0.1;

/// x where a horizontal line crosses the polygon, ascending.
std::vector<double> findCrossings(const std::vector<Eigen::Vector2d>& polygon_m, double y_m) {
  std::vector<double> crossings_m;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector2d& a = polygon_m[i];
    const Eigen::Vector2d& b = polygon_m[(i + 1) % polygon_m.size()];
    if ((a.y() <= y_m) == (b.y() <= y_m)) continue;
    crossings_m.push_back(a.x() + (b.x() - a.x()) * (y_m - a.y()) / (b.y() - a.y()));
  }
  std::sort(crossings_m.begin(), crossings_m.end());
  return crossings_m;
}

/// The inside of a polygon as rectangles of one height.
std::vector<Strip> cutIntoStrips(const std::vector<Eigen::Vector2d>& polygon_m) {
  if (polygon_m.size() < 3) return {};
  const auto isLower = [](const auto& a, const auto& b) { return a.y() < b.y(); };
  const auto [low, high] = std::minmax_element(polygon_m.begin(), polygon_m.end(), isLower);
  std::vector<Strip> strips;
  const int count = static_cast<int>(std::ceil((high->y() - low->y()) / kStrip_m));
  for (int i = 0; i < count; ++i) {
    const double y_m = low->y() + kStrip_m * i;
    const auto crossings_m = findCrossings(polygon_m, y_m + 0.5 * kStrip_m);
    for (std::size_t k = 0; k + 1 < crossings_m.size(); k += 2) {
      strips.push_back({crossings_m[k], crossings_m[k + 1], y_m, y_m + kStrip_m});
    }
  }
  return strips;
}

/// Draws one graph into one array.
class Painter {
 public:
  Painter(const scene_graph::SceneGraph& graph, const MarkerConfig& config, std::string frame,
          TaskNumbers& numbers)
      : graph_(graph), config_(config), frame_(std::move(frame)) {
    for (const auto& task : graph_.object_tasks) {
      color_of_task_.push_back(static_cast<int>(numbers.find(task)) - 1);
    }
    for (const auto& place : graph_.places->places) place_positions_[place.id] = liftPlace(place);
    for (const auto& region : graph_.regions) {
      region_positions_[region.id] = liftRegion(region);
      for (const auto id : region.places) region_of_place_[id] = region.id;
    }
  }

  visualization_msgs::MarkerArray paint() {
    for (const auto& object : graph_.objects) paintObject(object);
    paintObjectEdges();
    paintPlaces();
    for (const auto& region : graph_.regions) paintRegion(region);
    paintRegionEdges();
    return std::move(array_);
  }

 private:
  Eigen::Vector3d liftObject(const scene_graph::SceneObject& object) const {
    return object.box.center() + Eigen::Vector3d(0.0, 0.0, config_.object_lift_m);
  }
  Eigen::Vector3d liftPlace(const Place& place) const {
    return place.position_m + Eigen::Vector3d(0.0, 0.0, config_.place_lift_m);
  }
  Eigen::Vector3d liftRegion(const scene_graph::Region& region) const {
    return region.position_m + Eigen::Vector3d(0.0, 0.0, config_.region_lift_m);
  }
  int colorOf(const scene_graph::SceneObject& object) const {
    const auto task = static_cast<std::size_t>(object.task_index);
    return task < color_of_task_.size() ? color_of_task_[task] : -1;
  }
  static int colorOf(const scene_graph::Region& region) {
    return static_cast<int>(region.id.value - 1);
  }

  Marker& add(const std::string& ns, std::uint64_t id, int type, double scale_m,
              const std_msgs::ColorRGBA& color) {
    Marker marker;
    marker.header.frame_id = frame_;
    marker.ns = ns;
    marker.id = static_cast<int>(id);
    marker.type = type;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1.0;
    marker.scale.x = marker.scale.y = marker.scale.z = scale_m;
    marker.color = color;
    array_.markers.push_back(std::move(marker));
    return array_.markers.back();
  }

  void addText(const std::string& ns, std::uint64_t id, const Eigen::Vector3d& position_m,
               const std::string& text, double scale) {
    std_msgs::ColorRGBA black;
    black.a = 1.0F;
    Marker& label = add(ns, id, Marker::TEXT_VIEW_FACING, config_.text_height_m * scale, black);
    label.pose.position = toPoint(position_m);
    label.text = text;
  }

  static void addLine(Marker& lines, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    lines.points.push_back(toPoint(a));
    lines.points.push_back(toPoint(b));
  }

  void paintObject(const scene_graph::SceneObject& object) {
    const Eigen::Vector3d node = liftObject(object);
    Marker& box = add("object_boxes", object.id.value, Marker::CUBE, 1.0,
                      computeColor(colorOf(object), 0.15F));
    box.pose.position = toPoint(object.box.center());
    const Eigen::Vector3d size = object.box.sizes().cwiseMax(0.01);
    box.scale.x = size.x();
    box.scale.y = size.y();
    box.scale.z = size.z();
    paintFrame(object);
    add("object_nodes", object.id.value, Marker::CUBE, 0.12, computeColor(colorOf(object), 1.0F))
        .pose.position = toPoint(node);
    addText("object_labels", object.id.value, node + Eigen::Vector3d(0.0, 0.0, 0.2), object.task,
            1.0);
  }

  /// The twelve edges of the object's box.
  void paintFrame(const scene_graph::SceneObject& object) {
    Marker& lines = add("object_frames", object.id.value, Marker::LINE_LIST, 0.015,
                        computeColor(colorOf(object), 1.0F));
    for (int corner = 0; corner < 8; ++corner) {
      for (int bit = 1; bit < 8; bit *= 2) {
        if ((corner & bit) != 0) continue;
        addLine(lines, object.box.corner(static_cast<Aabb::CornerType>(corner)),
                object.box.corner(static_cast<Aabb::CornerType>(corner | bit)));
      }
    }
  }

  void paintObjectEdges() {
    Marker& to_box = add("object_edges", 0, Marker::LINE_LIST, 0.01, computeColor(-1, 0.6F));
    for (const auto& object : graph_.objects) {
      addLine(to_box, object.box.center(), liftObject(object));
    }
    Marker& to_place =
        add("object_place_edges", 0, Marker::LINE_LIST, 0.015, computeColor(-1, 0.6F));
    for (const auto& object : graph_.objects) {
      const auto place = place_positions_.find(object.place);
      if (place != place_positions_.end()) addLine(to_place, liftObject(object), place->second);
    }
    dropIfEmpty();
  }

  void paintPlaces() {
    Marker& spheres = add("places", 0, Marker::SPHERE_LIST, 0.15, computeColor(-1, 1.0F));
    for (const auto& place : graph_.places->places) {
      spheres.points.push_back(toPoint(place_positions_.at(place.id)));
      const auto region = region_of_place_.find(place.id);
      const int color =
          region == region_of_place_.end() ? -1 : static_cast<int>(region->second.value - 1);
      spheres.colors.push_back(computeColor(color, 1.0F));
    }
    Marker& lines = add("place_edges", 0, Marker::LINE_LIST, 0.02, computeColor(-1, 0.9F));
    for (const auto& edge : graph_.places->edges) {
      addLine(lines, place_positions_.at(edge.a), place_positions_.at(edge.b));
    }
    dropIfEmpty();
  }

  void paintRegion(const scene_graph::Region& region) {
    const Eigen::Vector3d node = liftRegion(region);
    paintFootprint(region);
    add("regions", region.id.value, Marker::CUBE, 0.35, computeColor(colorOf(region), 1.0F))
        .pose.position = toPoint(node);
    addText("region_labels", region.id.value, node + Eigen::Vector3d(0.0, 0.0, 0.45),
            region.task.empty() ? "region " + std::to_string(region.id.value) : region.task, 1.4);
    Marker& lines = add("region_place_edges", region.id.value, Marker::LINE_LIST, 0.01,
                        computeColor(colorOf(region), 0.5F));
    for (const auto id : region.places) {
      const auto place = place_positions_.find(id);
      if (place != place_positions_.end()) addLine(lines, node, place->second);
    }
    dropIfEmpty();
  }

  /// Its floor, filled, with its outline, at the height of its places.
  void paintFootprint(const scene_graph::Region& region) {
    const double z_m = region.position_m.z();
    Marker& floor = add("region_floors", region.id.value, Marker::TRIANGLE_LIST, 1.0,
                        computeColor(colorOf(region), 0.35F));
    for (const Strip& strip : cutIntoStrips(region.footprint_m)) addStrip(floor, strip, z_m);
    Marker& outline = add("region_outlines", region.id.value, Marker::LINE_LIST, 0.05,
                          computeColor(colorOf(region), 1.0F));
    const auto& corners = region.footprint_m;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d& next = corners[(i + 1) % corners.size()];
      addLine(outline, {corners[i].x(), corners[i].y(), z_m}, {next.x(), next.y(), z_m});
    }
    dropIfEmpty();
  }

  static void addStrip(Marker& floor, const Strip& strip, double z_m) {
    const auto addCorner = [&](double x, double y) {
      floor.points.push_back(toPoint(Eigen::Vector3d(x, y, z_m)));
    };
    for (const bool is_upper : {false, true}) {
      addCorner(strip.x0_m, is_upper ? strip.y1_m : strip.y0_m);
      addCorner(strip.x1_m, is_upper ? strip.y1_m : strip.y0_m);
      addCorner(is_upper ? strip.x0_m : strip.x1_m, is_upper ? strip.y0_m : strip.y1_m);
    }
  }

  void paintRegionEdges() {
    Marker& lines = add("region_edges", 0, Marker::LINE_LIST, 0.05, computeColor(-1, 1.0F));
    for (const auto& edge : graph_.region_edges) {
      addLine(lines, region_positions_.at(edge.a), region_positions_.at(edge.b));
    }
    dropIfEmpty();
  }

  /// rviz warns of lists without points.
  void dropIfEmpty() {
    const auto is_empty = [](const Marker& marker) {
      return (marker.type == Marker::LINE_LIST || marker.type == Marker::SPHERE_LIST ||
              marker.type == Marker::TRIANGLE_LIST) &&
             marker.points.empty();
    };
    auto& markers = array_.markers;
    markers.erase(std::remove_if(markers.begin(), markers.end(), is_empty), markers.end());
  }

  const scene_graph::SceneGraph& graph_;
  const MarkerConfig& config_;
  const std::string frame_;
  std::vector<int> color_of_task_;
  std::map<PlaceId, Eigen::Vector3d> place_positions_;
  std::map<RegionId, Eigen::Vector3d> region_positions_;
  std::map<PlaceId, RegionId> region_of_place_;
  visualization_msgs::MarkerArray array_;
};

}  // namespace

std_msgs::ColorRGBA computeColor(int index, float alpha) {
  std_msgs::ColorRGBA color;
  color.a = alpha;
  color.r = color.g = color.b = 0.45F;
  if (index < 0) return color;
  const double hue = std::fmod(index * 0.61803398875, 1.0) * 6.0;  // golden ratio: spread evenly
  const float value = index % 2 == 0 ? 0.95F : 0.7F;
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double part = std::max(0.0, std::min({k, 4.0 - k, 1.0}));
    return value * (1.0F - 0.85F * static_cast<float>(part));
  };
  color.r = channel(5.0);
  color.g = channel(3.0);
  color.b = channel(1.0);
  return color;
}

visualization_msgs::MarkerArray SceneGraphMarkers::update(const scene_graph::SceneGraph& graph,
                                                          TaskNumbers& numbers) {
  visualization_msgs::MarkerArray array = Painter(graph, config_, world_frame_, numbers).paint();
  std::set<std::pair<std::string, int>> now;
  for (const auto& marker : array.markers) now.emplace(marker.ns, marker.id);
  for (const auto& [ns, id] : shown_) {
    if (now.count({ns, id}) > 0) continue;
    visualization_msgs::Marker gone;
    gone.header.frame_id = world_frame_;
    gone.ns = ns;
    gone.id = id;
    gone.action = visualization_msgs::Marker::DELETE;
    gone.pose.orientation.w = 1.0;
    array.markers.push_back(gone);
  }
  shown_ = std::move(now);
  return array;
}

}  // namespace tsg::ros_interface
