// SPDX-License-Identifier: BSD-3-Clause
#include "floor_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

/// In the order in which they are added as the apartment grows; the widest rooms first.
constexpr std::array<RoomType, 7> kTypes = {{{RoomKind::kLivingRoom, "living room", 5.2},
                                             {RoomKind::kKitchen, "kitchen", 4.4},
                                             {RoomKind::kBedroom, "bedroom", 4.2},
                                             {RoomKind::kBathroom, "bathroom", 3.0},
                                             {RoomKind::kOffice, "office", 3.7},
                                             {RoomKind::kChildrensRoom, "children's room", 3.9},
                                             {RoomKind::kStorageRoom, "storage room", 2.9}}};

Color pickWallColor(Random& random) {
  static const std::array<Color, 6> kPaints = {
      Color(0.93F, 0.91F, 0.86F), Color(0.85F, 0.89F, 0.91F), Color(0.90F, 0.88F, 0.80F),
      Color(0.86F, 0.90F, 0.84F), Color(0.92F, 0.87F, 0.83F), Color(0.91F, 0.91F, 0.92F)};
  return kPaints[static_cast<std::size_t>(random.integer(static_cast<int>(kPaints.size())))];
}

/// Splits the room types over two rows, each wide room to the row that is shorter so far.
std::array<std::vector<RoomType>, 2> splitIntoRows(const std::vector<RoomType>& types,
                                                   Random& random) {
  std::array<std::vector<RoomType>, 2> rows;
  std::array<double, 2> lengths = {0.0, 0.0};
  for (RoomType type : types) {
    type.width_m *= random.uniform(0.95, 1.1);
    const std::size_t row = lengths[0] <= lengths[1] ? 0 : 1;
    auto& rooms = rows[row];
    const int place = random.integer(static_cast<int>(rooms.size()) + 1);
    rooms.insert(rooms.begin() + place, type);
    lengths[row] += type.width_m;
  }
  return rows;
}

double computeLength(const std::vector<RoomType>& row, double wall_m) {
  double length_m = wall_m * (static_cast<double>(row.size()) - 1.0);
  for (const RoomType& type : row) length_m += type.width_m;
  return length_m;
}

void addRow(const std::vector<RoomType>& row, const PlanStyle& style, double length_m, bool north,
            Random& random, Apartment& apartment) {
  const double wall_m = apartment.wall_m;
  const double widths_m = computeLength(row, 0.0);
  const double walls_m = computeLength(row, wall_m) - widths_m;
  const double share = (length_m - walls_m) / widths_m;
  const double depth_m = random.uniform(style.min_depth_m, style.max_depth_m);
  double x = -0.5 * length_m;
  for (const RoomType& type : row) {
    const double width_m = type.width_m * share;
    const double y0 =
        north ? 0.5 * kCorridorWidth_m + wall_m : -0.5 * kCorridorWidth_m - wall_m - depth_m;
    Room room;
    room.id = static_cast<int>(apartment.rooms.size()) + 1;
    room.kind = type.kind;
    room.phrase = type.phrase;
    room.interior_m = makeRect(x, y0, x + width_m, y0 + depth_m);
    room.outer_side = north ? Side::kNorth : Side::kSouth;
    room.wall_color = pickWallColor(random);
    apartment.rooms.push_back(room);
    x += width_m + wall_m;
  }
}

/// A whole side of a bay, from floor to ceiling.
Doorway makeOpenSide(const Room& room) {
  Doorway opening;
  opening.center_m = room.interior_m.center();
  opening.width_m = room.interior_m.sizes().x();
  opening.height_m = room.height_m;
  return opening;
}

/// One doorway from each room to the corridor, well away from the room's corners.
void addCorridorDoors(const PlanStyle& style, Random& random, Apartment& apartment) {
  for (const Room& room : apartment.rooms) {
    if (room.kind == RoomKind::kCorridor) continue;
    Doorway door = style.is_open ? makeOpenSide(room) : Doorway{};
    door.room_a = 1;
    door.room_b = room.id;
    const double side = room.outer_side == Side::kNorth ? 1.0 : -1.0;
    door.center_m.y() = side * 0.5 * (kCorridorWidth_m + apartment.wall_m);
    if (style.is_open) {
      apartment.doorways.push_back(door);
      continue;
    }
    const double margin_m = 0.5 * door.width_m + 0.25;
    const bool left = random.chance(0.5);
    const double slack_m = random.uniform(0.0, 0.4);
    door.center_m.x() = left ? room.interior_m.min().x() + margin_m + slack_m
                             : room.interior_m.max().x() - margin_m - slack_m;
    apartment.doorways.push_back(door);
  }
}

