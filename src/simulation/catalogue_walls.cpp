// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "catalogue.h"

namespace tsg::simulation::catalogue {
namespace {

const Color kWhite(0.95F, 0.95F, 0.94F);
const Color kDark(0.1F, 0.1F, 0.11F);
const Color kSteel(0.72F, 0.73F, 0.75F);

/// Four bars around a rectangle of the given outer size, centred at height 0.
void addFrame(Model& m, double width_m, double height_m, double bar_m, const Material& material) {
  for (const double s : {-0.5, 0.5}) {
    m.box("frame", {s * (width_m - bar_m), 0, 0}, {bar_m, 0.04, height_m}, material);
    m.box("frame", {0, 0, s * (height_m - bar_m)}, {width_m - 2.0 * bar_m, 0.04, bar_m}, material);
  }
}

}  // namespace

NamedColor pickColor(Random& random) {
  static const std::array<NamedColor, 10> kColors = {{{"red", Color(0.70F, 0.17F, 0.15F)},
                                                      {"blue", Color(0.18F, 0.32F, 0.62F)},
                                                      {"green", Color(0.24F, 0.48F, 0.28F)},
                                                      {"yellow", Color(0.85F, 0.70F, 0.22F)},
                                                      {"orange", Color(0.85F, 0.45F, 0.16F)},
                                                      {"purple", Color(0.45F, 0.27F, 0.52F)},
                                                      {"grey", Color(0.48F, 0.49F, 0.51F)},
                                                      {"beige", Color(0.78F, 0.69F, 0.56F)},
                                                      {"turquoise", Color(0.20F, 0.56F, 0.56F)},
                                                      {"brown", Color(0.42F, 0.28F, 0.19F)}}};
  return kColors[static_cast<std::size_t>(random.integer(static_cast<int>(kColors.size())))];
}

NamedColor pickWoodColor(Random& random) {
  static const std::array<NamedColor, 4> kWoods = {{{"oak", Color(0.66F, 0.49F, 0.31F)},
                                                    {"walnut", Color(0.40F, 0.27F, 0.18F)},
                                                    {"birch", Color(0.80F, 0.67F, 0.48F)},
                                                    {"white", Color(0.88F, 0.87F, 0.85F)}}};
  return kWoods[static_cast<std::size_t>(random.integer(static_cast<int>(kWoods.size())))];
}

Material makePlain(const Color& color) {
  Material material;
  material.color = color;
  return material;
}

Material makeWood(const Color& color) {
  Material material = makePlain(color);
  material.pattern = Pattern::kWood;
  return material;
}

Material makeFabric(const Color& color) {
  Material material = makePlain(color);
  material.pattern = Pattern::kFabric;
  return material;
}

Material makeGlowing(const Color& color, float glow) {
  Material material = makePlain(color);
  material.glow = glow;
  return material;
}

Model makeWindow() {
  Model m("window", "white");
  addFrame(m, 1.4, 1.2, 0.06, makePlain(kWhite));
  m.box("frame", {0, 0, 0}, {0.05, 0.035, 1.08}, makePlain(kWhite));
  Material sky = makeGlowing(Color(0.55F, 0.74F, 0.95F), 0.9F);
  sky.pattern = Pattern::kSky;
  m.box("pane", {0, 0.012, 0}, {1.28, 0.016, 1.08}, sky);
  m.box("sill", {0, -0.06, -0.62}, {1.5, 0.16, 0.03}, makePlain(kWhite));
  return m.raisedTo(1.55);
}

Model makePicture(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  const NamedColor grass = pickColor(random);
  Model m("picture", grass.name);
  const double width_m = random.uniform(0.5, 0.8);
  const double height_m = random.uniform(0.4, 0.6);
  addFrame(m, width_m, height_m, 0.03, makeWood(wood.rgb));
  Material canvas = makePlain(grass.rgb);
  canvas.pattern = Pattern::kPicture;
  canvas.second = Color(0.3F, 0.38F, 0.18F);
  m.box("canvas", {0, 0.01, 0}, {width_m - 0.06, 0.018, height_m - 0.06}, canvas);
  return m.raisedTo(1.55);
}

Model makeMirror() {
  Model m("mirror", "silver");
  addFrame(m, 0.7, 0.9, 0.03, makePlain(kSteel));
  m.box("glass", {0, 0.01, 0}, {0.64, 0.018, 0.84}, makeGlowing(Color(0.68F, 0.76F, 0.8F), 0.3F));
  return m.raisedTo(1.5);
}

Model makeWhiteboard() {
  Model m("whiteboard", "white");
  addFrame(m, 1.3, 0.9, 0.025, makePlain(kSteel));
  m.box("board", {0, 0.01, 0}, {1.25, 0.018, 0.85}, makePlain(Color(0.97F, 0.97F, 0.98F)));
  for (const double z : {0.22, 0.08, -0.06}) {
    m.box("writing", {-0.15, -0.0005, z}, {0.6, 0.003, 0.02}, makePlain(Color(0.15F, 0.25F, 0.6F)));
  }
  m.box("writing", {0.38, -0.0005, 0.1}, {0.18, 0.003, 0.2}, makePlain(Color(0.7F, 0.2F, 0.2F)));
  return m.raisedTo(1.5);
}

Model makeCoatRack(Random& random) {
  Model m("coat rack", "oak");
  m.box("board", {0, 0.03, 0.0}, {0.9, 0.03, 0.12}, makeWood(Color(0.6F, 0.44F, 0.28F)));
  for (int i = 0; i < 4; ++i) {
    const double x = -0.33 + 0.22 * i;
    m.box("hook", {x, -0.01, 0.0}, {0.02, 0.06, 0.02}, makePlain(kDark));
    if (i == 1) continue;
    const Color cloth = pickColor(random).rgb;
    m.cylinder("coat", {x, -0.05, -0.47}, 0.11, 0.9, makeFabric(cloth), 0.45);
  }
  return m.raisedTo(1.75).seenInParts();
}

Model makeCeilingLamp(double ceiling_m) {
  Model m("ceiling lamp", "white");
  m.cylinder("mount", {0, 0, ceiling_m - 0.02}, 0.06, 0.04, makePlain(kSteel));
  m.ellipsoid("globe", {0, 0, ceiling_m - 0.12}, {0.4, 0.4, 0.16},
              makeGlowing(Color(1.0F, 0.98F, 0.9F), 0.95F));
  return m;
}

Model makeFrontDoor(Random& random) {
  const NamedColor color = pickColor(random);
  Model m("front door", color.name);
  m.box("frame", {-0.49, 0, 1.05}, {0.06, 0.08, 2.1}, makePlain(kWhite));
  m.box("frame", {0.49, 0, 1.05}, {0.06, 0.08, 2.1}, makePlain(kWhite));
  m.box("frame", {0, 0, 2.08}, {0.92, 0.08, 0.06}, makePlain(kWhite));
  m.box("leaf", {0, 0.01, 1.025}, {0.92, 0.05, 2.05}, makeWood(color.rgb * 0.8F));
  for (const double z : {0.55, 1.45}) {
    m.box("leaf", {0, -0.02, z}, {0.6, 0.02, 0.7}, makeWood(color.rgb * 0.95F));
  }
  m.box("handle", {0.38, -0.045, 1.0}, {0.12, 0.02, 0.025}, makePlain(kSteel));
  return m;
}

Model makeShoeRack(Random& random) {
  const NamedColor wood = pickWoodColor(random);
  Model m("shoe rack", wood.name);
  for (const double x : {-0.38, 0.38})
    m.box("side", {x, 0, 0.27}, {0.03, 0.34, 0.54}, makeWood(wood.rgb));
  for (const double z : {0.08, 0.3, 0.525}) {
    m.box("shelf board", {0, 0, z}, {0.73, 0.34, 0.025}, makeWood(wood.rgb));
    m.support(makeRect(-0.34, -0.16, 0.34, 0.16), z + 0.0125, z > 0.4 ? 0.6 : 0.18);
  }
  return m;
}

Model makeUmbrellaStand(Random& random) {
  Model m("umbrella", "black");
  m.cylinder("stand", {0, 0, 0.22}, 0.11, 0.44, makePlain(Color(0.35F, 0.36F, 0.38F)));
  m.cylinder("umbrella", {0.02, 0, 0.55}, 0.045, 0.5, makeFabric(pickColor(random).rgb), 0.4);
  m.cylinder("umbrella", {0.02, 0, 0.86}, 0.012, 0.12, makeWood(Color(0.45F, 0.3F, 0.18F)));
  return m;
}

Model makeVacuumCleaner(Random& random) {
  const NamedColor color = pickColor(random);
  Model m("vacuum cleaner", color.name);
  m.ellipsoid("body", {0, 0, 0.15}, {0.32, 0.46, 0.28}, makePlain(color.rgb));
  for (const double x : {-0.15, 0.15})
    m.ellipsoid("wheel", {x, 0.1, 0.08}, {0.05, 0.16, 0.16}, makePlain(kDark));
  m.cylinder("tube", {0, -0.16, 0.55}, 0.02, 0.8, makePlain(kSteel));
  m.box("handle", {0, -0.14, 0.96}, {0.03, 0.1, 0.03}, makePlain(kDark));
  return m;
}

Model makeWasteBin(Random& random) {
  const NamedColor color = pickColor(random);
  Model m("waste bin", color.name);
  m.solid("bin", Shape::kFrustum,
          Pose(Eigen::Translation3d(0, 0, 0.17) * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())),
          {0.28, 0.28, 0.34}, makePlain(color.rgb), 0.78);
  m.cylinder("rim", {0, 0, 0.345}, 0.142, 0.01, makePlain(kDark));
  return m;
}

}  // namespace tsg::simulation::catalogue
