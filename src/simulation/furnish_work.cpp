// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <string>

#include "catalogue.h"
#include "furnisher.h"

namespace tsg::simulation {
namespace {

using catalogue::makeSmallThing;
using catalogue::ThingSet;

constexpr std::array<const char*, 6> kTables = {
    "work table", "desk", "coffee table", "dining table", "kitchen cabinet", "filing cabinet"};

Arrangement makeComputerDesk(Random& random) {
  Arrangement desk = catalogue::makeDeskWithChair(random);
  const double x = random.uniform(-0.45, -0.25);
  desk.push_back(
      {makeSmallThing("monitor", random), makeQuarterTurn(0, Eigen::Vector3d(x, 0.12, 0.7475))});
  desk.push_back(
      {makeSmallThing("keyboard", random), makeQuarterTurn(0, Eigen::Vector3d(x, -0.17, 0.7475))});
  return desk;
}

void furnishCubicle(Furnisher& f, const Room& room, Random& random) {
  if (f.placeAlongWall(room, makeComputerDesk(random), room.outer_side, random) < 0) {
    f.placeAlongAnyWall(room, makeComputerDesk(random), random);
  }
  f.placeAlongAnyWall(room, alone(catalogue::makeWorkTable(random, 1.4)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWorkTable(random, 1.0)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWasteBin(random)), random);
}

void furnishDeskBay(Furnisher& f, const Room& room, Random& random) {
  for (int i = 0; i < 2; ++i) {
    f.placeAlongWall(room, makeComputerDesk(random), room.outer_side, random);
  }
  f.placeAlongAnyWall(room, alone(catalogue::makeWorkTable(random, 1.6)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makePrinterTable(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWasteBin(random)), random);
  f.placeOn(room, "desk", makeSmallThing("mug", random), 0.35, random);
}

void furnishMeetingArea(Furnisher& f, const Room& room, Random& random) {
  f.placeInMiddle(room, catalogue::makeDiningSet(random, 4), random);
  f.placeAlongWall(room, alone(catalogue::makeWhiteboard()), room.outer_side, random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWorkTable(random, 1.4)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makePottedPlant(random)), random);
}

void furnishLounge(Furnisher& f, const Room& room, Random& random) {
  f.placeAlongWall(room, alone(catalogue::makeSofa(random)), room.outer_side, random);
  f.placeInMiddle(room, catalogue::makeCoffeeTableOnRug(random), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeArmchair(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWorkTable(random, 1.2)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makePottedPlant(random)), random);
}

void furnishPrintArea(Furnisher& f, const Room& room, Random& random) {
  f.placeAlongWall(room, alone(catalogue::makePrinterTable(random)), room.outer_side, random);
  f.placeOn(room, "filing cabinet", makeSmallThing("printer", random), 0.0, random);
  f.placeAlongAnyWall(room, alone(catalogue::makeStorageShelf(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWorkTable(random, 1.4)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWasteBin(random)), random);
  f.placeAlongAnyWall(room, alone(makeSmallThing("backpack", random)), random);
}

void placeSet(Furnisher& f, const Room& room, const ThingSet& set, Random& random) {
  const Arrangement things = catalogue::arrangeSet(set, random);
  if (set.stands_on_floor) {
    f.placeGroupAlongAnyWall(room, set.phrase, things, random);
    return;
  }
  for (const char* table : kTables) {
    if (f.placeGroupOn(room, table, set.phrase, things, 0.3, random)) return;
  }
}

void furnishWorkRoom(Furnisher& f, const Room& room, Random& random) {
  switch (room.kind) {
    case RoomKind::kCubicle:
      return furnishCubicle(f, room, random);
    case RoomKind::kDeskBay:
      return furnishDeskBay(f, room, random);
    case RoomKind::kMeetingArea:
      return furnishMeetingArea(f, room, random);
    case RoomKind::kLounge:
      return furnishLounge(f, room, random);
    case RoomKind::kPrintArea:
      return furnishPrintArea(f, room, random);
    case RoomKind::kCorridor:
      return;  // stays free: it is an aisle
    default:
      return furnishRoom(f, room, random);
  }
}

}  // namespace

void furnishWorkRooms(Apartment& apartment, Random& random) {
  constexpr int kSetsPerRoom = 4;
  constexpr int kSetsPerCubicle = 6;
  const auto& sets = catalogue::thingSets();
  auto next = static_cast<std::size_t>(random.integer(static_cast<int>(sets.size())));
  Furnisher furnisher(apartment);
  for (const Room& room : apartment.rooms) {
    Random own = random.fork(room.phrase);
    furnishWorkRoom(furnisher, room, own);
    addCeilingLamp(furnisher, room);
    if (room.kind == RoomKind::kCorridor) continue;
    const int count = room.kind == RoomKind::kCubicle ? kSetsPerCubicle : kSetsPerRoom;
    for (int i = 0; i < count; ++i) placeSet(furnisher, room, sets[next++ % sets.size()], own);
    addWindows(furnisher, room, 1, own);
  }
}

}  // namespace tsg::simulation
