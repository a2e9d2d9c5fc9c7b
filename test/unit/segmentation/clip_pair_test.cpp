// SPDX-License-Identifier: BSD-3-Clause
// One photograph with FastSAM's masks and CLIP's features of them, and CLIP's vectors of names, as
// other programs stored them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "numpy_file.h"
#include "support.h"
#include "task_scene_graph/segmentation/image_encoder.h"
#include "task_scene_graph/segmentation/label_painter.h"

namespace tsg::segmentation {
namespace {

namespace fs = std::filesystem;

struct ReferenceMasks {
  std::vector<cv::Mat> full;       ///< CV_8UC1, 255 inside
  std::vector<cv::Rect> boxes_px;  ///< the network's, about the masks
};

ReferenceMasks readMasks(const fs::path& path) {
  const auto arrays = test::readNpz(path);
  const test::NumpyArray& masks = arrays.at("masks");
  const test::NumpyArray& boxes = arrays.at("bboxes");
  EXPECT_EQ(masks.type, "|b1");
  EXPECT_EQ(boxes.type, "<i4");
  const cv::Size size(static_cast<int>(masks.shape.at(2)), static_cast<int>(masks.shape.at(1)));
  const auto* corners = reinterpret_cast<const std::int32_t*>(boxes.bytes.data());
  ReferenceMasks reference;
  for (std::size_t i = 0; i < masks.shape.at(0); ++i) {
    const std::uint8_t* pixels = masks.bytes.data() + i * static_cast<std::size_t>(size.area());
    reference.full.push_back(cv::Mat(size, CV_8UC1, const_cast<std::uint8_t*>(pixels)) != 0);
    const std::int32_t* c = corners + 4 * i;
    reference.boxes_px.emplace_back(cv::Point(c[0], c[1]), cv::Point(c[2], c[3]));
  }
  return reference;
}

std::vector<SegmentMask> toSegmentMasks(const ReferenceMasks& reference) {
  std::vector<SegmentMask> masks;
  for (const cv::Mat& full : reference.full) {
    const cv::Rect box = cv::boundingRect(full);
    masks.push_back({box, full(box) / 255, cv::countNonZero(full), 0.9F});
  }
  return masks;
}

/// What the masks imply, pixel by pixel: the smallest one that covers it.
cv::Mat paintByHand(const ReferenceMasks& reference) {
  std::vector<std::size_t> order(reference.full.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return cv::countNonZero(reference.full[a]) > cv::countNonZero(reference.full[b]);
  });
  cv::Mat owners = cv::Mat::zeros(reference.full[0].size(), CV_16UC1);
  for (const std::size_t i : order) owners.setTo(static_cast<double>(i + 1), reference.full[i]);
  return owners;
}

TEST(ReferenceMasksOfFastSam, ArePaintedSmallestFirstAndOpened) {
  TSG_REQUIRE_SHARED(path, "data/clip/test_pair_000.npz");
  const ReferenceMasks reference = readMasks(path);
  ASSERT_EQ(reference.full.size(), 23U);
  const cv::Mat owners = paintByHand(reference);
  const cv::Size size = owners.size();
  const auto masks = toSegmentMasks(reference);
  const LabelledSegments raw = paintLabels(masks, size, false, 1);
  EXPECT_EQ(cv::norm(raw.labels, owners, cv::NORM_INF), 0.0);
  const LabelledSegments refined = paintLabels(masks, size, true, 1);
  int overlapping_px = 0;
  int label = 0;  // what opening removes has none
  for (int i = 0; i < 23; ++i) {
    cv::Mat own = owners == i + 1;
    overlapping_px += masks[static_cast<std::size_t>(i)].area_px - cv::countNonZero(own);
    cv::copyMakeBorder(own, own, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::morphologyEx(own, own, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8UC1));
    own = own(cv::Rect({1, 1}, size));
    if (cv::countNonZero(own) == 0) continue;
    ++label;
    EXPECT_EQ(cv::norm(refined.labels == label, own, cv::NORM_INF), 0.0) << i;
  }
  EXPECT_EQ(refined.scores.size(), static_cast<std::size_t>(label));
  EXPECT_GE(label, 22);
  EXPECT_GT(overlapping_px, 15000);  // so that who wins matters
}

TEST(ReferenceMasksOfFastSam, BoxesAreThoseOfTheNetwork) {
  TSG_REQUIRE_SHARED(path, "data/clip/test_pair_000.npz");
  const ReferenceMasks reference = readMasks(path);
  const auto masks = toSegmentMasks(reference);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    const LabelledSegments alone = paintLabels({masks[i]}, reference.full[0].size(), false, 1);
    const cv::Rect& box = alone.boxes_px.at(0);
    const cv::Rect& expected = reference.boxes_px[i];
    EXPECT_EQ(alone.areas_px.at(0), masks[i].area_px);
    EXPECT_NEAR(box.x, expected.x, 1) << i;
    EXPECT_NEAR(box.y, expected.y, 1) << i;
    EXPECT_NEAR(box.br().x, expected.br().x, 3) << i;
    EXPECT_NEAR(box.br().y, expected.br().y, 3) << i;
  }
}

