// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/segmenter.h"

#include <gtest/gtest.h>

#include <future>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "networks.h"
#include "task_scene_graph/config/config.h"

namespace tsg::segmentation {
namespace {

const cv::Rect kRedBox(8, 12, 24, 20);
const cv::Rect kGreenBox(40, 24, 12, 28);

/// Grey with a red and a green rectangle, which the small segmenter finds.
cv::Mat makeTwoRectangles() {
  cv::Mat image(64, 64, CV_8UC3, cv::Scalar(100, 100, 100));
  image(kRedBox) = cv::Scalar(255, 0, 0);
  image(kGreenBox) = cv::Scalar(0, 255, 0);
  return image;
}

ColorImage asRgb(const cv::Mat& image) { return {{}, image, ColorOrder::kRgb, nullptr}; }

void expectSameSegmentation(const Segmentation& a, const Segmentation& b) {
  EXPECT_EQ(cv::norm(a.labels, b.labels, cv::NORM_INF), 0.0);
  EXPECT_EQ(a.confidences, b.confidences);
  ASSERT_EQ(a.embeddings.rows(), b.embeddings.rows());
  ASSERT_EQ(a.image_embedding.size(), b.image_embedding.size());
  if (a.embeddings.size() > 0) {
    EXPECT_EQ((a.embeddings - b.embeddings).cwiseAbs().maxCoeff(), 0.0F);
  }
  if (a.image_embedding.size() > 0) {
    EXPECT_EQ((a.image_embedding - b.image_embedding).cwiseAbs().maxCoeff(), 0.0F);
  }
}

void expectRectangle(const cv::Mat& labels, int label, const cv::Rect& box) {
  const cv::Mat mask = labels == label;
  cv::Mat inner = cv::Mat::zeros(labels.size(), CV_8UC1);
  inner(cv::Rect(box.x + 1, box.y + 1, box.width - 2, box.height - 2)) = 255;
  cv::Mat outer = cv::Mat::zeros(labels.size(), CV_8UC1);
  outer(cv::Rect(box.x - 1, box.y - 1, box.width + 2, box.height + 2)) = 255;
  EXPECT_EQ(cv::countNonZero(inner & ~mask), 0) << "label " << label;
  EXPECT_EQ(cv::countNonZero(mask & ~outer), 0) << "label " << label;
}

TEST(Segmenter, FindsTheRectanglesNumberedByScore) {
  TSG_REQUIRE_ENGINE();
  Segmenter segmenter(makeSmallModels(), {});
  ColorImage color = asRgb(makeTwoRectangles());
  color.stamp = Stamp{123};
  const Segmentation result = segmenter.segment(color);
  result.validate();
  EXPECT_EQ(result.stamp, Stamp{123});
  ASSERT_EQ(result.confidences, (std::vector<float>{0.9F, 0.8F}));
  expectRectangle(result.labels, 1, kRedBox);
  expectRectangle(result.labels, 2, kGreenBox);
  EXPECT_EQ(segmenter.counters().images, 1U);
  EXPECT_EQ(segmenter.counters().images_without_segments, 0U);
}

TEST(Segmenter, FindsTheSameInALargerImageOfEitherColourOrder) {
  TSG_REQUIRE_ENGINE();
  cv::Mat large;
  cv::resize(makeTwoRectangles(), large, {256, 256}, 0, 0, cv::INTER_NEAREST);
  cv::Mat bgr;
  cv::cvtColor(large, bgr, cv::COLOR_RGB2BGR);
  Segmenter segmenter(makeSmallModels(), {});
  const Segmentation result = segmenter.segment(asRgb(large));
  ASSERT_EQ(result.numSegments(), 2U);
  cv::Mat small;
  cv::resize(result.labels, small, {64, 64}, 0, 0, cv::INTER_NEAREST);
  expectRectangle(small, 1, kRedBox);
  expectRectangle(small, 2, kGreenBox);
  expectSameSegmentation(result, segmenter.segment({{}, bgr, ColorOrder::kBgr, nullptr}));
}

/// The small encoder's closed form: weights * mean normalised colour + bias.
Eigen::Vector4f embedByHand(const cv::Mat& image, const cv::Mat& labels, const CropRequest& crop) {
  const cv::Scalar mean = cv::mean(cropToSquare(image, labels, crop, CropFit::kCenterCrop, 8));
  const ModelSet models = makeSmallModels();
  Eigen::Vector4f embedding(0.25F, 0.25F, 0.25F, 1.0F);
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const auto value =
        static_cast<float>((mean[c] / 255.0 - models.image_mean[i]) / models.image_std[i]);
    embedding[c] += value;
    embedding[3] += 0.5F * value;
  }
  return embedding;
}

TEST(Segmenter, ASegmentsEmbeddingIsTheUnitMeanOfCropAndMaskedCrop) {
  TSG_REQUIRE_ENGINE();
  const cv::Mat image = makeTwoRectangles();
  for (const bool plain : {true, false}) {
    for (const bool masked : {true, false}) {
      if (!plain && !masked) continue;
      SegmenterConfig config;
      config.embed_crop = plain;
      config.embed_masked_crop = masked;
      const Segmentation result = Segmenter(makeSmallModels(), config).segment(asRgb(image));
      ASSERT_EQ(result.numSegments(), 2U);
      for (int s = 0; s < 2; ++s) {
        cv::Rect box = cv::boundingRect(result.labels == s + 1);
        box =
            cv::Rect(box.x - 4, box.y - 4, box.width + 8, box.height + 8) & cv::Rect(0, 0, 64, 64);
        Eigen::Vector4f sum = Eigen::Vector4f::Zero();
        const auto label = static_cast<std::uint16_t>(s + 1);
        if (plain) sum += embedByHand(image, result.labels, {box, 0});
        if (masked) sum += embedByHand(image, result.labels, {box, label});
        EXPECT_LT((result.embeddings.row(s).transpose() - sum.normalized()).norm(), 1e-5);
      }
      const Eigen::Vector4f whole = embedByHand(image, {}, {cv::Rect(0, 0, 64, 64), 0});
      EXPECT_LT((result.image_embedding - whole.normalized()).norm(), 1e-5);
    }
  }
}

TEST(Segmenter, WithoutEmbeddingTheRowsAreZeros) {
  TSG_REQUIRE_ENGINE();
  SegmenterConfig config;
  config.embed_crop = config.embed_masked_crop = config.embed_image = false;
  const Segmentation result =
      Segmenter(makeSmallModels(), config).segment(asRgb(makeTwoRectangles()));
  EXPECT_EQ(result.embeddings, EmbeddingMatrix::Zero(2, 4));
  EXPECT_EQ(result.image_embedding.size(), 0);
}

TEST(Segmenter, BatchSizesDoNotChangeTheResult) {
  TSG_REQUIRE_ENGINE();
  const ColorImage color = asRgb(makeTwoRectangles());
  const Segmentation expected = Segmenter(makeSmallModels(), {}).segment(color);
  SegmenterConfig one_by_one;
  one_by_one.encoder.max_batch = 1;
  expectSameSegmentation(Segmenter(makeSmallModels(), one_by_one).segment(color), expected);
  SegmenterConfig padded;
  padded.encoder.pad_batches = true;
  expectSameSegmentation(Segmenter(makeSmallModels(), padded).segment(color), expected);
  ModelSet fixed = makeSmallModels();
  fixed.image_encoder = findNetwork("encoder_two_at_once");
  expectSameSegmentation(Segmenter(fixed, {}).segment(color), expected);
}

TEST(Segmenter, SizesThatTheFilesLeaveOpenComeFromTheModelSet) {
  TSG_REQUIRE_ENGINE();
  const ColorImage color = asRgb(makeTwoRectangles());
  ModelSet open = makeSmallModels();
  open.segmenter = findNetwork("segmenter_open_size");
  open.image_encoder = findNetwork("encoder_open_size");
  expectSameSegmentation(Segmenter(open, {}).segment(color),
                         Segmenter(makeSmallModels(), {}).segment(color));
}

TEST(Segmenter, ThresholdsOfTheConfigurationReplaceTheModelSets) {
  TSG_REQUIRE_ENGINE();
  SegmenterConfig config;
  config.score_threshold = 0.85;
  const ColorImage color = asRgb(makeTwoRectangles());
  EXPECT_EQ(Segmenter(makeSmallModels(), config).segment(color).numSegments(), 1U);
  config.score_threshold = -1.0;
  config.iou_threshold = 0.5;  // all boxes overlap more than that
  EXPECT_EQ(Segmenter(makeSmallModels(), config).segment(color).numSegments(), 1U);
}

TEST(Segmenter, AnImageWithNothingInItGivesACleanEmptyResult) {
  TSG_REQUIRE_ENGINE();
  Segmenter segmenter(makeSmallModels(), {});
  const Segmentation result = segmenter.segment(asRgb(cv::Mat::zeros(48, 64, CV_8UC3)));
  result.validate();
  EXPECT_EQ(result.labels.size(), cv::Size(64, 48));
  EXPECT_EQ(cv::countNonZero(result.labels), 0);
  EXPECT_EQ(result.embeddings.rows(), 0);
  EXPECT_EQ(result.embeddings.cols(), 4);
  EXPECT_EQ(result.image_embedding.size(), 4);
  EXPECT_EQ(segmenter.counters().images_without_segments, 1U);
}

TEST(Segmenter, ImagesOfAnySizeWork) {
  TSG_REQUIRE_ENGINE();
  Segmenter segmenter(makeSmallModels(), {});
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2000, 3), cv::Size(7680, 4320)}) {
    const cv::Mat image(size, CV_8UC3, cv::Scalar(255, 0, 0));
    const Segmentation result = segmenter.segment(asRgb(image));
    result.validate();
    EXPECT_EQ(result.labels.size(), size);
  }
}

