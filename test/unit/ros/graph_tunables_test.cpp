// SPDX-License-Identifier: BSD-3-Clause
#include "nodelets/graph_tunables.h"

#include <gtest/gtest.h>

#include <string>

namespace tsg::nodelets {
namespace {

TEST(GraphTunables, DefaultsAreThoseOfTheStructs) {
  dynamic_reconfigure::Config made, expected;
  toTunables({}).__toMessage__(made);
  Tunables::__getDefault__().__toMessage__(expected);
  ASSERT_EQ(made.strs.size(), expected.strs.size());
  for (std::size_t i = 0; i < made.strs.size(); ++i) {
    EXPECT_EQ(made.strs[i].value, expected.strs[i].value) << made.strs[i].name;
  }
  ASSERT_EQ(made.doubles.size(), expected.doubles.size());
  for (std::size_t i = 0; i < made.doubles.size(); ++i) {
    EXPECT_EQ(made.doubles[i].value, expected.doubles[i].value) << made.doubles[i].name;
  }
}

TEST(GraphTunables, ThereAndBackIsTheSame) {
  TunedConfig config;
  config.graph.object_alpha = 0.5;
  config.graph.place_top_k = 7;
  config.graph.object_normaliser = bottleneck::Normaliser::kSizeInvariant;
  config.graph.place_normaliser = bottleneck::Normaliser::kPaper;
  config.graph.prior = bottleneck::Prior::kMarginal;
  config.graph.region_method = scene_graph::RegionMethod::kGeometric;
  config.graph.num_threads = 3;
  config.markers.text_height_m = 0.5;
  config.markers.label_distance_m = 0.25;
  TunedConfig base;
  base.graph.num_threads = 3;
  const TunedConfig back = fromTunables(toTunables(config), base, "test");
  const auto before = config::listSettings(config.graph, {});
  const auto after = config::listSettings(back.graph, {});
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].value, before[i].value) << before[i].name;
  }
  EXPECT_TRUE(back.markers == config.markers);
}

TEST(GraphTunables, AChoiceThatIsNoneIsRefusedByName) {
  Tunables tunables = toTunables({});
  tunables.place_normaliser = "largest";
  try {
    fromTunables(tunables, {}, "test");
    FAIL() << "accepted";
  } catch (const config::ConfigError& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("place_normaliser"), std::string::npos) << text;
    EXPECT_NE(text.find("size_invariant"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace tsg::nodelets
