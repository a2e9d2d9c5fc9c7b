// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include "catalogue.h"
#include "furnisher.h"

namespace tsg::simulation {
namespace {

using catalogue::makeSmallThing;

Side opposite(Side side) { return static_cast<Side>((static_cast<int>(side) + 2) % 4); }

/// The model with its back where the back of a thing of depth `depth_m` is.
PlacedModel backToBack(const Model& model, double depth_m, double x_m = 0.0, double z_m = 0.0) {
  const double y = 0.5 * depth_m - model.computeBounds().max().y();
  return {model, makeQuarterTurn(0, Eigen::Vector3d(x_m, y, z_m))};
}

void scatter(Furnisher& furnisher, const Room& room, const std::string& support,
             const std::vector<std::string>& names, Random& random) {
  for (const std::string& name : names) {
    const bool faces_front =
        name == "books" || name == "microwave" || name == "printer" || name == "shoes";
    furnisher.placeOn(room, support, makeSmallThing(name, random), faces_front ? 0.0 : 0.35,
                      random);
  }
}

void hangPictures(Furnisher& furnisher, const Room& room, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    furnisher.placeAlongAnyWall(room, alone(catalogue::makePicture(random)), random);
  }
}

void furnishKitchen(Furnisher& f, const Room& room, Random& random) {
  const Arrangement row = catalogue::makeKitchenRow(random);
  if (f.placeAlongWall(room, row, room.outer_side, random) < 0)
    f.placeAlongAnyWall(room, row, random);
  if (f.placeInMiddle(room, catalogue::makeDiningSet(random, 4), random) < 0) {
    f.placeInMiddle(room, catalogue::makeDiningSet(random, 2), random);
  }
  f.placeAlongAnyWall(room, alone(catalogue::makeWasteBin(random)), random);
  scatter(f, room, "kitchen cabinet", {"microwave", "kettle", "toaster", "bottle", "mug"}, random);
  scatter(f, room, "stove", {"pan"}, random);
  scatter(f, room, "dining table", {"fruit", "plate", "mug", "plate", "bottle", "mug"}, random);
  scatter(f, room, "refrigerator", {"carton"}, random);
}

void furnishLivingRoom(Furnisher& f, const Room& room, Random& random) {
  Arrangement seats = alone(catalogue::makeSofa(random));
  for (PlacedModel thing : catalogue::makeCoffeeTableOnRug(random)) {
    thing.T_group_model = makeQuarterTurn(0, Eigen::Vector3d(0, -1.1, 0)) * thing.T_group_model;
    seats.push_back(thing);
  }
  Arrangement screen = alone(catalogue::makeTvStand(random));
  screen.push_back(
      {catalogue::makeTelevision(), makeQuarterTurn(0, Eigen::Vector3d(0, 0.05, 0.46))});
  Side side = random.chance(0.5) ? Side::kEast : Side::kWest;
  if (f.placeAlongWall(room, seats, side, random) < 0) {
    side = opposite(side);
    f.placeAlongWall(room, seats, side, random);
  }
  if (f.placeAlongWall(room, screen, opposite(side), random) < 0)
    f.placeAlongAnyWall(room, screen, random);
  f.placeAlongAnyWall(room, alone(catalogue::makeBookshelf(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeArmchair(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeFloorLamp(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makePottedPlant(random)), random);
  scatter(f, room, "coffee table", {"magazine", "remote", "mug", "vase"}, random);
  scatter(f, room, "bookshelf", {"books", "books", "books", "books", "vase", "books", "books"},
          random);
  scatter(f, room, "sofa", {"book"}, random);
}

void furnishBedroom(Furnisher& f, const Room& room, Random& random) {
  if (f.placeAlongAnyWall(room, catalogue::makeBed(random, true), random) < 0) {
    f.placeAlongAnyWall(room, catalogue::makeBed(random, false), random);
  }
  f.placeAlongAnyWall(room, alone(catalogue::makeWardrobe(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeChestOfDrawers(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makePottedPlant(random)), random);
  scatter(f, room, "nightstand", {"bedside lamp", "bedside lamp", "clock", "book"}, random);
  scatter(f, room, "chest of drawers", {"vase", "towels"}, random);
  scatter(f, room, "bed", {"teddy", "book"}, random);
}

void furnishBathroom(Furnisher& f, const Room& room, Random& random) {
  f.placeAlongAnyWall(room, alone(catalogue::makeBathtub()), random);
  Arrangement basin = alone(catalogue::makeWashBasin(random));
  basin.push_back(backToBack(catalogue::makeMirror(), 0.48));
  f.placeAlongAnyWall(room, basin, random);
  f.placeAlongAnyWall(room, alone(catalogue::makeToilet()), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWashingMachine()), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeLaundryBasket(random)), random);
  scatter(f, room, "wash basin", {"soap", "toothbrush"}, random);
  scatter(f, room, "washing machine", {"towels"}, random);
}

void furnishOffice(Furnisher& f, const Room& room, Random& random) {
  Arrangement desk = catalogue::makeDeskWithChair(random);
  const double x = random.uniform(-0.3, 0.0);
  desk.push_back(
      {makeSmallThing("monitor", random), makeQuarterTurn(0, Eigen::Vector3d(x, 0.12, 0.7475))});
  desk.push_back(
      {makeSmallThing("keyboard", random), makeQuarterTurn(0, Eigen::Vector3d(x, -0.17, 0.7475))});
  f.placeAlongAnyWall(room, desk, random);
  f.placeAlongAnyWall(room, alone(catalogue::makeBookshelf(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makePrinterTable(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWasteBin(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeWhiteboard()), random);
  f.placeAlongAnyWall(room, alone(makeSmallThing("backpack", random)), random);
  scatter(f, room, "filing cabinet", {"printer"}, random);
  scatter(f, room, "desk", {"laptop", "desk lamp", "mug", "book"}, random);
  scatter(f, room, "bookshelf", {"books", "books", "books", "books", "carton", "books"}, random);
}

void furnishCorridor(Furnisher& f, const Room& room, Random& random) {
  const Side end = random.chance(0.5) ? Side::kEast : Side::kWest;
  f.placeAlongWall(room, alone(catalogue::makeFrontDoor(random)), end, random);
  for (const Side side : {Side::kNorth, Side::kSouth}) {
    if (f.placeAlongWall(room, alone(catalogue::makeShoeRack(random)), side, random) >= 0) break;
  }
  for (const Side side : {Side::kSouth, Side::kNorth}) {
    if (f.placeAlongWall(room, alone(catalogue::makeCoatRack(random)), side, random) >= 0) break;
  }
  f.placeAlongWall(room, alone(catalogue::makeMirror()), Side::kNorth, random);
  f.placeAlongWall(room, alone(catalogue::makeUmbrellaStand(random)), Side::kNorth, random);
  scatter(f, room, "shoe rack", {"shoes", "shoes", "shoes", "shoes"}, random);
}

void furnishChildrensRoom(Furnisher& f, const Room& room, Random& random) {
  f.placeAlongAnyWall(room, catalogue::makeBed(random, false), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeToyBox(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeBookshelf(random)), random);
  f.placeAlongAnyWall(room, alone(catalogue::makeChestOfDrawers(random)), random);
  f.placeAlongAnyWall(room, alone(makeSmallThing("ball", random)), random);
  scatter(f, room, "bed", {"teddy"}, random);
  scatter(f, room, "toy box", {"blocks"}, random);
  scatter(f, room, "bookshelf", {"books", "books", "blocks", "books"}, random);
  scatter(f, room, "nightstand", {"bedside lamp"}, random);
}

void furnishStorageRoom(Furnisher& f, const Room& room, Random& random) {
  for (int i = 0; i < 2; ++i) {
    f.placeAlongAnyWall(room, alone(catalogue::makeStorageShelf(random)), random);
  }
  f.placeAlongAnyWall(room, alone(catalogue::makeVacuumCleaner(random)), random);
  f.placeAlongAnyWall(room, alone(makeSmallThing("carton", random)), random);
  scatter(f, room, "storage shelf",
          {"carton", "toolbox", "carton", "towels", "carton", "bottle", "carton"}, random);
}

}  // namespace

void addWindows(Furnisher& furnisher, const Room& room, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    furnisher.placeAlongWall(room, alone(catalogue::makeWindow()), room.outer_side, random);
  }
}

void addCeilingLamp(Furnisher& furnisher, const Room& room) {
  const Eigen::Vector2d middle = room.interior_m.center();
  furnisher.placeAt(room, alone(catalogue::makeCeilingLamp(room.height_m)),
                    makeQuarterTurn(0, Eigen::Vector3d(middle.x(), middle.y(), 0.0)));
}

void furnishRoom(Furnisher& f, const Room& room, Random& random) {
  switch (room.kind) {
    case RoomKind::kKitchen:
      return furnishKitchen(f, room, random);
    case RoomKind::kLivingRoom:
      return furnishLivingRoom(f, room, random);
    case RoomKind::kBedroom:
      return furnishBedroom(f, room, random);
    case RoomKind::kBathroom:
      return furnishBathroom(f, room, random);
    case RoomKind::kOffice:
      return furnishOffice(f, room, random);
    case RoomKind::kCorridor:
      return furnishCorridor(f, room, random);
    case RoomKind::kChildrensRoom:
      return furnishChildrensRoom(f, room, random);
    case RoomKind::kStorageRoom:
      return furnishStorageRoom(f, room, random);
    default:  // furnishWorkRooms() knows the others
      return;
  }
}

void furnishRooms(Apartment& apartment, Random& random) {
  Furnisher furnisher(apartment);
  for (const Room& room : apartment.rooms) {
    Random own = random.fork(room.phrase);
    furnishRoom(furnisher, room, own);
    if (room.kind != RoomKind::kCorridor) {
      addWindows(furnisher, room, room.kind == RoomKind::kBathroom ? 1 : 2, own);
    }
    hangPictures(furnisher, room, room.kind == RoomKind::kBathroom ? 0 : 2, own);
    addCeilingLamp(furnisher, room);
  }
}

}  // namespace tsg::simulation
