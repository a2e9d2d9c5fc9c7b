// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/simulation/model.h"
#include "task_scene_graph/simulation/random.h"

/// The things an apartment is furnished with. Sizes in metres, close to common real ones; colours
/// are drawn from `random`.
namespace tsg::simulation::catalogue {

struct NamedColor {
  const char* name;
  Color rgb;
};

NamedColor pickColor(Random& random);  ///< of paints, fabrics and china
NamedColor pickWoodColor(Random& random);
Material makePlain(const Color& color);
Material makeWood(const Color& color);
Material makeFabric(const Color& color);
Material makeGlowing(const Color& color, float glow);

// Kitchen.
Arrangement makeKitchenRow(Random& random);  ///< refrigerator, counter, sink, stove, wall cabinets
Arrangement makeDiningSet(Random& random, int num_chairs);
// Living room.
Model makeSofa(Random& random);
Model makeArmchair(Random& random);
Arrangement makeCoffeeTableOnRug(Random& random);
Model makeTvStand(Random& random);
Model makeTelevision();
Model makeBookshelf(Random& random);
Model makeFloorLamp(Random& random);
Model makePottedPlant(Random& random);
// Bedroom and children's room.
Arrangement makeBed(Random& random, bool is_double);
Model makeWardrobe(Random& random);
Model makeChestOfDrawers(Random& random);
Model makeToyBox(Random& random);
// Bathroom.
Model makeToilet();
Model makeWashBasin(Random& random);
Model makeBathtub();
Model makeWashingMachine();
Model makeLaundryBasket(Random& random);
// Office.
Arrangement makeDeskWithChair(Random& random);
Model makePrinterTable(Random& random);
Model makeWasteBin(Random& random);
// Corridor and storage room.
Model makeShoeRack(Random& random);
Model makeUmbrellaStand(Random& random);
Model makeStorageShelf(Random& random);
Model makeVacuumCleaner(Random& random);
// On walls and under ceilings; the back (+y) lies on the wall.
Model makeWindow();
Model makePicture(Random& random);
Model makeMirror();
Model makeWhiteboard();
Model makeCoatRack(Random& random);
Model makeCeilingLamp(double ceiling_m);
Model makeFrontDoor(Random& random);
// Small things that stand on others. `name` is one of smallThings().
Model makeSmallThing(const std::string& name, Random& random);
const std::vector<std::string>& smallThings();

// Things that touch.
enum class Layout {
  kStack,  ///< one on the other
  kRow,    ///< side by side along x
  kPile    ///< a row and, on its joints, a row of one less
};

struct SetMember {
  const char* phrase;
  const char* task;  ///< that is about this thing alone; nullptr: none
  NamedColor color;
  Shape shape;  ///< kBox or kFrustum
  Eigen::Vector3d size_m;
};

/// Things that are one to `task` and several to the tasks of its members.
struct ThingSet {
  const char* phrase;
  const char* task;
  Layout layout;
  bool stands_on_floor;
  std::vector<SetMember> members;  ///< from below, or from the left
};

const std::vector<ThingSet>& thingSets();
/// The members, each touching the next, all in the frame of the first; sizes vary by a few percent.
Arrangement arrangeSet(const ThingSet& set, Random& random);
/// A table against a wall with room on it for sets.
Model makeWorkTable(Random& random, double length_m);

}  // namespace tsg::simulation::catalogue
