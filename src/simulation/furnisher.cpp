// SPDX-License-Identifier: BSD-3-Clause
#include "furnisher.h"

#include <algorithm>
#include <map>

namespace tsg::simulation {
namespace {

constexpr int kTries = 60;
constexpr double kWallGap_m = 0.01;
constexpr double kThingGap_m = 0.01;
constexpr double kDoorZone_m = 1.0;
constexpr double kFlat_m = 0.05;  ///< what is lower may lie where people walk

Aabb computeModelBounds(const Model& model, const Pose& T) {
  Aabb box;
  for (const Solid& solid : model.solids()) {
    box.extend(computeBounds(solid, T * solid.T_world_solid));
  }
  return box;
}

Aabb computeGroupBounds(const Arrangement& things, const Pose& T) {
  Aabb box;
  for (const PlacedModel& thing : things) {
    box.extend(computeModelBounds(thing.model, T * thing.T_group_model));
  }
  return box;
}

bool isWithin(const Aabb& box, const Rect& area_m) {
  return (box.min().head<2>().array() >= area_m.min().array()).all() &&
         (box.max().head<2>().array() <= area_m.max().array()).all();
}

/// The box grown to all sides in the plane.
Aabb grow(const Aabb& box, double gap_m) {
  const Eigen::Vector3d gap(gap_m, gap_m, -1e-6);
  return Aabb(box.min() - gap, box.max() + gap);
}

/// The axis-aligned box around a turned one (Eigen 3.4 has this as AlignedBox::transformed).
Aabb transformBox(const Pose& T, const Aabb& box) {
  const Eigen::Vector3d center = T * box.center();
  const Eigen::Vector3d reach = T.linear().cwiseAbs() * box.sizes() / 2.0;
  return Aabb(center - reach, center + reach);
}

/// Space in front (-y) of the model that must stay free; empty if it needs none.
Aabb computeFrontZone(const Model& model, const Pose& T_world_model) {
  const double depth_m = model.frontClearance();
  if (depth_m <= 0.0) return {};
  const Aabb local = model.computeBounds();
  const Eigen::Vector3d a(local.min().x(), local.min().y() - depth_m, kFlat_m);
  const Eigen::Vector3d b(local.max().x(), local.min().y(), 1.8);
  return transformBox(T_world_model, Aabb(a, b));
}

Aabb computeDoorZone(const Doorway& door) {
  const double half_m = 0.5 * door.width_m + 0.05;
  Eigen::Vector3d half(half_m, kDoorZone_m, 0.0);
  if (!door.leads_along_y) std::swap(half.x(), half.y());
  const Eigen::Vector3d center(door.center_m.x(), door.center_m.y(), kFlat_m);
  return Aabb(center - half, center + half + Eigen::Vector3d(0.0, 0.0, door.height_m));
}

}  // namespace

Furnisher::Furnisher(Apartment& apartment) : apartment_(apartment) {
  for (const Doorway& door : apartment.doorways) keepouts_.push_back(computeDoorZone(door));
}

int Furnisher::placeAlongWall(const Room& room, const Arrangement& things, Side side,
                              Random& random) {
  const auto turns = static_cast<int>(side);
  const Aabb turned = computeGroupBounds(things, makeQuarterTurn(turns, Eigen::Vector3d::Zero()));
  const bool along_x = side == Side::kNorth || side == Side::kSouth;
  const int axis = along_x ? 0 : 1;
  const int across = 1 - axis;
  const Rect& r = room.interior_m;
  const double low_m = r.min()[axis] - turned.min()[axis] + kWallGap_m;
  const double high_m = r.max()[axis] - turned.max()[axis] - kWallGap_m;
  if (low_m > high_m) return -1;
  const bool at_high_end = side == Side::kNorth || side == Side::kEast;
  Eigen::Vector3d place(0.0, 0.0, 0.0);
  place[across] = at_high_end ? r.max()[across] - turned.max()[across] - kWallGap_m
                              : r.min()[across] - turned.min()[across] + kWallGap_m;
  for (int i = 0; i < kTries; ++i) {
    place[axis] = random.uniform(low_m, high_m);
    const int index = placeAt(room, things, makeQuarterTurn(turns, place));
    if (index >= 0) return index;
  }
  return -1;
}

int Furnisher::placeAlongAnyWall(const Room& room, const Arrangement& things, Random& random) {
  const int first = random.integer(4);
  for (int i = 0; i < 4; ++i) {
    const int index = placeAlongWall(room, things, static_cast<Side>((first + i) % 4), random);
    if (index >= 0) return index;
  }
  return -1;
}

int Furnisher::placeInMiddle(const Room& room, const Arrangement& things, Random& random) {
  for (int i = 0; i < kTries; ++i) {
    const int turns = random.integer(4);
    const double x =
        random.uniform(room.interior_m.min().x() + 0.6, room.interior_m.max().x() - 0.6);
    const double y =
        random.uniform(room.interior_m.min().y() + 0.6, room.interior_m.max().y() - 0.6);
    const Pose T = makeQuarterTurn(turns, Eigen::Vector3d(x, y, 0.0));
    // Room to walk round it on all sides.
    if (!isWithin(grow(computeGroupBounds(things, T), 0.7), room.interior_m)) continue;
    const int index = placeAt(room, things, T);
    if (index >= 0) return index;
  }
  return -1;
}

bool Furnisher::isFree(const Room& room, const Arrangement& things,
                       const Pose& T_world_group) const {
  for (const PlacedModel& thing : things) {
    const Pose T = T_world_group * thing.T_group_model;
    const Aabb box = computeModelBounds(thing.model, T);
    if (!isWithin(box, room.interior_m)) return false;
    const Aabb front = computeFrontZone(thing.model, T);
    const auto blocks = [&](const Aabb& other) {
      return hasOverlap(grow(box, kThingGap_m), other);
    };
    if (std::any_of(keepouts_.begin(), keepouts_.end(), blocks)) return false;
    for (const Instance& other : apartment_.instances) {
      if (blocks(other.box) || (!front.isEmpty() && hasOverlap(front, other.box))) return false;
    }
  }
  return true;
}

int Furnisher::placeAt(const Room& room, const Arrangement& things, const Pose& T_world_group) {
  if (!isFree(room, things, T_world_group)) return -1;
  const auto first = static_cast<int>(apartment_.instances.size());
  for (const PlacedModel& thing : things)
    add(room, thing.model, T_world_group * thing.T_group_model);
  return first;
}

bool Furnisher::placeOn(const Room& room, const std::string& support_phrase, const Model& thing,
                        double max_turn_rad, Random& random) {
  return placeAllOn(room, support_phrase, alone(thing), max_turn_rad, random);
}

bool Furnisher::placeAllOn(const Room& room, const std::string& support_phrase,
                           const Arrangement& things, double max_turn_rad, Random& random) {
  std::vector<Surface> candidates;
  for (const Surface& surface : surfaces_) {
    if (surface.room == room.id && surface.phrase == support_phrase) candidates.push_back(surface);
  }
  for (int i = 0; i < kTries && !candidates.empty(); ++i) {
    const Surface& surface =
        candidates[static_cast<std::size_t>(random.integer(static_cast<int>(candidates.size())))];
    const Rect& area_m = surface.support.area_m;
    const double x = random.uniform(area_m.min().x(), area_m.max().x());
    const double y = random.uniform(area_m.min().y(), area_m.max().y());
    const double turn_rad = random.uniform(-max_turn_rad, max_turn_rad);
    const Pose T_model_group(Eigen::Translation3d(x, y, surface.support.height_m) *
                             Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    const Aabb in_model = computeGroupBounds(things, T_model_group);
    if (in_model.sizes().z() > surface.support.clearance_m || !isWithin(in_model, area_m)) continue;
    const Pose T = surface.T_world_model * T_model_group;
    if (!isFreeOn(computeGroupBounds(things, T), room.interior_m)) continue;
    for (const PlacedModel& thing : things) add(room, thing.model, T * thing.T_group_model);
    return true;
  }
  return false;
}

bool Furnisher::placeGroupOn(const Room& room, const std::string& support_phrase,
                             const std::string& phrase, const Arrangement& things,
                             double max_turn_rad, Random& random) {
  if (!placeAllOn(room, support_phrase, things, max_turn_rad, random)) return false;
  addGroup(phrase, things.size());
  return true;
}

bool Furnisher::placeGroupAlongAnyWall(const Room& room, const std::string& phrase,
                                       const Arrangement& things, Random& random) {
  if (placeAlongAnyWall(room, things, random) < 0) return false;
  addGroup(phrase, things.size());
  return true;
}

/// The group has the frame of its first instance.
void Furnisher::addGroup(const std::string& phrase, std::size_t count) {
  Group group;
  group.phrase = phrase;
  const std::size_t end = apartment_.instances.size();
  group.T_world_group = apartment_.instances[end - count].T_world_instance;
  const Pose T_group_world = group.T_world_group.inverse();
  for (std::size_t i = end - count; i < end; ++i) {
    const Instance& instance = apartment_.instances[i];
    group.instances.push_back(instance.id);
    group.local_box.extend(
        transformBox(T_group_world * instance.T_world_instance, instance.local_box));
  }
  apartment_.groups.push_back(group);
}

/// Unlike for furniture, the spaces between another thing's solids count as free.
bool Furnisher::isFreeOn(const Aabb& box, const Rect& area_m) const {
  if (!isWithin(box, area_m)) return false;
  const Aabb grown = grow(box, kThingGap_m);
  return std::none_of(apartment_.solids.begin(), apartment_.solids.end(),
                      [&](const Solid& solid) { return hasOverlap(grown, computeBounds(solid)); });
}

int Furnisher::add(const Room& room, const Model& model, const Pose& T_world_model) {
  Instance instance;
  instance.id = static_cast<std::uint16_t>(apartment_.instances.size() + 1);
  instance.phrase = model.phrase();
  instance.color_name = model.colorName();
  instance.room = room.id;
  instance.seen_in_parts = model.isSeenInParts();
  instance.T_world_instance = T_world_model;
  instance.local_box = model.computeBounds();
  addSolids(model, T_world_model, instance);
  apartment_.instances.push_back(instance);
  for (const Support& support : model.supports()) {
    surfaces_.push_back({room.id, model.phrase(), T_world_model, support});
  }
  const Aabb front = computeFrontZone(model, T_world_model);
  if (!front.isEmpty()) keepouts_.push_back(front);
  return instance.id - 1;
}

/// Solids of one name are one part; a thing that is not seen in parts is one part as a whole.
void Furnisher::addSolids(const Model& model, const Pose& T_world_model, Instance& instance) {
  std::map<std::string, std::uint16_t> ids;
  for (std::size_t i = 0; i < model.solids().size(); ++i) {
    const std::string name = model.isSeenInParts() ? model.parts()[i] : model.phrase();
    auto [entry, is_new] =
        ids.emplace(name, static_cast<std::uint16_t>(apartment_.parts.size() + 1));
    if (is_new) apartment_.parts.push_back({instance.id, name});
    Solid solid = model.solids()[i];
    solid.T_world_solid = T_world_model * solid.T_world_solid;
    solid.instance = instance.id;
    solid.part = entry->second;
    instance.box.extend(computeBounds(solid));
    apartment_.solids.push_back(solid);
  }
}

}  // namespace tsg::simulation
