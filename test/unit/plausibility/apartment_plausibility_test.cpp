// SPDX-License-Identifier: BSD-3-Clause
// Generated apartments with the depth of an active stereo camera. The table that is printed is the
// result: of 3 s at a time, in how many the fault was named, something else was, or nothing.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <set>

#include "rgbd_faults.h"
#include "task_scene_graph/plausibility/input_plausibility.h"

namespace tsg::plausibility {
namespace {

using test::RgbdWalk;
constexpr std::size_t kWindow = 30;  // frames, 3 s

struct Fault {
  std::string name;
  std::set<std::string> checks;  ///< keys that name it; none for clean input
  double least_share;            ///< of windows in which it is named
  std::function<RgbdWalk(const RgbdWalk&)> inject;
};

const std::vector<Fault>& faults() {
  static const std::vector<Fault> list{
      {"clean", {}, 0.0, [](const RgbdWalk& w) { return w; }},
      {"world to camera", {"pose direction"}, 0.9, test::withInversePoses},
      {"OpenGL axes", {"camera axes"}, 0.9, test::withOpenglAxes},
      {"body axes", {"camera axes"}, 0.9, test::withBodyAxes},
      {"left-handed world", {"camera axes"}, 0.8, test::withMirroredWorld},
      {"poses in mm",
       {"pose scale"},
       0.4,
       [](const RgbdWalk& w) { return test::withTranslationsTimes(w, 1000.0); }},
      {"depth x 0.2",
       {"depth scale"},
       0.4,
       [](const RgbdWalk& w) { return test::withDepthTimes(w, 0.2); }},
      {"depth x 0.25",
       {"depth scale"},
       0.4,
       [](const RgbdWalk& w) { return test::withDepthTimes(w, 0.25); }},
      {"depth x 4",
       {"depth scale", "depth range"},
       0.9,
       [](const RgbdWalk& w) { return test::withDepthTimes(w, 4.0); }},
      {"depth x 10",
       {"depth scale", "depth range"},
       1.0,
       [](const RgbdWalk& w) { return test::withDepthTimes(w, 10.0); }},
      {"depth x 1000",
       {"depth scale", "depth range"},
       1.0,
       [](const RgbdWalk& w) { return test::withDepthTimes(w, 1000.0); }},
      {"depth x 0.001",
       {"depth scale", "depth range"},
       1.0,
       [](const RgbdWalk& w) { return test::withDepthTimes(w, 0.001); }},
      {"focal length x 0.6",
       {"intrinsics"},
       0.8,
       [](const RgbdWalk& w) { return test::withFocalLengthTimes(w, 0.6); }},
      {"focal length x 1.6",
       {"intrinsics"},
       0.8,
       [](const RgbdWalk& w) { return test::withFocalLengthTimes(w, 1.6); }},
      {"distance along rays", {"ray distance"}, 0.8, test::withRayDistances},
      {"poses 0.3 s late",
       {"pose delay"},
       0.0,
       [](const RgbdWalk& w) { return test::withLatePoses(w, 3); }},
      {"pose noise 3 cm", {"pose jitter"}, 0.0, [](const RgbdWalk& w) {
         return test::withPoseNoise(w, 0.03, 1);
       }}};
  return list;
}

/// Stretches of 100 frames of six walks; rendered once.
const std::vector<RgbdWalk>& walks() {
  static const std::vector<RgbdWalk> list = [] {
    std::vector<RgbdWalk> made;
    for (int seed = 1; seed <= 6; ++seed) {
      made.push_back(test::makeApartmentWalk(seed, 160, 60 * seed, 120));
    }
    return made;
  }();
  return list;
}

std::vector<Finding> report(const RgbdWalk& walk) {
  InputPlausibility plausibility;
  for (const RgbdFrame& frame : walk) plausibility.addFrame(frame);
  return plausibility.findings();
}

std::string toLines(const std::vector<Finding>& findings) {
  std::string lines;
  for (const Finding& finding : findings) lines += "\n  " + toText(finding);
  return lines;
}

struct Rates {
  int windows = 0;
  int named = 0;
  int misnamed = 0;
};

Rates measure(const Fault& fault) {
  Rates rates;
  for (const RgbdWalk& clean : walks()) {
    const RgbdWalk walk = fault.inject(clean);
    for (std::size_t first = 0; first + kWindow <= walk.size(); first += kWindow) {
      const auto findings = report(test::cut(walk, first, kWindow));
      ++rates.windows;
      bool is_named = false;
      bool is_misnamed = false;
      for (const Finding& finding : findings) {
        const bool is_right = fault.checks.count(finding.check) > 0;
        is_named |= is_right;
        is_misnamed |= !is_right;
      }
      rates.named += is_named ? 1 : 0;
      rates.misnamed += is_misnamed ? 1 : 0;
    }
  }
  return rates;
}

class ThreeSeconds : public ::testing::TestWithParam<std::size_t> {};

TEST_P(ThreeSeconds, NameTheFaultOrNothing) {
  const Fault& fault = faults()[GetParam()];
  const Rates rates = measure(fault);
  std::printf("%-20s  named %3d, other %2d, silent %2d of %d\n", fault.name.c_str(), rates.named,
              rates.misnamed, rates.windows - rates.named - rates.misnamed, rates.windows);
  EXPECT_GE(rates.windows, 18);
  EXPECT_GE(rates.named, fault.least_share * rates.windows);
  EXPECT_LE(rates.misnamed, fault.name == "pose noise 3 cm" ? 2 : 0);
}

INSTANTIATE_TEST_SUITE_P(Apartments, ThreeSeconds,
                         ::testing::Range(std::size_t{0}, faults().size()));

TEST(Apartments, WholeWalksNameEveryFault) {
  const std::set<std::string> unseen{"clean", "poses 0.3 s late", "pose noise 3 cm"};
  for (const Fault& fault : faults()) {
    if (unseen.count(fault.name) > 0) continue;
    for (const RgbdWalk& clean : walks()) {
      const auto findings = report(fault.inject(clean));
      ASSERT_EQ(findings.size(), 1U) << fault.name << toLines(findings);
      EXPECT_EQ(fault.checks.count(findings[0].check), 1U) << fault.name << toLines(findings);
    }
  }
}

TEST(Apartments, WholeWalksAreSilent) {
  for (const RgbdWalk& walk : walks()) {
    EXPECT_TRUE(report(walk).empty()) << toLines(report(walk));
  }
}

TEST(Apartments, ImagesOf640PixelsAreSilentAndFaultsInThemNamed) {
  for (const int seed : {7, 8}) {
    const RgbdWalk walk = test::makeApartmentWalk(seed, 640, 40, 30);
    EXPECT_TRUE(report(walk).empty()) << toLines(report(walk));
    EXPECT_TRUE(hasFinding(report(test::withBodyAxes(walk)), "camera axes"));
    EXPECT_TRUE(hasFinding(report(test::withInversePoses(walk)), "pose direction"));
    EXPECT_TRUE(hasFinding(report(test::withDepthTimes(walk, 10.0)), "depth scale") ||
                hasFinding(report(test::withDepthTimes(walk, 10.0)), "depth range"));
  }
}

}  // namespace
}  // namespace tsg::plausibility