/// A doorway between kitchen and living room where they are neighbours: a loop in the plan.
void addKitchenPassage(Apartment& apartment) {
  for (const Room& a : apartment.rooms) {
    for (const Room& b : apartment.rooms) {
      const bool pair = (a.kind == RoomKind::kKitchen && b.kind == RoomKind::kLivingRoom) ||
                        (b.kind == RoomKind::kKitchen && a.kind == RoomKind::kLivingRoom);
      const double gap_m = b.interior_m.min().x() - a.interior_m.max().x();
      if (!pair || a.outer_side != b.outer_side || std::abs(gap_m - apartment.wall_m) > 1e-6) {
        continue;
      }
      Doorway door;
      door.room_a = a.id;
      door.room_b = b.id;
      door.leads_along_y = false;
      door.center_m.x() = a.interior_m.max().x() + 0.5 * apartment.wall_m;
      const double near_corridor_m = a.outer_side == Side::kNorth ? a.interior_m.min().y() + 1.75
                                                                  : a.interior_m.max().y() - 1.75;
      door.center_m.y() = near_corridor_m;
      apartment.doorways.push_back(door);
    }
  }
}

/// The corridor's east end, through the outer wall; what lies behind has no room yet.
Doorway makeEastOpening(const Apartment& apartment) {
  Doorway opening;
  opening.room_a = 1;
  opening.leads_along_y = false;
  opening.width_m = kCorridorWidth_m;
  opening.height_m = apartment.rooms.front().height_m;
  opening.center_m.x() = apartment.rooms.front().interior_m.max().x() + 0.5 * kOuterWall_m;
  return opening;
}

}  // namespace

void addBox(Apartment& apartment, const Aabb& box, const Material& material) {
  if ((box.sizes().array() <= 1e-9).any()) return;
  Solid solid;
  solid.T_world_solid = Pose(Eigen::Translation3d(box.center()));
  solid.half_size_m = 0.5 * box.sizes();
  solid.material = material;
  apartment.solids.push_back(solid);
}

namespace {

/// A wall over `area`, with the openings of the doorways that lie in it.
void addWall(Apartment& apartment, const Rect& area, bool along_x, double height_m) {
  Material paint;
  paint.pattern = Pattern::kWall;
  paint.color = Color(0.92F, 0.92F, 0.9F);
  const int axis = along_x ? 0 : 1;
  std::vector<Doorway> openings;
  for (const Doorway& door : apartment.doorways) {
    if (door.leads_along_y == along_x && area.contains(door.center_m)) openings.push_back(door);
  }
  std::sort(openings.begin(), openings.end(), [axis](const Doorway& a, const Doorway& b) {
    return a.center_m[axis] < b.center_m[axis];
  });
  const auto addPiece = [&](double from_m, double to_m, double z0_m) {
    Aabb box = makeAabb({area.min().x(), area.min().y(), z0_m},
                        {area.max().x(), area.max().y(), height_m});
    box.min()[axis] = from_m;
    box.max()[axis] = to_m;
    addBox(apartment, box, paint);
  };
  double start_m = area.min()[axis];
  for (const Doorway& door : openings) {
    const double from_m = door.center_m[axis] - 0.5 * door.width_m;
    addPiece(start_m, from_m, 0.0);
    addPiece(from_m, from_m + door.width_m, door.height_m);
    start_m = from_m + door.width_m;
  }
  addPiece(start_m, area.max()[axis], 0.0);
}

Rect computeOutline(const Apartment& apartment) {
  Rect outline;
  for (const Room& room : apartment.rooms) outline.extend(room.interior_m);
  return outline;
}

/// Walls run from one outer wall to the other without sharing volume: those along x between those
/// along y. Between bays there are none.
void addWalls(const PlanStyle& style, Apartment& apartment) {
  const Rect inner = computeOutline(apartment);
  const Eigen::Vector2d a = inner.min();
  const Eigen::Vector2d b = inner.max();
  const double height_m = apartment.rooms.front().height_m;
  const double t = kOuterWall_m;
  addWall(apartment, makeRect(a.x() - t, a.y() - t, b.x() + t, a.y()), true, height_m);
  addWall(apartment, makeRect(a.x() - t, b.y(), b.x() + t, b.y() + t), true, height_m);
  addWall(apartment, makeRect(a.x() - t, a.y(), a.x(), b.y()), false, height_m);
  addWall(apartment, makeRect(b.x(), a.y(), b.x() + t, b.y()), false, height_m);
  const double half_m = 0.5 * kCorridorWidth_m;
  const double w = apartment.wall_m;
  const double inner_m = std::min(height_m, style.partition_height_m);
  if (style.is_open) return;
  addWall(apartment, makeRect(a.x(), half_m, b.x(), half_m + w), true, inner_m);
  addWall(apartment, makeRect(a.x(), -half_m - w, b.x(), -half_m), true, inner_m);
  for (const Room& room : apartment.rooms) {
    const Rect& r = room.interior_m;
    if (room.kind == RoomKind::kCorridor || r.max().x() > b.x() - w) continue;
    addWall(apartment, makeRect(r.max().x(), r.min().y(), r.max().x() + w, r.max().y()), false,
            inner_m);
  }
}

Material pickFloor(RoomKind kind) {
  Material floor;
  if (kind == RoomKind::kKitchen || kind == RoomKind::kBathroom) {
    floor.pattern = Pattern::kTiles;
    floor.color =
        kind == RoomKind::kKitchen ? Color(0.72F, 0.66F, 0.58F) : Color(0.70F, 0.76F, 0.80F);
    floor.second = Color(0.45F, 0.43F, 0.41F);
    floor.scale_m = kind == RoomKind::kKitchen ? 0.4F : 0.25F;
  } else if (kind == RoomKind::kStorageRoom) {
    floor.pattern = Pattern::kFabric;
    floor.color = Color(0.52F, 0.52F, 0.52F);
  } else {
    floor.pattern = Pattern::kPlanks;
    floor.color =
        kind == RoomKind::kBedroom ? Color(0.62F, 0.45F, 0.30F) : Color(0.70F, 0.54F, 0.37F);
    floor.scale_m = 0.16F;
  }
  return floor;
}

/// Each floor reaches to the middle of the inner walls; one ceiling over all.
void addSlabs(Apartment& apartment) {
  const double half_wall_m = 0.5 * apartment.wall_m;
  for (const Room& room : apartment.rooms) {
    const Rect& r = room.interior_m;
    addBox(apartment,
           makeAabb({r.min().x() - half_wall_m, r.min().y() - half_wall_m, -kSlab_m},
                    {r.max().x() + half_wall_m, r.max().y() + half_wall_m, 0.0}),
           pickFloor(room.kind));
  }
  const Rect o = computeOutline(apartment);
  const double height_m = apartment.rooms.front().height_m;
  Material white;
  white.color = Color(0.95F, 0.95F, 0.94F);
  addBox(apartment,
         makeAabb({o.min().x() - kOuterWall_m, o.min().y() - kOuterWall_m, height_m},
                  {o.max().x() + kOuterWall_m, o.max().y() + kOuterWall_m, height_m + kSlab_m}),
         white);
}

}  // namespace

