// SPDX-License-Identifier: BSD-3-Clause
#include "catalogue.h"

namespace tsg::simulation::catalogue {
namespace {

const Color kSteel(0.72F, 0.73F, 0.75F);
const Color kDark(0.12F, 0.12F, 0.13F);

Model makeRefrigerator() {
  Model m("refrigerator", "silver");
  const Material steel = makePlain(Color(0.80F, 0.81F, 0.83F));
  m.box("body", {0, 0.02, 0.91}, {0.62, 0.58, 1.82}, steel);
  m.box("lower door", {0, -0.29, 0.56}, {0.6, 0.04, 1.06}, makePlain(Color(0.86F, 0.87F, 0.88F)));
  m.box("upper door", {0, -0.29, 1.46}, {0.6, 0.04, 0.68}, makePlain(Color(0.86F, 0.87F, 0.88F)));
  m.box("handle", {-0.24, -0.325, 0.85}, {0.03, 0.03, 0.36}, makePlain(kSteel));
  m.box("handle", {-0.24, -0.325, 1.3}, {0.03, 0.03, 0.24}, makePlain(kSteel));
  return m.support(makeRect(-0.28, -0.24, 0.28, 0.28), 1.82, 0.4).seenInParts();
}

/// Cabinet fronts under a worktop; things can stand on `free_area`.
Model makeCounter(double width_m, const Material& front, const Material& top,
                  const Rect& free_area) {
  Model m("kitchen cabinet", "painted");
  m.box("plinth", {0, 0.03, 0.05}, {width_m, 0.52, 0.1}, makePlain(kDark));
  m.box("body", {0, 0.02, 0.48}, {width_m, 0.54, 0.76}, front);
  const int doors = width_m > 0.9 ? 3 : 2;
  const double door_m = width_m / doors;
  for (int i = 0; i < doors; ++i) {
    const double x = -0.5 * width_m + (i + 0.5) * door_m;
    m.box("cabinet door", {x, -0.26, 0.48}, {door_m - 0.02, 0.02, 0.72}, front);
    m.box("handle", {x, -0.28, 0.78}, {0.14, 0.02, 0.02}, makePlain(kSteel));
  }
  m.box("worktop", {0, 0.0, 0.88}, {width_m, 0.6, 0.04}, top);
  return m.support(free_area, 0.9, 0.5).seenInParts();
}

/// Basin and tap, standing on the worktop.
Model makeSink() {
  Model m("kitchen sink", "steel");
  const Material steel = makePlain(kSteel);
  m.box("rim", {0, -0.19, 0.02}, {0.56, 0.04, 0.04}, steel);
  m.box("rim", {0, 0.15, 0.02}, {0.56, 0.04, 0.04}, steel);
  m.box("rim", {-0.26, -0.02, 0.02}, {0.04, 0.3, 0.04}, steel);
  m.box("rim", {0.26, -0.02, 0.02}, {0.04, 0.3, 0.04}, steel);
  m.box("basin", {0, -0.02, 0.004}, {0.48, 0.3, 0.008}, makePlain(Color(0.5F, 0.51F, 0.53F)));
  m.cylinder("tap", {0, 0.2, 0.12}, 0.018, 0.24, steel);
  m.box("tap", {0, 0.12, 0.24}, {0.03, 0.18, 0.025}, steel);
  return m;
}

Model makeStove() {
  Model m("stove", "white");
  m.box("body", {0, 0.02, 0.44}, {0.6, 0.56, 0.88}, makePlain(Color(0.9F, 0.9F, 0.9F)));
  m.box("oven door", {0, -0.27, 0.42}, {0.56, 0.02, 0.5}, makePlain(kDark));
  m.box("handle", {0, -0.29, 0.71}, {0.46, 0.02, 0.025}, makePlain(kSteel));
  m.box("cooktop", {0, 0.02, 0.89}, {0.58, 0.54, 0.02}, makePlain(Color(0.2F, 0.2F, 0.21F)));
  for (const double x : {-0.14, 0.14}) {
    for (const double y : {-0.11, 0.15}) {
      m.cylinder("hot plate", {x, y, 0.905}, y < 0 ? 0.1 : 0.08, 0.01, makePlain(kDark));
    }
  }
  return m.support(makeRect(-0.25, -0.22, 0.25, 0.25), 0.91, 0.5).seenInParts();
}

Model makeWallCabinet(double width_m, const Material& front) {
  Model m("wall cabinet", "painted");
  m.box("body", {0, 0.0, 0.32}, {width_m, 0.32, 0.64}, front);
  for (const double side : {-1.0, 1.0}) {
    m.box("cabinet door", {side * 0.25 * width_m, -0.17, 0.32}, {0.5 * width_m - 0.02, 0.02, 0.62},
          front);
    m.box("handle", {side * 0.06, -0.19, 0.1}, {0.02, 0.02, 0.12}, makePlain(kSteel));
  }
  return m.seenInParts();
}

Model makeRangeHood() {
  Model m("range hood", "steel");
  m.cylinder("hood", {0, 0, 0.06}, 0.27, 0.12, makePlain(kSteel), 0.7);
  m.cylinder("duct", {0, 0, 0.52}, 0.1, 0.8, makePlain(kSteel));
  return m;
}

Model makeDiningTable(Random& random, double length_m) {
  const NamedColor wood = pickWoodColor(random);
  Model m("dining table", wood.name);
  const Material material = makeWood(wood.rgb);
  m.box("table top", {0, 0, 0.73}, {length_m, 0.85, 0.04}, material);
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-0.36, 0.36}) {
      m.box("leg", {x * (0.5 * length_m - 0.07), y, 0.355}, {0.07, 0.07, 0.71}, material);
    }
  }
  return m.support(makeRect(-0.5 * length_m + 0.05, -0.38, 0.5 * length_m - 0.05, 0.38), 0.75, 0.8)
      .seenInParts();
}

