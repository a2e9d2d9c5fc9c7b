// SPDX-License-Identifier: BSD-3-Clause
#include "catalogue.h"

namespace tsg::simulation::catalogue {
namespace {

const NamedColor kRed{"red", Color(0.72F, 0.16F, 0.14F)};
const NamedColor kGreen{"green", Color(0.18F, 0.5F, 0.25F)};
const NamedColor kBlue{"blue", Color(0.17F, 0.3F, 0.62F)};
const NamedColor kYellow{"yellow", Color(0.88F, 0.74F, 0.2F)};
const NamedColor kOrange{"orange", Color(0.88F, 0.48F, 0.14F)};
const NamedColor kWhite{"white", Color(0.93F, 0.93F, 0.91F)};
const NamedColor kBlack{"black", Color(0.12F, 0.12F, 0.13F)};
const NamedColor kBrown{"brown", Color(0.5F, 0.34F, 0.2F)};
const NamedColor kBeige{"beige", Color(0.8F, 0.7F, 0.55F)};
const NamedColor kGrey{"grey", Color(0.55F, 0.57F, 0.6F)};

constexpr Shape kBox = Shape::kBox;
constexpr Shape kCan = Shape::kFrustum;

ThingSet makeBookStack() {
  return {"stack of books",
          "move the stacks of books",
          Layout::kStack,
          false,
          {{"green book", "get the green book", kGreen, kBox, {0.2, 0.27, 0.06}},
           {"red book", nullptr, kRed, kBox, {0.19, 0.26, 0.05}},
           {"blue book", nullptr, kBlue, kBox, {0.18, 0.25, 0.065}},
           {"yellow book", "get the yellow book", kYellow, kBox, {0.17, 0.23, 0.055}}}};
}

ThingSet makePacketPile() {
  return {"pile of packets",
          "clear away the packets",
          Layout::kPile,
          false,
          {{"coffee packet", "get the coffee packet", kBrown, kBox, {0.15, 0.11, 0.12}},
           {"rice packet", "get the rice packet", kWhite, kBox, {0.15, 0.11, 0.12}},
           {"tea packet", nullptr, kGreen, kBox, {0.15, 0.11, 0.12}},
           {"sugar packet", nullptr, kBlue, kBox, {0.15, 0.11, 0.1}},
           {"flour packet", "get the flour packet", kBeige, kBox, {0.15, 0.11, 0.1}}}};
}

ThingSet makeNotebookSet() {
  return {"set of notebooks",
          "hand out the notebooks",
          Layout::kRow,
          false,
          {{"lined notebook", nullptr, kGrey, kBox, {0.16, 0.22, 0.04}},
           {"squared notebook", "get the squared notebook", kRed, kBox, {0.16, 0.22, 0.04}},
           {"sketch notebook", "get the sketch notebook", kBlack, kBox, {0.16, 0.22, 0.04}}}};
}

ThingSet makeBinderRow() {
  return {"row of binders",
          "carry the binders to the archive",
          Layout::kRow,
          false,
          {{"black binder", nullptr, kBlack, kBox, {0.08, 0.28, 0.31}},
           {"white binder", "open the white binder", kWhite, kBox, {0.08, 0.28, 0.31}},
           {"orange binder", "open the orange binder", kOrange, kBox, {0.08, 0.28, 0.31}}}};
}

ThingSet makeJars() {
  return {"row of jars",
          "wash the jars",
          Layout::kRow,
          false,
          {{"honey jar", "get the honey jar", kYellow, kCan, {0.1, 0.1, 0.14}},
           {"jam jar", nullptr, kRed, kCan, {0.1, 0.1, 0.14}},
           {"mustard jar", "get the mustard jar", kOrange, kCan, {0.1, 0.1, 0.14}}}};
}

ThingSet makeTins() {
  return {"pile of tins",
          "put the tins on the shelf",
          Layout::kPile,
          false,
          {{"tomato tin", "get the tomato tin", kRed, kCan, {0.12, 0.12, 0.13}},
           {"bean tin", nullptr, kGreen, kCan, {0.12, 0.12, 0.13}},
           {"fish tin", "get the fish tin", kBlue, kCan, {0.12, 0.12, 0.11}}}};
}

ThingSet makeCrates() {
  return {"stack of crates",
          "move the crates to the cellar",
          Layout::kStack,
          true,
          {{"water crate", "open the water crate", kBlue, kBox, {0.45, 0.38, 0.3}},
           {"juice crate", nullptr, kOrange, kBox, {0.43, 0.36, 0.28}},
           {"milk crate", "open the milk crate", kWhite, kBox, {0.4, 0.34, 0.25}}}};
}

/// Where the members' bottoms are, from the middle of the lowest row.
std::vector<Eigen::Vector3d> layOut(Layout layout, const std::vector<Eigen::Vector3d>& sizes_m) {
  std::vector<Eigen::Vector3d> places_m;
  const std::size_t count = sizes_m.size();
  const std::size_t lower = layout == Layout::kPile ? (count + 1) / 2 : count;
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    if (layout == Layout::kStack) {
      places_m.push_back(at_m);
      at_m.z() += sizes_m[i].z();
    } else if (i < lower) {
      places_m.emplace_back(at_m.x() + 0.5 * sizes_m[i].x(), 0.0, 0.0);
      at_m.x() += sizes_m[i].x();
    } else {
      const Eigen::Vector3d& left_m = places_m[i - lower];
      const Eigen::Vector3d& right_m = places_m[i - lower + 1];
      places_m.emplace_back(0.5 * (left_m.x() + right_m.x()), 0.0, sizes_m.front().z());
    }
  }
  return places_m;
}

Model makeMember(const SetMember& member, const Eigen::Vector3d& size_m) {
  Model m(member.phrase, member.color.name);
  const Pose middle(Eigen::Translation3d(0.0, 0.0, 0.5 * size_m.z()));
  return m.solid(member.phrase, member.shape, middle, size_m, makePlain(member.color.rgb));
}

}  // namespace

