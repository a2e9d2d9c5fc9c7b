// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/object_truth.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support.h"

namespace tsg::evaluation {
namespace {

class ObjectTruth : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const auto path = folder_.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }

  std::string findError(const std::string& text) {
    const std::string path = write("tasks.yaml", text);
    try {
      loadObjectTruth(path, TruthExtent::kSeen);
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
      return e.what();
    }
    return "";
  }

  test::TemporaryFolder folder_;
};

TEST_F(ObjectTruth, ReadsClioYaml) {
  const auto truth = loadObjectTruth(write("tasks.yaml", R"(
get the stapler:
  - {center: [1, 2, 3], extents: [0.1, 0.2, 0.3], rotation: {w: 0, x: 0, y: 0, z: 2}}
  - {center: [4, 5, 6], extents: [1, 1, 1], rotation: [1, 0, 0, 0]}
get picture of boat: []
)"),
                                     TruthExtent::kSeen);
  ASSERT_EQ(truth.size(), 2U);
  EXPECT_EQ(truth[0].task, "get the stapler");
  ASSERT_EQ(truth[0].boxes.size(), 2U);
  EXPECT_TRUE(truth[0].boxes[0].center_m.isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(truth[0].boxes[0].size_m.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_TRUE(
      truth[0].boxes[0].rotation.isApprox(Eigen::Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix()));
  EXPECT_TRUE(truth[0].boxes[1].rotation.isIdentity());
  EXPECT_TRUE(truth[1].boxes.empty());
}

TEST_F(ObjectTruth, FolderOfAnApartmentHasTasksYaml) {
  write("tasks.yaml", "sit: [{center: [0, 0, 0], extents: [1, 1, 1]}]\n");
  EXPECT_EQ(loadObjectTruth(folder_.path().string(), TruthExtent::kSeen).size(), 1U);
}

TEST_F(ObjectTruth, HouseKnowsWhatWasSeen) {
  write("tasks.json", R"([{"name": "chair", "instances": [1, 2], "seen": [2]}])");
  write("instances.json",
        R"([{"id": 1, "aabb_min": [0, 0, 0], "aabb_max": [1, 1, 1]},
            {"id": 2, "aabb_min": [2, 0, 0], "aabb_max": [3, 2, 1]}])");
  const auto seen = loadObjectTruth(folder_.path().string(), TruthExtent::kSeen);
  ASSERT_EQ(seen.at(0).boxes.size(), 1U);
  EXPECT_TRUE(seen[0].boxes[0].center_m.isApprox(Eigen::Vector3d(2.5, 1, 0.5)));
  EXPECT_TRUE(seen[0].boxes[0].size_m.isApprox(Eigen::Vector3d(1, 2, 1)));
  const auto all = loadObjectTruth(folder_.path().string(), TruthExtent::kAll);
  EXPECT_EQ(all.at(0).boxes.size(), 2U);
}

TEST_F(ObjectTruth, FaultsNameFileTaskAndValue) {
  EXPECT_NE(findError("sit: 3\n").find("task 'sit' has 3"), std::string::npos);
  EXPECT_NE(findError("sit: [{center: [0, 0], extents: [1, 1, 1]}]\n").find("'center' = [0, 0]"),
            std::string::npos);
  EXPECT_NE(findError("sit: [{center: [0, 0, .nan], extents: [1, 1, 1]}]\n").find(".nan"),
            std::string::npos);
  EXPECT_NE(findError("sit: [{center: [0, 0, 0], extents: [1, -1, 1]}]\n").find("[1, -1, 1]"),
            std::string::npos);
  EXPECT_NE(findError("sit: [{center: [0, 0, 0], extents: [1, 1, 1], rotation: [0, 0, 0, 0]}]\n")
                .find("rotation"),
            std::string::npos);
  EXPECT_NE(findError("[a, b]\n").find("no map"), std::string::npos);
  EXPECT_NE(findError("sit: []\nsit: []\n").find("twice"), std::string::npos);
}

TEST_F(ObjectTruth, FolderWithoutTasksIsRefused) {
  EXPECT_THROW(loadObjectTruth(folder_.path().string(), TruthExtent::kSeen), std::runtime_error);
  EXPECT_THROW(loadObjectTruth((folder_.path() / "absent.yaml").string(), TruthExtent::kSeen),
               std::runtime_error);
}

}  // namespace
}  // namespace tsg::evaluation
