// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <stdexcept>

#include "catalogue.h"

namespace tsg::simulation::catalogue {
namespace {

const Color kWhite(0.94F, 0.94F, 0.92F);
const Color kDark(0.1F, 0.1F, 0.11F);
const Color kSteel(0.72F, 0.73F, 0.75F);

Pose makeTilt(const Eigen::Vector3d& center_m, double angle_rad) {
  return Pose(Eigen::Translation3d(center_m) *
              Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitX()));
}

Model makeMug(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("coffee mug", c.name);
  m.cylinder("cup", {0, 0, 0.05}, 0.045, 0.1, makePlain(c.rgb));
  m.cylinder("coffee", {0, 0, 0.1005}, 0.038, 0.001, makePlain(Color(0.2F, 0.12F, 0.07F)));
  return m.box("handle", {0.058, 0, 0.05}, {0.03, 0.014, 0.06}, makePlain(c.rgb));
}

Model makeBottle(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("bottle", c.name);
  m.cylinder("body", {0, 0, 0.1}, 0.04, 0.2, makePlain(c.rgb));
  m.cylinder("body", {0, 0, 0.225}, 0.04, 0.05, makePlain(c.rgb), 0.4);
  m.cylinder("cap", {0, 0, 0.27}, 0.018, 0.04, makePlain(kDark));
  return m.cylinder("label", {0, 0, 0.1}, 0.041, 0.09, makePlain(kWhite));
}

Model makeBook(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("book", c.name);
  m.box("cover", {0, 0, 0.004}, {0.17, 0.24, 0.008}, makePlain(c.rgb));
  m.box("pages", {0.004, 0, 0.022}, {0.158, 0.23, 0.028}, makePlain(kWhite));
  m.box("cover", {0, 0, 0.04}, {0.17, 0.24, 0.008}, makePlain(c.rgb));
  return m.box("cover", {-0.081, 0, 0.022}, {0.008, 0.24, 0.028}, makePlain(c.rgb));
}

Model makeBooks(Random& random) {
  Model m("row of books", "colourful");
  double x = -0.2;
  while (x < 0.16) {
    const double width_m = random.uniform(0.022, 0.05);
    const double height_m = random.uniform(0.17, 0.25);
    const double depth_m = random.uniform(0.14, 0.18);
    m.box("book", {x + 0.5 * width_m, 0.09 - 0.5 * depth_m, 0.5 * height_m},
          {width_m - 0.001, depth_m, height_m}, makePlain(pickColor(random).rgb));
    x += width_m;
  }
  return m;
}

Model makeLaptop(Random&) {
  Model m("laptop", "silver");
  m.box("base", {0, 0, 0.009}, {0.34, 0.24, 0.018}, makePlain(kSteel));
  Material keys = makePlain(kDark);
  keys.pattern = Pattern::kTiles;
  keys.second = kSteel;
  keys.scale_m = 0.02F;
  m.box("keys", {0, 0.03, 0.0185}, {0.3, 0.12, 0.003}, keys);
  m.solid("screen", Shape::kBox, makeTilt({0, 0.155, 0.125}, -0.3), {0.34, 0.012, 0.23},
          makePlain(kDark));
  Material glow = makeGlowing(Color(0.35F, 0.5F, 0.75F), 0.8F);
  glow.pattern = Pattern::kPicture;
  m.solid("screen", Shape::kBox, makeTilt({0, 0.149, 0.1235}, -0.3), {0.31, 0.004, 0.2}, glow);
  return m;
}

Model makeMonitor(Random&) {
  Model m("computer monitor", "black");
  m.box("stand", {0, 0.04, 0.008}, {0.24, 0.18, 0.016}, makePlain(kDark));
  m.box("stand", {0, 0.07, 0.11}, {0.05, 0.03, 0.2}, makePlain(kDark));
  m.box("frame", {0, 0.04, 0.33}, {0.6, 0.035, 0.36}, makePlain(kDark));
  Material glow = makeGlowing(Color(0.25F, 0.4F, 0.62F), 0.8F);
  glow.pattern = Pattern::kTiles;
  glow.second = Color(0.85F, 0.88F, 0.92F);
  glow.scale_m = 0.13F;
  return m.box("screen", {0, 0.021, 0.33}, {0.57, 0.005, 0.33}, glow);
}

Model makeKeyboard(Random&) {
  Model m("keyboard", "black");
  Material keys = makePlain(Color(0.25F, 0.25F, 0.27F));
  keys.pattern = Pattern::kTiles;
  keys.second = kDark;
  keys.scale_m = 0.022F;
  return m.box("keys", {0, 0, 0.0125}, {0.44, 0.14, 0.025}, keys);
}

Model makeLamp(const char* phrase, Random& random, double height_m) {
  const NamedColor c = pickColor(random);
  Model m(phrase, c.name);
  m.cylinder("base", {0, 0, 0.015}, 0.08, 0.03, makePlain(kDark));
  m.cylinder("pole", {0, 0, 0.5 * height_m}, 0.012, height_m - 0.06, makePlain(kSteel));
  const Material shade = makeGlowing(c.rgb * 0.6F + Color(0.4F, 0.38F, 0.3F), 0.5F);
  return m.cylinder("shade", {0, 0, height_m}, 0.13, 0.18, shade, 0.6);
}

Model makeTeddyBear(Random&) {
  Model m("teddy bear", "brown");
  const Material fur = makeFabric(Color(0.55F, 0.36F, 0.2F));
  m.ellipsoid("body", {0, 0, 0.13}, {0.22, 0.18, 0.26}, fur);
  m.ellipsoid("head", {0, -0.01, 0.31}, {0.18, 0.17, 0.17}, fur);
  m.ellipsoid("head", {0, -0.09, 0.295}, {0.08, 0.06, 0.06}, makeFabric(Color(0.75F, 0.6F, 0.42F)));
  for (const double s : {-1.0, 1.0}) {
    m.ellipsoid("head", {s * 0.07, 0, 0.39}, {0.06, 0.04, 0.06}, fur);
    m.ellipsoid("arm", {s * 0.12, -0.04, 0.17}, {0.08, 0.12, 0.08}, fur);
    m.ellipsoid("leg", {s * 0.08, -0.12, 0.045}, {0.09, 0.18, 0.09}, fur);
  }
  return m;
}

Model makeBackpack(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("backpack", c.name);
  m.ellipsoid("bag", {0, 0, 0.24}, {0.34, 0.24, 0.48}, makeFabric(c.rgb));
  m.ellipsoid("pocket", {0, -0.1, 0.17}, {0.24, 0.12, 0.24}, makeFabric(c.rgb * 0.8F));
  return m.box("strap", {0, 0.06, 0.47}, {0.06, 0.03, 0.06}, makePlain(kDark));
}

Model makeShoes(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("pair of shoes", c.name);
  for (const double x : {-0.06, 0.06}) {
    m.box("sole", {x, 0, 0.01}, {0.085, 0.26, 0.02}, makePlain(kWhite));
    m.ellipsoid("shoe", {x, -0.02, 0.035}, {0.085, 0.21, 0.08}, makePlain(c.rgb));
    m.cylinder("shoe", {x, 0.075, 0.06}, 0.04, 0.08, makePlain(c.rgb));
  }
  return m;
}

Model makeFruitBowl(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("bowl of fruit", c.name);
  m.solid("bowl", Shape::kFrustum, makeTilt({0, 0, 0.04}, kPi), {0.3, 0.3, 0.08}, makePlain(c.rgb),
          0.5);
  m.ellipsoid("fruit", {0.05, 0.03, 0.1}, {0.08, 0.08, 0.08}, makePlain(Color(0.75F, 0.15F, 0.1F)));
  m.ellipsoid("fruit", {-0.05, 0.03, 0.1}, {0.08, 0.08, 0.08}, makePlain(Color(0.9F, 0.55F, 0.1F)));
  return m.ellipsoid("fruit", {0, -0.05, 0.1}, {0.08, 0.08, 0.08},
                     makePlain(Color(0.5F, 0.7F, 0.2F)));
}

Model makeKettle(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("kettle", c.name);
  m.cylinder("body", {0, 0, 0.11}, 0.09, 0.2, makePlain(c.rgb), 0.75);
  m.cylinder("base", {0, 0, 0.005}, 0.09, 0.01, makePlain(kDark));
  m.box("handle", {0.105, 0, 0.14}, {0.02, 0.025, 0.14}, makePlain(kDark));
  m.box("handle", {0.085, 0, 0.205}, {0.05, 0.025, 0.02}, makePlain(kDark));
  return m.ellipsoid("lid", {0, 0, 0.21}, {0.1, 0.1, 0.05}, makePlain(kDark));
}

Model makeToaster(Random&) {
  Model m("toaster", "steel");
  m.box("body", {0, 0, 0.1}, {0.3, 0.17, 0.18}, makePlain(kSteel));
  m.box("slot", {0, -0.03, 0.19}, {0.22, 0.03, 0.004}, makePlain(kDark));
  m.box("slot", {0, 0.03, 0.19}, {0.22, 0.03, 0.004}, makePlain(kDark));
  m.box("foot", {0, 0, 0.005}, {0.26, 0.14, 0.01}, makePlain(kDark));
  return m.box("lever", {0.16, 0, 0.14}, {0.025, 0.04, 0.02}, makePlain(kDark));
}

Model makeMicrowave(Random&) {
  Model m("microwave oven", "white");
  m.box("body", {0, 0.01, 0.14}, {0.48, 0.33, 0.28}, makePlain(kWhite));
  m.box("door", {-0.06, -0.16, 0.14}, {0.32, 0.01, 0.22}, makePlain(kDark));
  return m.box("panel", {0.17, -0.16, 0.14}, {0.1, 0.01, 0.22},
               makePlain(Color(0.5F, 0.5F, 0.52F)));
}

Model makePan(Random&) {
  Model m("frying pan", "black");
  m.solid("pan", Shape::kFrustum, makeTilt({0, 0, 0.025}, kPi), {0.27, 0.27, 0.05},
          makePlain(kDark), 0.8);
  return m.box("handle", {0.21, 0, 0.04}, {0.18, 0.025, 0.02},
               makePlain(Color(0.25F, 0.2F, 0.17F)));
}

Model makePlate(Random&) {
  Model m("plate", "white");
  m.cylinder("plate", {0, 0, 0.008}, 0.12, 0.016, makePlain(kWhite));
  return m.cylinder("food", {0, 0, 0.022}, 0.06, 0.012, makePlain(Color(0.75F, 0.55F, 0.25F)), 0.7);
}

Model makeVase(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("vase with flowers", c.name);
  m.ellipsoid("vase", {0, 0, 0.09}, {0.14, 0.14, 0.18}, makePlain(c.rgb));
  m.cylinder("vase", {0, 0, 0.18}, 0.035, 0.06, makePlain(c.rgb));
  const Color bloom = pickColor(random).rgb;
  m.cylinder("stem", {0, 0, 0.26}, 0.008, 0.12, makePlain(Color(0.2F, 0.4F, 0.15F)));
  m.ellipsoid("flower", {0, 0, 0.34}, {0.1, 0.1, 0.08}, makePlain(bloom));
  m.ellipsoid("flower", {0.05, 0.02, 0.31}, {0.08, 0.08, 0.07}, makePlain(bloom * 1.2F));
  return m.ellipsoid("flower", {-0.05, -0.02, 0.31}, {0.08, 0.08, 0.07}, makePlain(bloom * 0.8F));
}

Model makeMagazine(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("magazine", c.name);
  m.box("cover", {0, 0, 0.003}, {0.21, 0.28, 0.006}, makePlain(c.rgb));
  return m.box("picture", {0, -0.03, 0.0065}, {0.16, 0.14, 0.001}, makePlain(kWhite));
}

Model makeRemote(Random&) {
  Model m("remote control", "black");
  m.box("case", {0, 0, 0.01}, {0.05, 0.19, 0.02}, makePlain(kDark));
  return m.box("buttons", {0, 0.02, 0.0205}, {0.03, 0.11, 0.002},
               makePlain(Color(0.6F, 0.6F, 0.62F)));
}

Model makeClock(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("alarm clock", c.name);
  m.box("case", {0, 0, 0.055}, {0.14, 0.06, 0.11}, makePlain(c.rgb));
  return m.box("face", {0, -0.031, 0.055}, {0.1, 0.004, 0.07},
               makeGlowing(Color(0.9F, 0.95F, 0.9F), 0.4F));
}

Model makeBall(Random& random) {
  const NamedColor c = pickColor(random);
  Material stripes = makePlain(c.rgb);
  stripes.pattern = Pattern::kStripes;
  stripes.second = kWhite;
  stripes.scale_m = 0.06F;
  return Model("football", c.name).ellipsoid("ball", {0, 0, 0.11}, {0.22, 0.22, 0.22}, stripes);
}

Model makeCup(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("toothbrush", c.name);
  m.cylinder("cup", {0, 0, 0.05}, 0.035, 0.1, makePlain(kWhite));
  return m.box("brush", {0.015, 0, 0.14}, {0.012, 0.012, 0.1}, makePlain(c.rgb));
}

Model makeSoap(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("soap dispenser", c.name);
  m.cylinder("body", {0, 0, 0.07}, 0.035, 0.14, makePlain(c.rgb));
  m.cylinder("pump", {0, 0, 0.16}, 0.01, 0.04, makePlain(kWhite));
  return m.box("pump", {0, -0.015, 0.18}, {0.016, 0.05, 0.012}, makePlain(kWhite));
}

Model makeTowels(Random& random) {
  const NamedColor c = pickColor(random);
  Model m("folded towels", c.name);
  m.box("towel", {0, 0, 0.03}, {0.36, 0.26, 0.06}, makeFabric(c.rgb));
  return m.box("towel", {0, 0, 0.09}, {0.35, 0.25, 0.058}, makeFabric(c.rgb * 0.85F));
}

Model makeCarton(Random& random) {
  const double width_m = random.uniform(0.25, 0.38);
  const double height_m = random.uniform(0.2, 0.3);
  Model m("cardboard box", "brown");
  const Color card(0.68F, 0.52F, 0.34F);
  m.box("box", {0, 0, 0.5 * height_m}, {width_m, 0.3, height_m}, makePlain(card));
  return m.box("tape", {0, 0, height_m + 0.0005}, {width_m, 0.05, 0.001}, makePlain(card * 0.75F));
}

Model makeToolbox(Random&) {
  Model m("toolbox", "red");
  m.box("case", {0, 0, 0.09}, {0.42, 0.2, 0.18}, makePlain(Color(0.75F, 0.14F, 0.1F)));
  m.box("latch", {0, -0.105, 0.13}, {0.06, 0.01, 0.05}, makePlain(kSteel));
  return m.box("handle", {0, 0, 0.2}, {0.2, 0.03, 0.04}, makePlain(kDark));
}

Model makePrinter(Random&) {
  Model m("printer", "white");
  m.box("body", {0, 0.02, 0.1}, {0.42, 0.34, 0.2}, makePlain(kWhite));
  m.box("slot", {0, -0.155, 0.1}, {0.32, 0.01, 0.05}, makePlain(kDark));
  m.box("paper", {0, -0.19, 0.07}, {0.22, 0.08, 0.012}, makePlain(Color(1.0F, 1.0F, 1.0F)));
  return m.box("scanner lid", {0, 0.02, 0.215}, {0.4, 0.32, 0.03},
               makePlain(Color(0.4F, 0.42F, 0.44F)));
}

Model makeBlocks(Random& random) {
  Model m("toy blocks", "colourful");
  for (const double x : {-0.07, 0.0, 0.07}) {
    m.box("block", {x, 0, 0.03}, {0.06, 0.06, 0.06}, makePlain(pickColor(random).rgb));
  }
  return m.box("block", {-0.03, 0, 0.09}, {0.06, 0.06, 0.06}, makePlain(pickColor(random).rgb));
}

using Maker = Model (*)(Random&);

const std::map<std::string, Maker>& makers() {
  static const std::map<std::string, Maker> kMakers = {
      {"mug", makeMug},
      {"bottle", makeBottle},
      {"book", makeBook},
      {"books", makeBooks},
      {"laptop", makeLaptop},
      {"monitor", makeMonitor},
      {"keyboard", makeKeyboard},
      {"teddy", makeTeddyBear},
      {"backpack", makeBackpack},
      {"shoes", makeShoes},
      {"fruit", makeFruitBowl},
      {"kettle", makeKettle},
      {"toaster", makeToaster},
      {"microwave", makeMicrowave},
      {"pan", makePan},
      {"plate", makePlate},
      {"vase", makeVase},
      {"magazine", makeMagazine},
      {"remote", makeRemote},
      {"clock", makeClock},
      {"ball", makeBall},
      {"toothbrush", makeCup},
      {"soap", makeSoap},
      {"towels", makeTowels},
      {"carton", makeCarton},
      {"toolbox", makeToolbox},
      {"printer", makePrinter},
      {"blocks", makeBlocks},
      {"desk lamp", [](Random& r) { return makeLamp("desk lamp", r, 0.42); }},
      {"bedside lamp", [](Random& r) { return makeLamp("bedside lamp", r, 0.36); }}};
  return kMakers;
}

}  // namespace

Model makeSmallThing(const std::string& name, Random& random) {
  if (name == "television") return makeTelevision();
  const auto found = makers().find(name);
  if (found == makers().end()) {
    throw std::invalid_argument("small thing '" + name + "', expected one of smallThings()");
  }
  return found->second(random);
}

const std::vector<std::string>& smallThings() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names = {"television"};
    for (const auto& entry : makers()) names.push_back(entry.first);
    return names;
  }();
  return kNames;
}

}  // namespace tsg::simulation::catalogue