TEST(Segmenter, OtherImageTypesAreRefusedByName) {
  TSG_REQUIRE_ENGINE();
  Segmenter segmenter(makeSmallModels(), {});
  for (const cv::Mat& image : {cv::Mat(4, 4, CV_8UC1), cv::Mat(4, 4, CV_8UC4), cv::Mat()}) {
    try {
      segmenter.segment(asRgb(image));
      FAIL();
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(cv::typeToString(image.type())), std::string::npos);
      EXPECT_NE(std::string(e.what()).find("expected CV_8UC3"), std::string::npos);
    }
  }
}

TEST(Segmenter, EmbeddingsThatAreNotFiniteBecomeZerosAndAreCounted) {
  TSG_REQUIRE_ENGINE();
  for (const char* broken : {"encoder_nan_on_bright", "encoder_infinite_on_bright"}) {
    ModelSet models = makeSmallModels();
    models.image_encoder = findNetwork(broken);
    Segmenter segmenter(models, {});
    const Segmentation result = segmenter.segment(asRgb(makeTwoRectangles()));
    result.validate();
    EXPECT_EQ(result.embeddings, EmbeddingMatrix::Zero(2, 4)) << broken;
    EXPECT_EQ(result.image_embedding.size(), 0);
    EXPECT_EQ(segmenter.counters().embeddings_not_finite, 3U);
    EXPECT_GT(segmenter.segment(asRgb(cv::Mat::zeros(64, 64, CV_8UC3))).image_embedding.norm(),
              0.9F);
  }
}

