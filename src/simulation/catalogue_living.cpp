// SPDX-License-Identifier: BSD-3-Clause
#include "catalogue.h"

namespace tsg::simulation::catalogue {
namespace {

const Color kDark(0.08F, 0.08F, 0.09F);

/// Seat, back and arms `width_m` wide, with `cushions` seat cushions.
Model makeSeat(const char* phrase, const NamedColor& color, double width_m, int cushions) {
  Model m(phrase, color.name);
  const Material cloth = makeFabric(color.rgb);
  const Material light = makeFabric(color.rgb * 1.12F);
  m.box("base", {0, 0.0, 0.2}, {width_m, 0.86, 0.24}, cloth);
  m.box("backrest", {0, 0.33, 0.58}, {width_m, 0.2, 0.52}, cloth);
  for (const double side : {-1.0, 1.0}) {
    m.box("armrest", {side * (0.5 * width_m - 0.09), -0.1, 0.46}, {0.18, 0.66, 0.28}, cloth);
    m.box("foot", {side * (0.5 * width_m - 0.08), -0.36, 0.04}, {0.06, 0.06, 0.08},
          makePlain(kDark));
    m.box("foot", {side * (0.5 * width_m - 0.08), 0.36, 0.04}, {0.06, 0.06, 0.08},
          makePlain(kDark));
  }
  const double inner_m = (width_m - 0.36) / cushions;
  for (int i = 0; i < cushions; ++i) {
    const double x = -0.5 * (width_m - 0.36) + (i + 0.5) * inner_m;
    m.box("seat cushion", {x, -0.1, 0.39}, {inner_m - 0.015, 0.66, 0.14}, light);
  }
  const double reach_m = 0.5 * width_m - 0.2;
  return m.support(makeRect(-reach_m, -0.4, reach_m, 0.2), 0.46, 0.5).seenInParts();
}

void addShelfBoards(Model& m, double width_m, double depth_m, double height_m, int count,
                    const Material& material) {
  const double gap_m = (height_m - 0.06) / count;
  for (int i = 0; i <= count; ++i) {
    const double z = 0.04 + i * gap_m;
    m.box("shelf board", {0, 0, z}, {width_m - 0.04, depth_m, 0.025}, material);
    if (i < count) {
      m.support(makeRect(-0.5 * width_m + 0.05, -0.5 * depth_m + 0.01, 0.5 * width_m - 0.05,
                         0.5 * depth_m - 0.02),
                z + 0.0125, gap_m - 0.04);
    }
  }
}

}  // namespace

Model makeSofa(Random& random) {
  return makeSeat("sofa", pickColor(random), 2.0, 3).needsFront(0.6);
}

Model makeArmchair(Random& random) {
  return makeSeat("armchair", pickColor(random), 0.95, 1).needsFront(0.4);
}

Arrangement makeCoffeeTableOnRug(Random& random) {
  const NamedColor cloth = pickColor(random);
  Model rug("rug", cloth.name);
  Material stripes = makeFabric(cloth.rgb);
  stripes.pattern = Pattern::kStripes;
  stripes.second = cloth.rgb * 0.7F + Color(0.25F, 0.25F, 0.22F);
  stripes.scale_m = 0.17F;
  rug.box("cloth", {0, 0, 0.006}, {1.9, 1.25, 0.012}, stripes);
  const NamedColor wood = pickWoodColor(random);
  Model table("coffee table", wood.name);
  table.box("table top", {0, 0, 0.4}, {1.1, 0.6, 0.04}, makeWood(wood.rgb));
  table.box("lower shelf", {0, 0, 0.15}, {0.96, 0.46, 0.025}, makeWood(wood.rgb));
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.25, 0.25}) {
      table.box("leg", {x, y, 0.19}, {0.06, 0.06, 0.38}, makeWood(wood.rgb));
    }
  }
  table.support(makeRect(-0.52, -0.27, 0.52, 0.27), 0.42, 0.6).seenInParts();
  Arrangement set;
  set.push_back({rug, Pose::Identity()});
  set.push_back({table, makeQuarterTurn(0, Eigen::Vector3d(0, 0, 0.012))});
  return set;
}