Model makeDiningChair(const NamedColor& wood, const NamedColor& seat) {
  Model m("dining chair", wood.name);
  const Material frame = makeWood(wood.rgb);
  for (const double x : {-0.19, 0.19}) {
    m.box("leg", {x, -0.18, 0.22}, {0.04, 0.04, 0.44}, frame);
    m.box("back post", {x, 0.2, 0.45}, {0.04, 0.04, 0.9}, frame);
  }
  m.box("seat", {0, 0.0, 0.46}, {0.44, 0.44, 0.05}, makeFabric(seat.rgb));
  m.box("backrest", {0, 0.2, 0.76}, {0.36, 0.025, 0.26}, frame);
  return m.seenInParts();
}

}  // namespace

Arrangement makeKitchenRow(Random& random) {
  static const Color kFronts[] = {Color(0.86F, 0.84F, 0.78F), Color(0.36F, 0.48F, 0.52F),
                                  Color(0.55F, 0.62F, 0.50F)};
  const Material front = makePlain(kFronts[random.integer(3)]);
  const Material top = makeWood(Color(0.52F, 0.38F, 0.25F));
  const auto at = [](double x, double y, double z) {
    return makeQuarterTurn(0, Eigen::Vector3d(x, y, z));
  };
  // Backs in one line at y = 0.3; the wall cabinets are less deep.
  Arrangement row;
  row.push_back({makeCounter(1.3, front, top, makeRect(-0.62, -0.26, 0.04, 0.27)), at(0, 0, 0)});
  row.push_back({makeSink(), at(0.34, 0.0, 0.9)});
  row.push_back({makeStove().needsFront(0.7), at(0.96, 0, 0)});
  row.push_back({makeCounter(0.6, front, top, makeRect(-0.28, -0.26, 0.28, 0.27)), at(1.57, 0, 0)});
  row.push_back({makeRefrigerator().needsFront(0.7), at(-0.98, -0.01, 0)});
  row.push_back({makeWallCabinet(1.28, front), at(0, 0.14, 1.45)});
  row.push_back({makeRangeHood(), at(0.96, 0.02, 1.55)});
  return row;
}

Arrangement makeDiningSet(Random& random, int num_chairs) {
  const double length_m = num_chairs > 2 ? 1.5 : 1.0;
  Arrangement set;
  set.push_back({makeDiningTable(random, length_m), Pose::Identity()});
  const NamedColor wood = pickWoodColor(random);
  const NamedColor seat = pickColor(random);
  for (int i = 0; i < num_chairs; ++i) {
    const double x = num_chairs > 2 ? (i < 2 ? -0.36 : 0.36) : 0.0;
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double pulled_out_m = random.uniform(0.02, 0.08);
    const Eigen::Vector3d place(x, side * (0.425 + 0.22 + pulled_out_m), 0.0);
    set.push_back({makeDiningChair(wood, seat), makeQuarterTurn(side > 0 ? 0 : 2, place)});
  }
  return set;
}

}  // namespace tsg::simulation::catalogue
