// SPDX-License-Identifier: BSD-3-Clause
#include "catalogue.h"

namespace tsg::simulation::catalogue {
namespace {

const Color kWhite(0.93F, 0.93F, 0.92F);
const Color kDark(0.1F, 0.1F, 0.11F);
const Color kSteel(0.72F, 0.73F, 0.75F);

/// A chest with rows of drawers: nightstand, chest of drawers.
Model makeDrawers(const char* phrase, const NamedColor& wood, const Eigen::Vector3d& size_m,
                  int rows) {
  Model m(phrase, wood.name);
  m.box("body", {0, 0.01, 0.5 * size_m.z()}, {size_m.x(), size_m.y() - 0.02, size_m.z()},
        makeWood(wood.rgb));
  const double row_m = (size_m.z() - 0.06) / rows;
  for (int i = 0; i < rows; ++i) {
    const double z = 0.04 + (i + 0.5) * row_m;
    m.box("drawer", {0, -0.5 * size_m.y() + 0.01, z}, {size_m.x() - 0.04, 0.02, row_m - 0.02},
          makeWood(wood.rgb * 1.1F));
    m.box("handle", {0, -0.5 * size_m.y() - 0.01, z}, {0.1, 0.02, 0.015}, makePlain(kDark));
  }
  const double x = 0.5 * size_m.x() - 0.02;
  const double y = 0.5 * size_m.y() - 0.02;
  return m.support(makeRect(-x, -y, x, y), size_m.z(), 0.8).seenInParts();
}

Model makeBedItself(Random& random, double width_m) {
  const NamedColor wood = pickWoodColor(random);
  const NamedColor cloth = pickColor(random);
  Model m("bed", cloth.name);
  m.box("bed frame", {0, 0, 0.18}, {width_m + 0.08, 2.02, 0.2}, makeWood(wood.rgb));
  m.box("headboard", {0, 1.03, 0.5}, {width_m + 0.08, 0.06, 1.0}, makeWood(wood.rgb));
  for (const double x : {-1.0, 1.0}) {
    m.box("leg", {x * 0.5 * (width_m - 0.08), -0.92, 0.04}, {0.08, 0.08, 0.08}, makeWood(wood.rgb));
  }
  m.box("mattress", {0, 0, 0.37}, {width_m, 1.98, 0.18}, makeFabric(kWhite));
  m.box("blanket", {0, -0.32, 0.475}, {width_m + 0.03, 1.36, 0.05}, makeFabric(cloth.rgb));
  const int pillows = width_m > 1.2 ? 2 : 1;
  for (int i = 0; i < pillows; ++i) {
    const double x = pillows == 1 ? 0.0 : (i == 0 ? -0.25 : 0.25) * width_m;
    m.ellipsoid("pillow", {x, 0.72, 0.5}, {0.62, 0.4, 0.18}, makeFabric(kWhite));
  }
  return m.support(makeRect(-0.4 * width_m, -0.9, 0.4 * width_m, 0.2), 0.5, 0.8).seenInParts();
}

Model makeOfficeChair(const NamedColor& color) {
  Model m("office chair", color.name);
  m.box("foot", {0, 0, 0.06}, {0.56, 0.06, 0.05}, makePlain(kDark));
  m.box("foot", {0, 0, 0.06}, {0.06, 0.56, 0.05}, makePlain(kDark));
  for (const double s : {-0.25, 0.25}) {
    m.ellipsoid("wheel", {s, 0, 0.03}, {0.06, 0.06, 0.06}, makePlain(kDark));
    m.ellipsoid("wheel", {0, s, 0.03}, {0.06, 0.06, 0.06}, makePlain(kDark));
  }
  m.cylinder("post", {0, 0, 0.25}, 0.03, 0.36, makePlain(kSteel));
  m.box("seat", {0, 0, 0.46}, {0.5, 0.48, 0.09}, makeFabric(color.rgb));
  m.box("backrest", {0, 0.25, 0.8}, {0.44, 0.06, 0.5}, makeFabric(color.rgb));
  m.box("back bracket", {0, 0.23, 0.53}, {0.06, 0.03, 0.12}, makePlain(kDark));
  return m.seenInParts();
}

}  // namespace

Arrangement makeBed(Random& random, bool is_double) {
  const double width_m = is_double ? 1.6 : 0.95;
  const NamedColor wood = pickWoodColor(random);
  Arrangement set;
  set.push_back({makeBedItself(random, width_m).needsFront(0.5), Pose::Identity()});
  for (const double side : {-1.0, 1.0}) {
    if (!is_double && side < 0.0) continue;
    set.push_back({makeDrawers("nightstand", wood, {0.45, 0.38, 0.5}, 2),
                   makeQuarterTurn(0, Eigen::Vector3d(side * (0.5 * width_m + 0.32), 0.87, 0))});
  }
  return set;
}

Model makeWardrobe(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  Model m("wardrobe", wood.name);
  m.box("body", {0, 0.01, 1.0}, {1.5, 0.58, 2.0}, makeWood(wood.rgb));
  for (const double x : {-0.5, 0.0, 0.5}) {
    m.box("wardrobe door", {x, -0.29, 1.03}, {0.48, 0.02, 1.9}, makeWood(wood.rgb * 1.12F));
    m.box("handle", {x + 0.18, -0.31, 1.0}, {0.02, 0.02, 0.25}, makePlain(kSteel));
  }
  return m.needsFront(0.6).seenInParts();
}

Model makeChestOfDrawers(Random& random) {
  return makeDrawers("chest of drawers", pickWoodColor(random), {0.9, 0.45, 0.85}, 4)
      .needsFront(0.4);
}

Model makeToyBox(Random& random) {
  const NamedColor color = pickColor(random);
  Model m("toy box", color.name);
  m.box("chest", {0, 0, 0.2}, {0.7, 0.42, 0.4}, makePlain(color.rgb));
  m.box("lid", {0, 0, 0.42}, {0.74, 0.46, 0.04}, makePlain(color.rgb * 0.8F));
  return m.support(makeRect(-0.34, -0.2, 0.34, 0.2), 0.44, 0.8);
}

Model makeToilet() {
  Model m("toilet", "white");
  const Material china = makePlain(kWhite);
  m.cylinder("bowl", {0, -0.08, 0.19}, 0.2, 0.38, china, 0.95);
  m.box("bowl", {0, 0.1, 0.19}, {0.3, 0.3, 0.38}, china);
  m.ellipsoid("seat", {0, -0.07, 0.4}, {0.44, 0.52, 0.06}, makePlain(Color(0.97F, 0.97F, 0.97F)));
  m.box("cistern", {0, 0.26, 0.6}, {0.42, 0.16, 0.42}, china);
  m.cylinder("flush button", {0, 0.26, 0.815}, 0.03, 0.01, makePlain(kSteel));
  return m.needsFront(0.5);
}

Model makeWashBasin(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  Model m("wash basin", "white");
  m.box("vanity cabinet", {0, 0.03, 0.4}, {0.7, 0.42, 0.76}, makeWood(wood.rgb));
  m.box("basin", {0, 0, 0.81}, {0.76, 0.48, 0.06}, makePlain(kWhite));
  m.ellipsoid("basin", {0, -0.05, 0.84}, {0.46, 0.3, 0.02}, makePlain(Color(0.78F, 0.8F, 0.82F)));
  m.cylinder("tap", {0, 0.17, 0.91}, 0.016, 0.14, makePlain(kSteel));
  m.box("tap", {0, 0.11, 0.97}, {0.025, 0.14, 0.02}, makePlain(kSteel));
  return m.support(makeRect(-0.37, -0.22, -0.25, 0.22), 0.84, 0.4)
      .support(makeRect(0.25, -0.22, 0.37, 0.22), 0.84, 0.4)
      .needsFront(0.5)
      .seenInParts();
}

Model makeBathtub() {
  Model m("bathtub", "white");
  const Material enamel = makePlain(kWhite);
  m.box("rim", {0, -0.33, 0.29}, {1.66, 0.08, 0.58}, enamel);
  m.box("rim", {0, 0.33, 0.29}, {1.66, 0.08, 0.58}, enamel);
  for (const double x : {-0.78, 0.78}) m.box("rim", {x, 0, 0.29}, {0.1, 0.58, 0.58}, enamel);
  m.box("tub floor", {0, 0, 0.08}, {1.46, 0.58, 0.16}, makePlain(Color(0.85F, 0.87F, 0.88F)));
  m.box("tap", {0.78, 0, 0.66}, {0.04, 0.05, 0.16}, makePlain(kSteel));
  m.box("tap", {0.72, 0, 0.73}, {0.14, 0.04, 0.03}, makePlain(kSteel));
  return m.needsFront(0.5);
}

Model makeWashingMachine() {
  Model m("washing machine", "white");
  m.box("body", {0, 0.01, 0.43}, {0.6, 0.56, 0.86}, makePlain(kWhite));
  const Pose facing(Eigen::Translation3d(0, -0.28, 0.42) *
                    Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX()));
  m.solid("door", Shape::kFrustum, facing, {0.4, 0.4, 0.03}, makePlain(kSteel));
  const Pose glass(Eigen::Translation3d(0, -0.295, 0.42) *
                   Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX()));
  m.solid("door", Shape::kFrustum, glass, {0.3, 0.3, 0.02}, makePlain(Color(0.15F, 0.18F, 0.22F)));
  m.box("control panel", {0, -0.275, 0.78}, {0.56, 0.015, 0.1},
        makePlain(Color(0.3F, 0.32F, 0.35F)));
  return m.support(makeRect(-0.28, -0.25, 0.28, 0.27), 0.86, 0.5).needsFront(0.5);
}

