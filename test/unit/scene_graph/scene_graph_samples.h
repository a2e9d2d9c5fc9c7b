// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tsg::scene_graph {

/// How a sample graph is written.
enum class FileForm {
  kClio,     ///< 1.0.0: no header, boxes by world corners, flat meshes relative to the lower corner
  kCurrent,  ///< 1.1: boxes by centre and size, nested meshes relative to the centre
};

inline std::uint64_t makeId(char letter, std::uint64_t index) {
  return (static_cast<std::uint64_t>(letter) << 56) | index;
}

/// A segment whose box is [corner, corner + 1], with a triangle in that box's lower corner.
inline nlohmann::json makeSegmentAttributes(FileForm form, const std::vector<double>& corner,
                                            const std::vector<double>& feature) {
  using nlohmann::json;
  const std::vector<double> center = {corner[0] + 0.5, corner[1] + 0.5, corner[2] + 0.5};
  const json identity = {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
  json attributes = {
      {"type", "KhronosObjectAttributes"},
      {"position", center},
      {"name", ""},
      {"semantic_label", 4294967295U},
      {"semantic_feature", {{"rows", feature.size()}, {"cols", 1}, {"data", feature}}},
      {"mesh_connections", json::array()},
      {"first_observed_ns", {3}},
      {"last_observed_ns", {9}},
      {"last_update_time_ns", 7}};
  if (form == FileForm::kClio) {
    const std::vector<double> end = {corner[0] + 1, corner[1] + 1, corner[2] + 1};
    attributes["bounding_box"] = {{"type", "AABB"},
                                  {"min", corner},
                                  {"max", end},
                                  {"world_P_center", {0.0, 0.0, 0.0}},
                                  {"world_R_center", identity}};
    attributes["vertices"] = {0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.25, 0.0};
    attributes["colors"] = {1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255};
    attributes["faces"] = {0, 1, 2};
    return attributes;
  }
  attributes["bounding_box"] = {{"type", "AABB"},
                                {"dimensions", {1.0, 1.0, 1.0}},
                                {"world_P_center", center},
                                {"world_R_center", identity}};
  const json color = {{"r", 1}, {"g", 2}, {"b", 3}, {"a", 255}};
  attributes["mesh"] = {
      {"header",
       {{"project_name", "main"}, {"version", {{"major", 1}, {"minor", 1}, {"patch", 3}}}}},
      {"has_colors", true},
      {"has_timestamps", false},
      {"has_labels", false},
      {"has_first_seen_stamps", false},
      {"points", {{-0.5, -0.5, -0.5}, {0.0, -0.5, -0.5}, {-0.5, -0.25, -0.5}}},
      {"colors", {color, color, color}},
      {"faces", {{0, 1, 2}}}};
  attributes["metadata"] = json::object();
  return attributes;
}

/// Segments in a row along x, each overlapping the next by half, and two places.
inline nlohmann::json makeSampleGraph(FileForm form, std::size_t num_segments) {
  using nlohmann::json;
  const bool is_current = form == FileForm::kCurrent;
  json graph = {{"directed", false}, {"multigraph", false}};
  graph["nodes"] = json::array();
  graph["edges"] = json::array();
  const auto addNode = [&](std::uint64_t id, int layer, const json& attributes) {
    json node = {{"id", id}, {"layer", layer}, {"attributes", attributes}};
    if (is_current) node["partition"] = 0;
    graph["nodes"].push_back(node);
  };
  for (std::size_t i = 0; i < num_segments; ++i) {
    const auto x = 0.5 * static_cast<double>(i) + 10.0;
    addNode(makeId('s', i), 1, makeSegmentAttributes(form, {x, 2.0, 3.0}, {1.0, 0.25, 0.0}));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const json place = {{"type", "PlaceNodeAttributes"},
                        {"position", {20.0 * static_cast<double>(i), 0.0, 0.0}}};
    addNode(makeId('p', i), 3, place);
  }
  json info = {{"type", "EdgeAttributes"}, {"weight", 1.0}, {"weighted", false}};
  if (is_current) info["metadata"] = json::object();
  graph["edges"].push_back(
      {{"source", makeId('p', 0)}, {"target", makeId('p', 1)}, {"info", info}});
  if (!is_current) {
    graph["layer_ids"] = {1, 2, 3, 4, 5};
    return graph;
  }
  graph["SPARK_DSG_header"] = {{"project_name", "main"},
                               {"version", {{"major", 1}, {"minor", 1}, {"patch", 3}}}};
  graph["layer_keys"] = json::array();
  graph["layer_names"] = json::object();
  const char* const names[] = {"SEGMENTS", "OBJECTS", "PLACES", "ROOMS"};
  for (int layer = 1; layer <= 4; ++layer) {
    graph["layer_keys"].push_back({{"layer", layer}, {"partition", 0}});
    graph["layer_names"][names[layer - 1]] = {{"layer", layer}, {"partition", 0}};
  }
  return graph;
}

}  // namespace tsg::scene_graph