TEST(Segmenter, ScoresThatAreNotFiniteGiveNoSegments) {
  TSG_REQUIRE_ENGINE();
  ModelSet models = makeSmallModels();
  models.segmenter = findNetwork("segmenter_nan_on_bright");
  EXPECT_EQ(Segmenter(models, {}).segment(asRgb(makeTwoRectangles())).numSegments(), 0U);
}

std::string errorOf(const ModelSet& models) {
  try {
    Segmenter segmenter(models, {});
  } catch (const InferenceError& e) {
    return e.what();
  }
  return "";
}

void expectError(const ModelSet& models, const std::vector<std::string>& words) {
  const std::string error = errorOf(models);
  for (const std::string& word : words) {
    EXPECT_NE(error.find(word), std::string::npos) << word << " is not in: " << error;
  }
}

TEST(Segmenter, NetworksThatAreExchangedAreRefusedAtStart) {
  TSG_REQUIRE_ENGINE();
  ModelSet models = makeSmallModels();
  std::swap(models.segmenter, models.image_encoder);
  expectError(models, {"encoder.onnx' gives embedding float32[1,4]",
                       "expected one output [1,4+classes+K,candidates]"});
  models = makeSmallModels();
  models.image_encoder = models.segmenter;
  expectError(models, {"segmenter.onnx' gives output0 float32[1,9,4]", "image_embeds [1,4]"});
}