double computeGreatestCosine(const EmbeddingMatrix& rows) {
  EmbeddingMatrix cosines = rows * rows.transpose();
  cosines.diagonal().setConstant(-1.0F);
  return static_cast<double>(cosines.maxCoeff());
}

TEST(StoredClipVectors, FeaturesOfDifferentMasksAreAlikeButNotTheSame) {
  TSG_REQUIRE_SHARED(path, "data/clip/test_pair_000.npz");
  const EmbeddingMatrix features = test::toUnitRows(test::readNpz(path).at("features"));
  ASSERT_EQ(features.rows(), 23);
  ASSERT_EQ(features.cols(), 768);
  const EmbeddingMatrix cosines = features * features.transpose();
  EXPECT_GT(cosines.minCoeff(), 0.5F);
  EXPECT_LT(computeGreatestCosine(features), 0.98);
}

struct NamedVectors {
  std::vector<std::string> names;
  EmbeddingMatrix rows;
};

NamedVectors readVectors(const fs::path& folder, const std::string& stem) {
  std::ifstream file(folder / (stem + ".names.json"));
  return {nlohmann::json::parse(file).get<std::vector<std::string>>(),
          test::toUnitRows(test::readNpy(folder / (stem + ".npy")))};
}

TEST(StoredClipVectors, TextsOfTheSameNameAreEqualAndOfOthersLessThan097Alike) {
  TSG_REQUIRE_SHARED(folder, "data/clip");
  const NamedVectors coco = readVectors(folder, "coco_clip_a+cname");
  const NamedVectors lvis = readVectors(folder, "lvis_v1_clip_a+cname");
  ASSERT_EQ(coco.rows.rows(), static_cast<Eigen::Index>(coco.names.size()));
  ASSERT_EQ(lvis.rows.rows(), 1203);
  EXPECT_LT(computeGreatestCosine(coco.rows), 0.97);
  EXPECT_LT(computeGreatestCosine(lvis.rows), 0.97);
  int common = 0;
  for (std::size_t i = 0; i < coco.names.size(); ++i) {
    const auto found = std::find(lvis.names.begin(), lvis.names.end(), coco.names[i]);
    if (found == lvis.names.end()) continue;
    ++common;
    Eigen::Index nearest = 0;
    const float cosine =
        (lvis.rows * coco.rows.row(static_cast<Eigen::Index>(i)).transpose()).maxCoeff(&nearest);
    EXPECT_EQ(nearest, found - lvis.names.begin()) << coco.names[i];
    EXPECT_GT(cosine, 0.999F);
  }
  EXPECT_EQ(common, 51);
}

}  // namespace
}  // namespace tsg::segmentation