Model makeLaundryBasket(Random& random) {
  const NamedColor cloth = pickColor(random);
  Model m("laundry basket", "wicker");
  m.cylinder("basket", {0, 0, 0.25}, 0.22, 0.5, makeFabric(Color(0.66F, 0.53F, 0.36F)));
  m.ellipsoid("laundry", {0, 0, 0.5}, {0.38, 0.38, 0.16}, makeFabric(cloth.rgb));
  return m;
}

Arrangement makeDeskWithChair(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  Model desk("desk", wood.name);
  desk.box("table top", {0, 0, 0.73}, {1.5, 0.7, 0.035}, makeWood(wood.rgb));
  for (const double x : {-0.71, 0.71}) {
    desk.box("side panel", {x, 0, 0.355}, {0.04, 0.64, 0.71}, makeWood(wood.rgb));
  }
  desk.box("drawer unit", {0.48, 0.03, 0.45}, {0.4, 0.55, 0.5}, makeWood(wood.rgb * 1.1F));
  for (const double z : {0.29, 0.45, 0.61}) {
    desk.box("drawer", {0.48, -0.25, z}, {0.36, 0.02, 0.14}, makePlain(Color(0.8F, 0.8F, 0.8F)));
  }
  desk.support(makeRect(-0.72, -0.32, 0.72, 0.33), 0.7475, 0.8).seenInParts();
  Arrangement set;
  set.push_back({desk, Pose::Identity()});
  const double x = random.uniform(-0.3, 0.05);
  const Eigen::Vector3d place(x, -0.35 - 0.28 - 0.05, 0.0);
  set.push_back({makeOfficeChair(pickColor(random)), makeQuarterTurn(2, place)});
  return set;
}

Model makePrinterTable(Random& random) {
  return makeDrawers("filing cabinet", {"grey", Color(0.6F, 0.62F, 0.63F)},
                     {0.55, 0.5, 0.6 + 0.1 * random.integer(2)}, 3)
      .needsFront(0.4);
}

}  // namespace tsg::simulation::catalogue
