// SPDX-License-Identifier: BSD-3-Clause
#include "stairs.h"

#include "floor_plan.h"

namespace tsg::simulation {
namespace {

constexpr int kSteps = 9;  ///< of a flight
constexpr double kTread_m = 0.26;
constexpr double kRise_m = 0.5 * kStorey_m / kSteps;
constexpr double kBefore_m = 0.6;  ///< floor before the first step
constexpr double kLanding_m = 1.2;
constexpr double kLength_m = kBefore_m + kSteps * kTread_m + kLanding_m;
constexpr double kThick_m = 0.15;  ///< of steps and landing

Material makeConcrete() {
  Material concrete;
  concrete.color = Color(0.62F, 0.62F, 0.6F);
  concrete.pattern = Pattern::kFabric;
  return concrete;
}

/// A plate with its top at `top_m`.
void addPlate(Apartment& building, const Rect& area_m, double top_m, double thick_m) {
  addBox(building,
         makeAabb({area_m.min().x(), area_m.min().y(), top_m - thick_m},
                  {area_m.max().x(), area_m.max().y(), top_m}),
         makeConcrete());
}

/// From one floor to the next: up along the north wall, back along the south wall.
void addFlights(Apartment& building, const Rect& area_m, double floor_z_m) {
  const double start_m = area_m.min().x() + kBefore_m;
  const double turn_m = start_m + kSteps * kTread_m;
  const double middle_m = floor_z_m + 0.5 * kStorey_m;
  const double y0 = area_m.min().y();
  const double y1 = area_m.max().y();
  for (int i = 0; i < kSteps; ++i) {
    const double x = start_m + i * kTread_m;
    const double back = turn_m - i * kTread_m;
    addPlate(building, makeRect(x, 0.0, x + kTread_m, y1), floor_z_m + (i + 1) * kRise_m, kThick_m);
    addPlate(building, makeRect(back - kTread_m, y0, back, 0.0), middle_m + (i + 1) * kRise_m,
             kThick_m);
  }
  addPlate(building, makeRect(turn_m, y0, area_m.max().x(), y1), middle_m, kThick_m);
  const double mid_m = 0.5 * (turn_m + area_m.max().x());
  const double lane_m = 0.5 * y1;
  const double top_m = floor_z_m + kStorey_m;
  const double door_m = area_m.min().x() + 0.2;
  building.stairs.push_back({{door_m, lane_m, floor_z_m},
                             {start_m, lane_m, floor_z_m},
                             {turn_m, lane_m, middle_m},
                             {mid_m, lane_m, middle_m},
                             {mid_m, -lane_m, middle_m},
                             {turn_m, -lane_m, middle_m},
                             {start_m, -lane_m, top_m},
                             {door_m, -lane_m, top_m}});
}

void addShaft(Apartment& building, const Rect& area_m, double top_m) {
  Material paint;
  paint.pattern = Pattern::kWall;
  paint.color = Color(0.92F, 0.92F, 0.9F);
  const double t = kOuterWall_m;
  const Eigen::Vector2d& a = area_m.min();
  const Eigen::Vector2d& b = area_m.max();
  const auto add = [&](double x0, double y0, double x1, double y1) {
    addBox(building, makeAabb({x0, y0, -kSlab_m}, {x1, y1, top_m}), paint);
  };
  add(a.x(), b.y(), b.x() + t, b.y() + t);
  add(a.x(), a.y() - t, b.x() + t, a.y());
  add(b.x(), a.y(), b.x() + t, b.y());
  addPlate(building, makeRect(a.x(), a.y() - t, b.x() + t, b.y() + t), top_m + kSlab_m, kSlab_m);
  addPlate(building, area_m, 0.0, kSlab_m);
}

}  // namespace

Room makeStaircaseRoom(const Apartment& storey) {
  const Rect& corridor_m = storey.rooms.front().interior_m;
  const double x = corridor_m.max().x() + kOuterWall_m;
  Room room;
  room.id = static_cast<int>(storey.rooms.size()) + 1;
  room.kind = RoomKind::kStaircase;
  room.phrase = "staircase";
  room.interior_m = makeRect(x, corridor_m.min().y(), x + kLength_m, corridor_m.max().y());
  room.wall_color = storey.rooms.front().wall_color;
  room.outer_side = Side::kEast;
  return room;
}

void addStairs(Apartment& building, int num_floors) {
  Rect area_m;
  for (const Room& room : building.rooms) {
    if (room.kind == RoomKind::kStaircase) area_m = room.interior_m;
  }
  for (int floor = 0; floor < num_floors; ++floor) {
    const double z = floor * kStorey_m;
    // From the corridor's floor, which ends inside the wall, to the first step.
    addPlate(building,
             makeRect(area_m.min().x() - kOuterWall_m + 0.06, area_m.min().y(),
                      area_m.min().x() + (floor > 0 ? kBefore_m : 0.0), area_m.max().y()),
             z, kSlab_m);
    if (floor + 1 < num_floors) addFlights(building, area_m, z);
  }
  addShaft(building, area_m, (num_floors - 1) * kStorey_m + building.rooms.front().height_m);
}

}  // namespace tsg::simulation