const std::vector<ThingSet>& thingSets() {
  static const std::vector<ThingSet> kSets = {makeBookStack(), makePacketPile(), makeNotebookSet(),
                                              makeBinderRow(), makeJars(),       makeTins(),
                                              makeCrates()};
  return kSets;
}

Arrangement arrangeSet(const ThingSet& set, Random& random) {
  const double scale = random.uniform(0.96, 1.06);
  std::vector<Eigen::Vector3d> sizes_m;
  for (const SetMember& member : set.members) sizes_m.push_back(scale * member.size_m);
  const std::vector<Eigen::Vector3d> places_m = layOut(set.layout, sizes_m);
  Arrangement things;
  for (std::size_t i = 0; i < places_m.size(); ++i) {
    const Eigen::Vector3d offset_m = places_m[i] - places_m.front();
    things.push_back({makeMember(set.members[i], sizes_m[i]), makeQuarterTurn(0, offset_m)});
  }
  return things;
}

Model makeWorkTable(Random& random, double length_m) {
  const NamedColor wood = pickWoodColor(random);
  Model m("work table", wood.name);
  m.box("table top", {0, 0, 0.73}, {length_m, 0.7, 0.04}, makeWood(wood.rgb));
  for (const double x : {-0.5 * length_m + 0.05, 0.5 * length_m - 0.05}) {
    for (const double y : {-0.3, 0.3}) {
      m.box("leg", {x, y, 0.355}, {0.06, 0.06, 0.71}, makePlain(kGrey.rgb));
    }
  }
  const double reach_m = 0.5 * length_m - 0.03;
  return m.support(makeRect(-reach_m, -0.33, reach_m, 0.33), 0.75, 0.8)
      .needsFront(0.6)
      .seenInParts();
}

}  // namespace tsg::simulation::catalogue