int Apartment::findRoom(const Eigen::Vector2d& p_m, int floor) const {
  for (const Room& room : rooms) {
    if (room.floor == floor && room.interior_m.contains(p_m)) return room.id;
  }
  return 0;
}

int Apartment::findRoom(const Eigen::Vector3d& p_m) const {
  const double floor = std::floor((p_m.z() + kSlab_m) / kStorey_m);
  return findRoom(p_m.head<2>(), static_cast<int>(std::max(0.0, std::min(floor, 1000.0))));
}

Apartment buildPlan(const ApartmentConfig& config, const PlanStyle& style, Random& random) {
  Apartment apartment;
  apartment.config = config;
  const auto rows = splitIntoRows(style.types, random);
  // Both rows get the same length: the longer one is squeezed, the shorter one stretched.
  const double mean_m =
      0.5 * (computeLength(rows[0], apartment.wall_m) + computeLength(rows[1], apartment.wall_m));
  const double length_m = style.length_m > 0.0 ? style.length_m : mean_m;
  Room corridor;
  corridor.id = 1;
  corridor.phrase = "corridor";
  corridor.interior_m =
      makeRect(-0.5 * length_m, -0.5 * kCorridorWidth_m, 0.5 * length_m, 0.5 * kCorridorWidth_m);
  corridor.wall_color = pickWallColor(random);
  apartment.rooms.push_back(corridor);
  addRow(rows[0], style, length_m, true, random, apartment);
  addRow(rows[1], style, length_m, false, random, apartment);
  addCorridorDoors(style, random, apartment);
  addKitchenPassage(apartment);
  if (style.opens_east) apartment.doorways.push_back(makeEastOpening(apartment));
  addWalls(style, apartment);
  addSlabs(apartment);
  return apartment;
}

Apartment buildFloorPlan(const ApartmentConfig& config) {
  config::validate(config, "apartment");
  Random random(combineSeeds(static_cast<std::uint64_t>(config.seed), hashText("floor plan")));
  PlanStyle style;
  style.types.assign(kTypes.begin(), kTypes.begin() + config.num_rooms - 1);
  return buildPlan(config, style, random);
}

}  // namespace tsg::simulation