Model makeTvStand(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  Model m("tv stand", wood.name);
  m.box("body", {0, 0.01, 0.25}, {1.6, 0.4, 0.42}, makeWood(wood.rgb));
  for (const double x : {-0.53, 0.0, 0.53}) {
    m.box("drawer", {x, -0.2, 0.25}, {0.5, 0.02, 0.36}, makeWood(wood.rgb * 1.1F));
    m.ellipsoid("handle", {x, -0.22, 0.25}, {0.03, 0.03, 0.03}, makePlain(kDark));
  }
  for (const double x : {-0.74, 0.74})
    m.box("foot", {x, 0, 0.02}, {0.06, 0.36, 0.04}, makePlain(kDark));
  return m.support(makeRect(-0.78, -0.17, 0.78, 0.2), 0.46, 1.4).seenInParts();
}

Model makeTelevision() {
  Model m("television", "black");
  m.box("stand", {0, 0, 0.01}, {0.5, 0.22, 0.02}, makePlain(kDark));
  m.box("stand", {0, 0.02, 0.06}, {0.08, 0.04, 0.1}, makePlain(kDark));
  m.box("frame", {0, 0.02, 0.42}, {1.15, 0.05, 0.66}, makePlain(kDark));
  Material screen = makeGlowing(Color(0.12F, 0.22F, 0.3F), 0.6F);
  screen.pattern = Pattern::kPicture;
  screen.second = Color(0.1F, 0.25F, 0.12F);
  m.box("screen", {0, -0.007, 0.42}, {1.1, 0.006, 0.61}, screen);
  return m;
}

Model makeBookshelf(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  Model m("bookshelf", wood.name);
  const Material material = makeWood(wood.rgb);
  for (const double x : {-0.44, 0.44}) m.box("side", {x, 0, 0.95}, {0.03, 0.3, 1.9}, material);
  m.box("back panel", {0, 0.145, 0.95}, {0.85, 0.01, 1.88}, makeWood(wood.rgb * 0.8F));
  addShelfBoards(m, 0.9, 0.28, 1.9, 5, material);
  return m.needsFront(0.4).seenInParts();
}

Model makeFloorLamp(Random& random) {
  const NamedColor shade = pickColor(random);
  Model m("floor lamp", shade.name);
  m.cylinder("base", {0, 0, 0.015}, 0.15, 0.03, makePlain(kDark));
  m.cylinder("pole", {0, 0, 0.75}, 0.015, 1.45, makePlain(kDark));
  m.cylinder("lamp shade", {0, 0, 1.55}, 0.2, 0.3,
             makeGlowing(shade.rgb * 0.5F + Color(0.5F, 0.48F, 0.4F), 0.5F), 0.65);
  return m.seenInParts();
}

Model makePottedPlant(Random& random) {
  Model m("potted plant", "green");
  const double size = random.uniform(0.85, 1.1);
  m.solid("pot", Shape::kFrustum,
          Pose(Eigen::Translation3d(0, 0, 0.15) * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())),
          {0.34, 0.34, 0.3}, makePlain(Color(0.68F, 0.36F, 0.24F)), 0.72);
  m.cylinder("stem", {0, 0, 0.45}, 0.02, 0.32, makeWood(Color(0.4F, 0.28F, 0.16F)));
  const Material leaves = makeFabric(Color(0.2F, 0.45F, 0.18F));
  m.ellipsoid("leaves", {0, 0, 0.78}, {0.5 * size, 0.5 * size, 0.5 * size}, leaves);
  m.ellipsoid("leaves", {0.1, 0.05, 1.0}, {0.34 * size, 0.34 * size, 0.36 * size}, leaves);
  m.ellipsoid("leaves", {-0.1, -0.06, 0.95}, {0.32 * size, 0.32 * size, 0.3 * size},
              makeFabric(Color(0.26F, 0.52F, 0.2F)));
  return m;
}

Model makeStorageShelf(Random& random) {
  (void)random;
  Model m("storage shelf", "grey");
  const Material steel = makePlain(Color(0.6F, 0.62F, 0.64F));
  for (const double x : {-0.58, 0.58}) {
    for (const double y : {-0.19, 0.19}) m.box("post", {x, y, 0.9}, {0.04, 0.04, 1.8}, steel);
  }
  addShelfBoards(m, 1.16, 0.42, 1.8, 4, steel);
  return m.needsFront(0.5).seenInParts();
}

}  // namespace tsg::simulation::catalogue
