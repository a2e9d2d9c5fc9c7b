// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/scene_graph_markers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "task_scene_graph/core/find_by_id.h"
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
constexpr std::size_t kMaxRegionColors = 10000;

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

/// The inside of a polygon as rectangles of one height. Neighbours share their border to the bit,
/// or a seam would be seen.
std::vector<Strip> cutIntoStrips(const std::vector<Eigen::Vector2d>& polygon_m) {
  if (polygon_m.size() < 3) return {};
  const auto isLower = [](const auto& a, const auto& b) { return a.y() < b.y(); };
  const auto [low, high] = std::minmax_element(polygon_m.begin(), polygon_m.end(), isLower);
  std::vector<Strip> strips;
  const int count = static_cast<int>(std::ceil((high->y() - low->y()) / kStrip_m));
  for (int i = 0; i < count; ++i) {
    const auto crossings_m = findCrossings(polygon_m, low->y() + kStrip_m * (i + 0.5));
    for (std::size_t k = 0; k + 1 < crossings_m.size(); k += 2) {
      strips.push_back({crossings_m[k], crossings_m[k + 1], low->y() + kStrip_m * i,
                        low->y() + kStrip_m * (i + 1)});
    }
  }
  return strips;
}

enum Kind {
  kObject,
  kLabel,
  kObjectEdges,
  kPlaces,
  kPlaceEdges,
  kRegion,
  kRegionPlaces,
  kRegionEdges
};

/// One label for objects of one task that stand together.
struct LabelGroup {
  std::uint64_t id = 0;  ///< of its first object
  std::string task;
  std::size_t count = 0;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< mean of the boxes' centres
  double top_m = -std::numeric_limits<double>::infinity();
};

/// Objects of one task are together if a chain of them with steps of at most `distance_m` between
/// the boxes' centres joins them. By id. O(n log n + pairs of a task that are that near along x).
std::vector<LabelGroup> groupLabels(const std::vector<scene_graph::SceneObject>& objects,
                                    double distance_m) {
  std::vector<std::size_t> order(objects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto x_m = [&](std::size_t i) { return objects[i].box.center().x(); };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::make_tuple(objects[a].task_index, x_m(a), a) <
           std::make_tuple(objects[b].task_index, x_m(b), b);
  });
  std::vector<std::size_t> first(objects.size());  // of the group, or on the way there
  std::iota(first.begin(), first.end(), std::size_t{0});
  const auto findFirst = [&](std::size_t i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (std::size_t m = k + 1; m < order.size(); ++m) {
      const auto &a = objects[order[k]], &b = objects[order[m]];
      if (a.task_index != b.task_index || x_m(order[m]) - x_m(order[k]) > distance_m) break;
      if ((a.box.center() - b.box.center()).norm() > distance_m) continue;
      const auto [low, high] = std::minmax({findFirst(order[k]), findFirst(order[m])});
      first[high] = low;
    }
  }
  std::map<std::size_t, LabelGroup> groups;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    LabelGroup& group = groups[findFirst(i)];
    if (group.count++ == 0) group.id = objects[i].id.value;
    group.task = objects[i].task;
    group.center_m += objects[i].box.center();
    group.top_m = std::max(group.top_m, objects[i].box.max().z());
  }
  std::vector<LabelGroup> list;
  for (auto& [index, group] : groups) {
    group.center_m /= static_cast<double>(group.count);
    list.push_back(std::move(group));
  }
  return list;
}