TEST(Segmenter, EmbeddingsOfAnotherSizeThanTheModelSetsAreRefusedAtStart) {
  TSG_REQUIRE_ENGINE();
  ModelSet models = makeSmallModels();
  models.embedding_size = 512;
  models.file = "/home/a/models.yaml";
  expectError(models, {"encoder.onnx'", "it gives embeddings of 4 values",
                       "model set 'small' (/home/a/models.yaml) says embedding_size 512"});
}

TEST(Segmenter, SegmentersOfOtherLayoutsAreRefusedAtStartWithWhatToDo) {
  TSG_REQUIRE_ENGINE();
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"nms", {"output0 is [1,300,38]", "NMS inside", "export with nms=False"}},
      {"yolov5", {"output0 is [1,25200,117]", "YOLOv5"}},
      {"anchors_first_80", {"output0 is [1,8400,116]", "rows and columns exchanged"}},
      {"zero_boxes", {"output0 float32[1,37,8400]", "its boxes reach 0", "expected pixels"}},
      {"boxes_only", {"output0 is [1,84,8400]", "no mask prototypes", "boxes only"}},
      {"two_outputs_wrong", {"output0 is [1,7,4]", "neither [1,4+classes+4,candidates]"}},
      {"channels_last", {"images float32[1,640,640,3]", "channels last"}},
      {"uint8", {"images uint8[1,3,640,640]", "pixels as uint8", "float32 images in 0..1"}},
      {"batch4", {"images float32[4,3,640,640]", "4 images at once", "batch=1"}},
      {"wide", {"images float32[1,3,480,640]", "640x480 px", "square"}},
      {"nan", {"output0 float32[1,9,4]", "not finite"}}};
  for (const auto& [name, words] : cases) {
    ModelSet models = makeSmallModels();
    models.segmenter = findNetwork(std::string("segmenter_") + name);
    expectError(models, words);
    expectError(models, {"segmenter '" + models.segmenter + "'", "scripts/export_models"});
  }
}

TEST(Segmenter, SizesThatTheNetworksCannotTakeAreRefusedAtStart) {
  TSG_REQUIRE_ENGINE();
  ModelSet models = makeSmallModels();
  models.segmenter = findNetwork("segmenter_only_64");
  models.image_encoder = findNetwork("encoder_only_8");
  EXPECT_EQ(errorOf(models), "");
  models.segmenter_input_size_px = 96;
  expectError(models, {"segmenter_only_64.onnx' cannot take images of 96 px",
                       "segmenter_input_size_px of model set 'small'", "multiple of 32"});
  models.segmenter_input_size_px = 64;
  models.image_encoder_input_size_px = 12;
  expectError(models, {"encoder_only_8.onnx' cannot take images of 12 px",
                       "image_encoder_input_size_px of model set 'small'"});
}

TEST(Segmenter, CandidatesByRowsOrOutputsInAnotherOrderGiveTheSame) {
  TSG_REQUIRE_ENGINE();
  const ColorImage color = asRgb(makeTwoRectangles());
  const Segmentation expected = Segmenter(makeSmallModels(), {}).segment(color);
  for (const char* name : {"segmenter_anchors_first", "segmenter_more_outputs"}) {
    ModelSet models = makeSmallModels();
    models.segmenter = findNetwork(name);
    expectSameSegmentation(Segmenter(models, {}).segment(color), expected);
  }
}

