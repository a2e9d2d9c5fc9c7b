// SPDX-License-Identifier: BSD-3-Clause
#include "node_box.h"

#include <Eigen/Geometry>
#include <cmath>

#include "json_fields.h"

namespace tsg::scene_graph {
namespace {

using nlohmann::json;

enum class BoxType { kInvalid, kAligned, kRotated };

// Numbers in old files, words in newer ones; null: a type that its writer had no word for.
BoxType readType(const json& box) {
  const json& type = getField(box, "type");
  if (type == "INVALID" || type == 0) return BoxType::kInvalid;
  if (type == "AABB" || type == 1) return BoxType::kAligned;
  if (type == "OBB" || type == "RAABB" || type == 2 || type == 3) return BoxType::kRotated;
  if (type.is_null()) return box.contains("min") ? BoxType::kRotated : BoxType::kInvalid;
  failOn("type", type, "AABB, OBB, RAABB or INVALID");
}

Eigen::Matrix3d readRotation(const json& box) {
  const auto place = box.find("world_R_center");
  if (place == box.end()) return Eigen::Matrix3d::Identity();
  Eigen::Vector4d wxyz;
  const char* const names[] = {"w", "x", "y", "z"};
  for (int i = 0; i < 4; ++i) {
    const auto value = place->find(names[i]);
    const bool is_number = value != place->end() && value->is_number();
    if (!is_number) failOn("world_R_center", *place, "w, x, y and z");
    wxyz[i] = value->get<double>();
  }
  const double norm = wxyz.norm();
  if (!(norm > 0.0) || !std::isfinite(norm)) failOn("world_R_center", *place, "a quaternion");
  wxyz /= norm;
  return Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).toRotationMatrix();
}

// Before 1.0.3.
bool hasCorners(const json& box) {
  return !box.contains("dimensions") && box.contains("min") && box.contains("max");
}

struct Box : RotatedBox {
  BoxType type = BoxType::kInvalid;
  Eigen::Vector3d mesh_origin_m = Eigen::Vector3d::Zero();
};

/// Corners around the centre in the box's own axes.
void setRelativeCorners(const Eigen::Vector3d& min, const Eigen::Vector3d& max, Box& box) {
  box.center_m += box.rotation * (min + max) / 2.0;
  box.size_m = (max - min).cwiseAbs();
}

void readCorners(const json& json_box, Box& box) {
  const Eigen::Vector3d min = readVector(json_box, "min");
  const Eigen::Vector3d max = readVector(json_box, "max");
  const bool has_center = json_box.contains("world_P_center");
  if (has_center) box.center_m = readVector(json_box, "world_P_center");
  box.mesh_origin_m = box.center_m;
  if (box.type == BoxType::kRotated) return setRelativeCorners(min, max, box);
  if (!(min.array() <= max.array()).all()) failOn("min", json_box.at("min"), "not above 'max'");
  // World corners are symmetric to 0 only around 0: elsewhere they are relative to the centre.
  const bool is_symmetric = (min + max).norm() <= 1e-6 * (max - min).norm();
  if (is_symmetric && box.center_m.norm() > 1e-6) return setRelativeCorners(min, max, box);
  box.center_m = (min + max) / 2.0;
  box.size_m = max - min;
  box.mesh_origin_m = min;
}

Box parseBox(const json& attributes) {
  const json& json_box = getField(attributes, "bounding_box");
  if (!json_box.is_object()) failOn("bounding_box", json_box, "a box");
  Box box;
  box.type = readType(json_box);
  if (box.type == BoxType::kInvalid) return box;
  if (box.type == BoxType::kRotated) box.rotation = readRotation(json_box);
  if (hasCorners(json_box)) {
    readCorners(json_box, box);
    return box;
  }
  box.size_m = readVector(json_box, "dimensions");
  box.center_m = box.mesh_origin_m = readVector(json_box, "world_P_center");
  if (!(box.size_m.array() >= 0.0).all()) {
    failOn("dimensions", json_box.at("dimensions"), "none below 0");
  }
  return box;
}

Aabb computeHull(const Box& box) {
  if (box.type == BoxType::kInvalid) return {};
  const Eigen::Vector3d reach = box.rotation.cwiseAbs() * box.size_m / 2.0;
  return makeAabb(box.center_m - reach, box.center_m + reach);
}

}  // namespace

Aabb readBox(const json& attributes) {
  const Aabb hull = computeHull(parseBox(attributes));
  if (!hull.isEmpty() && !(hull.min().allFinite() && hull.max().allFinite())) {
    failOn("bounding_box", attributes.at("bounding_box"), "finite numbers");
  }
  return hull;
}

RotatedBox readRotatedBox(const json& attributes) { return parseBox(attributes); }

std::optional<OrientedBox> readNotedBox(const json& attributes) {
  const auto metadata = attributes.find("metadata");
  if (metadata == attributes.end() || !metadata->is_object()) return std::nullopt;
  const auto noted = metadata->find("oriented_box");
  if (noted == metadata->end()) return std::nullopt;
  const json& yaw = getField(*noted, "yaw_rad");
  if (!yaw.is_number()) failOn("yaw_rad", yaw, "a number");
  OrientedBox box;
  box.center_m = readVector(*noted, "center_m");
  box.size_m = readVector(*noted, "size_m");
  box.yaw_rad = yaw.get<double>();
  return box;
}

json toNotedBox(const OrientedBox& box) {
  return {
      {"center_m", toJson(box.center_m)}, {"size_m", toJson(box.size_m)}, {"yaw_rad", box.yaw_rad}};
}

MeshFrame readMeshFrame(const json& attributes) {
  const Box box = parseBox(attributes);
  return {box.rotation, box.mesh_origin_m};
}

json replaceBox(const json& form, const Aabb& hull) {
  json box = form;
  if (hull.isEmpty()) return box;
  box["type"] = box.at("type").is_number() ? json(1) : json("AABB");
  box["world_P_center"] = toJson(hull.center());
  box["world_R_center"] = {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
  if (hasCorners(box)) {
    box["min"] = toJson(hull.min());
    box["max"] = toJson(hull.max());
  } else {
    box["dimensions"] = toJson(hull.sizes());
  }
  return box;
}

}  // namespace tsg::scene_graph