/// The bytes of what something is drawn of.
class Look {
 public:
  template <typename Number>
  Look& add(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  Look& add(const Eigen::Vector3d& p_m) { return add(p_m.x()).add(p_m.y()).add(p_m.z()); }
  Look& add(const std::string& text) {
    add(text.size());
    bytes_ += text;
    return *this;
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Draws parts of one graph into one array.
class Painter {
 public:
  /// @param region_colors  of all regions of the graph
  Painter(const scene_graph::SceneGraph& graph, const MarkerConfig& config, std::string frame,
          TaskNumbers& numbers, const std::map<RegionId, int>& region_colors)
      : graph_(graph),
        config_(config),
        region_colors_(region_colors),
        frame_(std::move(frame)),
        region_of_place_(scene_graph::computeRegionOfPlaces(graph)) {
    for (const auto& task : graph_.object_tasks) {
      color_of_task_.push_back(static_cast<int>(numbers.find(task)) - 1);
    }
  }

  /// Calls `draw(kind, id, look, paint)` for each group of markers; `paint()` draws it.
  template <typename Draw>
  void visit(const Draw& draw) {
    for (const auto& object : graph_.objects) {
      draw(kObject, object.id.value, lookOf(object), [&] { paintObject(object); });
    }
    for (const LabelGroup& group : groupLabels(graph_.objects, config_.label_distance_m)) {
      draw(kLabel, group.id, lookOf(group), [&] { paintLabel(group); });
    }
    visitChunks(
        graph_.objects, [](const auto& object) { return object.id.value; },
        [&](std::uint64_t chunk, auto begin, auto end) {
          draw(kObjectEdges, chunk, lookOfObjectEdges(begin, end),
               [&] { paintObjectEdges(chunk, begin, end); });
        });
    visitPlaces(draw);
    for (const auto& region : graph_.regions) {
      draw(kRegion, region.id.value, lookOf(region), [&] { paintRegion(region); });
    }
    draw(kRegionEdges, 0, lookOfRegionEdges(), [&] { paintRegionEdges(); });
  }

  std::vector<Marker> takeMarkers() { return std::exchange(markers_, {}); }

 private:
  template <typename Draw>
  void visitPlaces(const Draw& draw) {
    const auto idOf = [](const Place& place) { return place.id.value; };
    visitChunks(graph_.places->places, idOf, [&](std::uint64_t chunk, auto begin, auto end) {
      draw(kPlaces, chunk, lookOfPlaces(begin, end), [&] { paintPlaces(chunk, begin, end); });
      draw(kRegionPlaces, chunk, lookOfRegionPlaces(begin, end),
           [&] { paintRegionPlaces(chunk, begin, end); });
    });
    const auto startOf = [](const PlaceEdge& edge) { return edge.a.value; };
    visitChunks(graph_.places->edges, startOf, [&](std::uint64_t chunk, auto begin, auto end) {
      draw(kPlaceEdges, chunk, lookOfPlaceEdges(begin, end),
           [&] { paintPlaceEdges(chunk, begin, end); });
    });
  }

  /// Calls `use(chunk, begin, end)` for each run of items whose ids, ascending, are in one chunk.
  template <typename List, typename IdOf, typename Use>
  static void visitChunks(const List& list, const IdOf& idOf, const Use& use) {
    const auto chunkOf = [&](const auto& item) { return idOf(item) / SceneGraphMarkers::kChunk; };
    for (auto begin = list.begin(); begin != list.end();) {
      const std::uint64_t chunk = chunkOf(*begin);
      const auto end =
          std::find_if(begin, list.end(), [&](const auto& item) { return chunkOf(item) != chunk; });
      use(chunk, begin, end);
      begin = end;
    }
  }

  using Objects = std::vector<scene_graph::SceneObject>::const_iterator;
  using Places = std::vector<Place>::const_iterator;
  using Edges = std::vector<PlaceEdge>::const_iterator;

  const Place* findPlace(PlaceId id) const {
    const auto& places = graph_.places->places;
    const auto found = findById(places, id, [](const Place& place) { return place.id; });
    return found == places.end() ? nullptr : &*found;
  }
  const scene_graph::Region* findRegion(RegionId id) const {
    const auto found = findById(graph_.regions, id, [](const auto& region) { return region.id; });
    return found == graph_.regions.end() ? nullptr : &*found;
  }
  const scene_graph::Region* findRegion(Places place) const {
    return findRegion(
        region_of_place_[static_cast<std::size_t>(place - graph_.places->places.begin())]);
  }

  std::string lookOf(const scene_graph::SceneObject& object) const {
    return Look()
        .add(Eigen::Vector3d(object.box.min()))
        .add(Eigen::Vector3d(object.box.max()))
        .add(colorOf(object))
        .take();
  }
  static std::string lookOf(const LabelGroup& group) {
    return Look().add(group.task).add(group.count).add(group.center_m).add(group.top_m).take();
  }
  std::string lookOfObjectEdges(Objects begin, Objects end) const {
    Look look;
    for (auto object = begin; object != end; ++object) {
      look.add(object->id.value).add(Eigen::Vector3d(object->box.center()));
      const Place* place = findPlace(object->place);
      if (place != nullptr) look.add(place->position_m);
    }
    return look.take();
  }
  std::string lookOfPlaces(Places begin, Places end) const {
    Look look;
    for (auto place = begin; place != end; ++place) {
      const scene_graph::Region* region = findRegion(place);
      look.add(place->position_m).add(region == nullptr ? -1 : colorOf(*region));
    }
    return look.take();
  }
  std::string lookOfRegionPlaces(Places begin, Places end) const {
    Look look;
    for (auto place = begin; place != end; ++place) {
      const scene_graph::Region* region = findRegion(place);
      look.add(place->position_m);
      if (region != nullptr) look.add(colorOf(*region)).add(region->position_m);
    }
    return look.take();
  }
  std::string lookOfPlaceEdges(Edges begin, Edges end) const {
    Look look;
    for (auto edge = begin; edge != end; ++edge) {
      look.add(findPlace(edge->a)->position_m).add(findPlace(edge->b)->position_m);
    }
    return look.take();
  }
  std::string lookOf(const scene_graph::Region& region) const {
    Look look;
    look.add(region.position_m).add(region.task).add(colorOf(region));
    for (const auto& corner_m : region.footprint_m) look.add(corner_m.x()).add(corner_m.y());
    return look.take();
  }
  std::string lookOfRegionEdges() const {
    Look look;
    for (const auto& edge : graph_.region_edges) {
      look.add(liftRegion(*findRegion(edge.a))).add(liftRegion(*findRegion(edge.b)));
    }
    return look.take();
  }

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
  int colorOf(const scene_graph::Region& region) const { return region_colors_.at(region.id); }

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
    markers_.push_back(std::move(marker));
    return markers_.back();
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
  }

  /// At the nodes, and above the boxes themselves.
  void paintLabel(const LabelGroup& group) {
    const std::string number = group.count == 1 ? "" : " (" + std::to_string(group.count) + ")";
    const Eigen::Vector3d node(0.0, 0.0, config_.object_lift_m + 0.2);
    addText("object_labels", group.id, group.center_m + node, group.task + number, 1.0);
    const Eigen::Vector3d above(group.center_m.x(), group.center_m.y(),
                                group.top_m + config_.text_height_m);
    addText("object_box_labels", group.id, above, group.task + number, 1.2);
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

  void paintObjectEdges(std::uint64_t chunk, Objects begin, Objects end) {
    Marker& to_box = add("object_edges", chunk, Marker::LINE_LIST, 0.01, computeColor(-1, 0.6F));
    for (auto object = begin; object != end; ++object) {
      addLine(to_box, object->box.center(), liftObject(*object));
    }
    Marker& to_place =
        add("object_place_edges", chunk, Marker::LINE_LIST, 0.015, computeColor(-1, 0.6F));
    for (auto object = begin; object != end; ++object) {
      const Place* place = findPlace(object->place);
      if (place != nullptr) addLine(to_place, liftObject(*object), liftPlace(*place));
    }
    dropIfEmpty();
  }

  void paintPlaces(std::uint64_t chunk, Places begin, Places end) {
    Marker& spheres = add("places", chunk, Marker::SPHERE_LIST, 0.15, computeColor(-1, 1.0F));
    for (auto place = begin; place != end; ++place) {
      spheres.points.push_back(toPoint(liftPlace(*place)));
      const scene_graph::Region* region = findRegion(place);
      spheres.colors.push_back(computeRegionColor(region == nullptr ? -1 : colorOf(*region), 1.0F));
    }
  }

  void paintPlaceEdges(std::uint64_t chunk, Edges begin, Edges end) {
    Marker& lines = add("place_edges", chunk, Marker::LINE_LIST, 0.02, computeColor(-1, 0.9F));
    for (auto edge = begin; edge != end; ++edge) {
      addLine(lines, liftPlace(*findPlace(edge->a)), liftPlace(*findPlace(edge->b)));
    }
  }

  /// From the places to the nodes of their regions.
  void paintRegionPlaces(std::uint64_t chunk, Places begin, Places end) {
    Marker& lines =
        add("region_place_edges", chunk, Marker::LINE_LIST, 0.01, computeColor(-1, 0.5F));
    for (auto place = begin; place != end; ++place) {
      const scene_graph::Region* region = findRegion(place);
      if (region == nullptr) continue;
      addLine(lines, liftRegion(*region), liftPlace(*place));
      lines.colors.insert(lines.colors.end(), 2, computeRegionColor(colorOf(*region), 0.5F));
    }
    dropIfEmpty();
  }

  void paintRegion(const scene_graph::Region& region) {
    const Eigen::Vector3d node = liftRegion(region);
    paintFootprint(region);
    add("regions", region.id.value, Marker::CUBE, 0.35, computeRegionColor(colorOf(region), 1.0F))
        .pose.position = toPoint(node);
    addText("region_labels", region.id.value, node + Eigen::Vector3d(0.0, 0.0, 0.45),
            region.task.empty() ? "region " + std::to_string(region.id.value) : region.task, 1.4);
  }

  /// Its floor, filled, with its outline, at the height of its places.
  void paintFootprint(const scene_graph::Region& region) {
    const double z_m = region.position_m.z();
    Marker& floor = add("region_floors", region.id.value, Marker::TRIANGLE_LIST, 1.0,
                        computeRegionColor(colorOf(region), 0.35F));
    for (const Strip& strip : cutIntoStrips(region.footprint_m)) addStrip(floor, strip, z_m);
    Marker& outline = add("region_outlines", region.id.value, Marker::LINE_LIST, 0.05,
                          computeRegionColor(colorOf(region), 1.0F));
    const auto& corners = region.footprint_m;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d& next = corners[(i + 1) % corners.size()];
      addLine(outline, {corners[i].x(), corners[i].y(), z_m}, {next.x(), next.y(), z_m});
    }
    dropIfEmpty();
  }

  /// Two triangles, counterclockwise seen from above: rviz lights that side.
  static void addStrip(Marker& floor, const Strip& strip, double z_m) {
    const Eigen::Vector3d corners[] = {{strip.x0_m, strip.y0_m, z_m},
                                       {strip.x1_m, strip.y0_m, z_m},
                                       {strip.x1_m, strip.y1_m, z_m},
                                       {strip.x0_m, strip.y1_m, z_m}};
    for (const int corner : {0, 1, 2, 0, 2, 3}) floor.points.push_back(toPoint(corners[corner]));
  }

  void paintRegionEdges() {
    Marker& lines = add("region_edges", 0, Marker::LINE_LIST, 0.05, computeColor(-1, 1.0F));
    for (const auto& edge : graph_.region_edges) {
      addLine(lines, liftRegion(*findRegion(edge.a)), liftRegion(*findRegion(edge.b)));
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
    markers_.erase(std::remove_if(markers_.begin(), markers_.end(), is_empty), markers_.end());
  }

  const scene_graph::SceneGraph& graph_;
  const MarkerConfig& config_;
  const std::map<RegionId, int>& region_colors_;
  const std::string frame_;
  const std::vector<RegionId> region_of_place_;
  std::vector<int> color_of_task_;
  std::vector<Marker> markers_;
};

Marker makeDeletion(const std::string& frame, const std::string& ns, int id, int action) {
  Marker gone;
  gone.header.frame_id = frame;
  gone.ns = ns;
  gone.id = id;
  gone.action = action;
  gone.pose.orientation.w = 1.0;
  return gone;
}

/// Deletes the markers of `before` that are not in `after`.
void deleteMissing(const std::vector<Marker>& before, const std::vector<Marker>& after,
                   const std::string& frame, std::vector<Marker>& changes) {
  for (const Marker& old : before) {
    const bool is_there = std::any_of(after.begin(), after.end(), [&](const Marker& marker) {
      return marker.id == old.id && marker.ns == old.ns;
    });
    if (!is_there) changes.push_back(makeDeletion(frame, old.ns, old.id, Marker::DELETE));
  }
}

}  // namespace

/// Colours of regions that went are kept, as they may come again, but not without end.
void SceneGraphMarkers::colorRegions(const scene_graph::SceneGraph& graph) {
  for (const auto& region : graph.regions) {
    if (region_colors_.count(region.id) > 0) continue;
    region_colors_[region.id] = chooseRegionColor(graph, region, region_colors_);
  }
  if (region_colors_.size() <= std::max(kMaxRegionColors, graph.regions.size())) return;
  std::map<RegionId, int> present;
  for (const auto& region : graph.regions) present[region.id] = region_colors_.at(region.id);
  region_colors_ = std::move(present);
}

void SceneGraphMarkers::setConfig(const MarkerConfig& config) {
  config_ = config;
  for (auto& [key, group] : groups_) group.update = 0;
}

visualization_msgs::MarkerArray SceneGraphMarkers::update(const scene_graph::SceneGraph& graph,
                                                          TaskNumbers& numbers) {
  visualization_msgs::MarkerArray changes;
  colorRegions(graph);
  Painter painter(graph, config_, world_frame_, numbers, region_colors_);
  ++num_updates_;
  painter.visit([&](Kind kind, std::uint64_t id, std::string look, const auto& paint) {
    Group& group = groups_[{kind, id}];
    const bool is_same = group.update > 0 && group.look == look;
    group.update = num_updates_;
    if (is_same) return;
    group.look = std::move(look);
    paint();
    std::vector<Marker> markers = painter.takeMarkers();
    changes.markers.insert(changes.markers.end(), markers.begin(), markers.end());
    deleteMissing(group.markers, markers, world_frame_, changes.markers);
    group.markers = std::move(markers);
  });
  removeGone(changes);
  return changes;
}

void SceneGraphMarkers::removeGone(visualization_msgs::MarkerArray& changes) {
  for (auto entry = groups_.begin(); entry != groups_.end();) {
    if (entry->second.update == num_updates_) {
      ++entry;
      continue;
    }
    deleteMissing(entry->second.markers, {}, world_frame_, changes.markers);
    entry = groups_.erase(entry);
  }
}

visualization_msgs::MarkerArray SceneGraphMarkers::all() const {
  visualization_msgs::MarkerArray array;
  array.markers.push_back(makeDeletion(world_frame_, "", 0, Marker::DELETEALL));
  for (const auto& [key, group] : groups_) {
    array.markers.insert(array.markers.end(), group.markers.begin(), group.markers.end());
  }
  return array;
}

}  // namespace tsg::ros_interface