TEST(Segmenter, AfterAnImageThatFailedTheNextOneIsAsIfItHadNotBeenThere) {
  TSG_REQUIRE_ENGINE();
  for (const ScheduleMode mode : {ScheduleMode::kExact, ScheduleMode::kReuse}) {
    for (const char* failing : {"segmenter_error_on_bright", "encoder_error_on_bright"}) {
      ModelSet models = makeSmallModels();
      (failing[0] == 's' ? models.segmenter : models.image_encoder) = findNetwork(failing);
      SegmenterConfig config;
      config.schedule.mode = mode;
      config.schedule.max_skipped_images = 2;
      config.schedule.image_period_s = 0.0;
      Segmenter tried(models, config);
      Segmenter spared(models, config);
      for (int i = 0; i < 6; ++i) {
        ColorImage color = asRgb(makeTwoRectangles());
        color.stamp = Stamp::fromSeconds(0.1 * i);
        expectSameSegmentation(tried.segment(color), spared.segment(color));
        ColorImage white = asRgb(cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(255)));
        white.stamp = Stamp::fromSeconds(0.1 * i + 0.05);
        EXPECT_THROW(tried.segment(white), InferenceError) << failing;
      }
      EXPECT_EQ(tried.counters().images_carried, spared.counters().images_carried);
      EXPECT_EQ(tried.counters().segments_reused, spared.counters().segments_reused);
      EXPECT_EQ(tried.counters().crops_embedded, spared.counters().crops_embedded);
      EXPECT_EQ(spared.counters().images_carried, mode == ScheduleMode::kReuse ? 4U : 0U);
    }
  }
}

TEST(Segmenter, ParametersOutOfRangeAreRefused) {
  SegmenterConfig config;
  config.max_segments = 0;
  EXPECT_THROW(Segmenter(makeSmallModels(), config), config::ConfigError);
}

TEST(Segmenter, CancelEndsARunningSegmentAndAllLaterOnes) {
  TSG_REQUIRE_ENGINE();
  ModelSet models = makeSmallModels();
  models.segmenter = findNetwork("slow_segmenter");
  Segmenter segmenter(models, {});
  EXPECT_EQ(segmenter.segment(asRgb(cv::Mat::zeros(64, 64, CV_8UC3))).numSegments(), 0U);
  const ColorImage white = asRgb(cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(255)));
  auto running = std::async(std::launch::async, [&] { segmenter.segment(white); });
  segmenter.cancel();
  EXPECT_THROW(running.get(), Cancelled);
  EXPECT_THROW(segmenter.segment(white), Cancelled);
}

/// Real weights on real photographs.
class KitchenTest : public ::testing::Test {
 protected:
  static ColorImage readFrame(const std::filesystem::path& kitchen, int index) {
    char name[32];
    std::snprintf(name, sizeof name, "frame-%06d.color.jpg", index);
    return {{}, cv::imread((kitchen / name).string()), ColorOrder::kBgr, nullptr};
  }
};

TEST_F(KitchenTest, SegmentsAreFoundAndEmbeddedWithUnitLength) {
  TSG_REQUIRE_ENGINE();
  TSG_REQUIRE_SHARED(models, "models/models.yaml");
  TSG_REQUIRE_SHARED(kitchen, "data/kitchen");
  Segmenter segmenter(loadModelSet(models.string()), {});
  for (const int index : {0, 150}) {
    const Segmentation result = segmenter.segment(readFrame(kitchen, index));
    result.validate();
    EXPECT_EQ(result.labels.size(), cv::Size(640, 480));
    EXPECT_GE(result.numSegments(), 5U);
    EXPECT_EQ(result.embeddings.cols(), 384);
    EXPECT_TRUE((result.embeddings.rowwise().norm().array() - 1.0F).abs().maxCoeff() < 1e-5);
    EXPECT_NEAR(result.image_embedding.norm(), 1.0, 1e-5);
    EXPECT_GT(cv::countNonZero(result.labels), 640 * 480 / 20);
  }
}

TEST_F(KitchenTest, ResultsDoNotDependOnThreadsOrRepetition) {
  TSG_REQUIRE_ENGINE();
  TSG_REQUIRE_SHARED(models_path, "models/models.yaml");
  TSG_REQUIRE_SHARED(kitchen, "data/kitchen");
  const ModelSet models = loadModelSet(models_path.string());
  const ColorImage color = readFrame(kitchen, 42);
  SegmenterConfig config;
  config.engine.num_threads = 1;
  Segmenter one(models, config);
  const Segmentation expected = one.segment(color);
  expectSameSegmentation(one.segment(color), expected);
  for (const int threads : {2, 3}) {
    config.engine.num_threads = threads;
    expectSameSegmentation(Segmenter(models, config).segment(color), expected);
  }
}

}  // namespace
}  // namespace tsg::segmentation
