// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/apartment.h"

#include <gtest/gtest.h>

#include <set>

#include "simulation_oracles.h"
#include "task_scene_graph/config/config.h"

namespace tsg::simulation {
namespace {

class Apartments : public ::testing::TestWithParam<std::pair<int, int>> {
 protected:
  Apartment apartment_ = buildApartment({GetParam().first, GetParam().second});
};

TEST_P(Apartments, HaveTheAskedNumberOfRoomsWithFurnitureInEach) {
  EXPECT_EQ(apartment_.rooms.size(), static_cast<std::size_t>(GetParam().second));
  for (const Room& room : apartment_.rooms) {
    int things = 0;
    for (const Instance& instance : apartment_.instances)
      things += instance.room == room.id ? 1 : 0;
    EXPECT_GE(things, 4) << room.phrase;
  }
}

TEST_P(Apartments, NoSolidReachesIntoAnotherInstanceOrTheStructure) {
  EXPECT_EQ(test::findIntrusion(apartment_), "");
}

TEST_P(Apartments, BoxesHoldTheSurfacesOfTheirInstances) {
  for (const Solid& solid : apartment_.solids) {
    if (solid.instance == 0) continue;
    const Instance& instance = apartment_.instances.at(solid.instance - 1U);
    const Pose T_instance_world = instance.T_world_instance.inverse();
    for (const Eigen::Vector3d& p : test::sampleSurface(solid, 6)) {
      ASSERT_LT(instance.box.exteriorDistance(p), 1e-9) << instance.phrase;
      ASSERT_LT(instance.local_box.exteriorDistance(T_instance_world * p), 1e-9);
    }
  }
}

TEST_P(Apartments, ThingsStandInTheirRoomOnSomethingOrHang) {
  for (const Instance& instance : apartment_.instances) {
    const Room& room = apartment_.rooms.at(static_cast<std::size_t>(instance.room - 1));
    EXPECT_TRUE(
        room.interior_m.contains(Rect(instance.box.min().head<2>(), instance.box.max().head<2>())))
        << instance.phrase;
    EXPECT_GE(instance.box.min().z(), -1e-9) << instance.phrase;
    EXPECT_LE(instance.box.max().z(), room.height_m + 1e-9) << instance.phrase;
  }
}

TEST_P(Apartments, DoorwaysAreOpenAndWide) {
  for (const Doorway& door : apartment_.doorways) {
    EXPECT_GE(door.width_m, 0.9 - 1e-9);
    for (double across = -0.44; across <= 0.44; across += 0.04) {
      for (double through = -0.3; through <= 0.3; through += 0.05) {
        for (double z = 0.06; z < 2.0; z += 0.2) {
          const Eigen::Vector2d offset = door.leads_along_y ? Eigen::Vector2d(across, through)
                                                            : Eigen::Vector2d(through, across);
          const Eigen::Vector2d xy = door.center_m + offset;
          const Eigen::Vector3d p(xy.x(), xy.y(), z);
          for (const Solid& solid : apartment_.solids) ASSERT_FALSE(isInside(solid, p));
        }
      }
    }
  }
}

TEST_P(Apartments, PartsAndInstancesAreNumberedAsTheSolidsSay) {
  std::set<std::uint16_t> used;
  for (const Solid& solid : apartment_.solids) {
    if (solid.instance == 0) {
      EXPECT_EQ(solid.part, 0);
      continue;
    }
    EXPECT_EQ(apartment_.parts.at(solid.part - 1U).instance, solid.instance);
    used.insert(solid.part);
  }
  EXPECT_EQ(used.size(), apartment_.parts.size());
  for (std::size_t i = 0; i < apartment_.instances.size(); ++i) {
    EXPECT_EQ(apartment_.instances[i].id, i + 1);
  }
}

INSTANTIATE_TEST_SUITE_P(SeedsAndSizes, Apartments,
                         ::testing::Values(std::pair(1, 6), std::pair(2, 3), std::pair(3, 8),
                                           std::pair(4, 7), std::pair(5, 5)));

bool isSame(const Apartment& a, const Apartment& b) {
  if (a.solids.size() != b.solids.size()) return false;
  for (std::size_t i = 0; i < a.solids.size(); ++i) {
    if (a.solids[i].instance != b.solids[i].instance ||
        !(a.solids[i].T_world_solid.matrix() == b.solids[i].T_world_solid.matrix()) ||
        a.solids[i].material.color != b.solids[i].material.color) {
      return false;
    }
  }
  return true;
}

TEST(Apartment, FollowsFromTheSeed) {
  EXPECT_TRUE(isSame(buildApartment({8, 6}), buildApartment({8, 6})));
  EXPECT_FALSE(isSame(buildApartment({8, 6}), buildApartment({9, 6})));
}

TEST(Apartment, RoomsWithoutTheirMainFurnitureAreRare) {
  int missing = 0;
  for (int seed = 0; seed < 20; ++seed) {
    const Apartment apartment = buildApartment({seed, 6});
    for (const char* phrase : {"sofa", "bed", "stove", "toilet", "desk", "dining table"}) {
      bool found = false;
      for (const Instance& instance : apartment.instances) found |= instance.phrase == phrase;
      missing += found ? 0 : 1;
    }
  }
  EXPECT_LE(missing, 2);
}

TEST(Apartment, RefusesRoomNumbersOutOfRange) {
  EXPECT_THROW(buildApartment({1, 2}), config::ConfigError);
  EXPECT_THROW(buildApartment({1, 9}), config::ConfigError);
}

}  // namespace
}  // namespace tsg::simulation
