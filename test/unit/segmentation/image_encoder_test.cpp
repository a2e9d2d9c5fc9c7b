// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/image_encoder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "networks.h"

namespace tsg::segmentation {
namespace {

EngineConfig withThreads(int num_threads) {
  EngineConfig engine;
  engine.num_threads = num_threads;
  return engine;
}

/// Vertical stripes, stripe i of the grey value 10 i.
ColorImage makeStripes(int count) {
  cv::Mat image(16, 16 * count, CV_8UC3);
  for (int i = 0; i < count; ++i) {
    image.colRange(16 * i, 16 * (i + 1)) = cv::Scalar::all(10.0 * i);
  }
  return {{}, image, ColorOrder::kRgb, nullptr};
}

std::vector<CropRequest> cropStripes(int count) {
  std::vector<CropRequest> requests;
  for (int i = 0; i < count; ++i) requests.push_back({{16 * i, 0, 16, 16}, 0});
  return requests;
}

TEST(ImageEncoder, RowsFollowTheRequestsForAnyNumberOfThreadsAndBatchSize) {
  TSG_REQUIRE_ENGINE();
  const ModelSet models = makeSmallModels();
  for (const int threads : {1, 3}) {
    for (const int max_batch : {1, 4, 5}) {
      ImageEncoderConfig config;
      config.max_batch = max_batch;
      const ImageEncoder encoder(models, withThreads(threads), config);
      const EmbeddingMatrix rows = encoder.encode(makeStripes(23), {}, cropStripes(23));
      ASSERT_EQ(rows.rows(), 23);
      for (int i = 0; i < 23; ++i) {
        // The network's first value: the mean normalised red, plus 1/4.
        const double red = (10.0 * i / 255.0 - models.image_mean[0]) / models.image_std[0];
        EXPECT_NEAR(rows(i, 0), red + 0.25, 1e-5) << "crop " << i;
      }
    }
  }
}

TEST(ImageEncoder, NoRequestGivesNoRow) {
  TSG_REQUIRE_ENGINE();
  const ImageEncoder encoder(makeSmallModels(), withThreads(2), {});
  const EmbeddingMatrix rows = encoder.encode(makeStripes(1), {}, {});
  EXPECT_EQ(rows.rows(), 0);
  EXPECT_EQ(rows.cols(), 4);
}

TEST(ImageEncoder, AnErrorInOneThreadReachesTheCaller) {
  TSG_REQUIRE_ENGINE();
  const ImageEncoder encoder(makeSmallModels(), withThreads(3), {});
  std::vector<CropRequest> requests = cropStripes(23);
  requests[17].box_px.width = 1000;
  try {
    encoder.encode(makeStripes(23), {}, requests);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("1000x16 at (272, 0)"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("inside 368x16"), std::string::npos) << e.what();
  }
}

EmbeddingMatrix encodeStripes(const std::string& network) {
  ModelSet models = makeSmallModels();
  models.image_encoder = findNetwork(network);
  return ImageEncoder(models, withThreads(2), {}).encode(makeStripes(23), {}, cropStripes(23));
}

TEST(ImageEncoder, NetworksOfHalfFloatsAndOf8BitIntegersGiveNearlyTheSame) {
  TSG_REQUIRE_ENGINE();
  const EmbeddingMatrix rows = encodeStripes("encoder");
  // Values reach 5; half floats keep 11 bits; 8 bits divide the inputs' range.
  EXPECT_LT((encodeStripes("encoder_float16") - rows).cwiseAbs().maxCoeff(), 1e-2F);
  EXPECT_LT((encodeStripes("encoder_int8") - rows).cwiseAbs().maxCoeff(), 8.0F / 255.0F);
  EXPECT_GT((encodeStripes("encoder_int8") - rows).cwiseAbs().maxCoeff(), 0.0F);
}

TEST(ImageEncoder, OfSeveralOutputsTheEmbeddingIsTaken) {
  TSG_REQUIRE_ENGINE();
  const EmbeddingMatrix rows = encodeStripes("encoder");
  EXPECT_EQ(encodeStripes("encoder_named"), rows);
  EXPECT_EQ(encodeStripes("encoder_column"), rows);  // [N,D,1]
}

std::string errorOf(const ModelSet& models) {
  try {
    const ImageEncoder encoder(models, withThreads(2), {});
  } catch (const InferenceError& e) {
    return e.what();
  }
  return "";
}

TEST(ImageEncoder, NetworksOfOtherShapesAreRefusedAtStart) {
  TSG_REQUIRE_ENGINE();
  const std::pair<const char*, const char*> cases[] = {
      {"channels_last", "channels last"},
      {"uint8", "pixels as uint8"},
      {"wide", "12x8 px"},
      {"hidden", "'last_hidden_state' is [1,3,4], the hidden states"},
      {"pooler", "before the projection"},
      {"ambiguous", "image_encoder_output: first"},
      {"nan", "a vector of length nan"},
      {"infinite", "a vector of length inf"}};
  for (const auto& [name, words] : cases) {
    ModelSet models = makeSmallModels();
    models.image_encoder = findNetwork(std::string("encoder_") + name);
    const std::string error = errorOf(models);
    EXPECT_NE(error.find("image encoder '" + models.image_encoder + "'"), std::string::npos)
        << error;
    EXPECT_NE(error.find(words), std::string::npos) << words << " is not in: " << error;
  }
}

TEST(ImageEncoder, TheModelSetMayNameTheOutput) {
  TSG_REQUIRE_ENGINE();
  const EmbeddingMatrix expected = encodeStripes("encoder");
  for (const auto& [name, output] :
       {std::pair<const char*, const char*>{"pooler", "pooler_output"}, {"ambiguous", "second"}}) {
    ModelSet models = makeSmallModels();
    models.image_encoder = findNetwork(std::string("encoder_") + name);
    models.image_encoder_output = output;
    const ImageEncoder encoder(models, withThreads(2), {});
    EXPECT_EQ(encoder.encode(makeStripes(23), {}, cropStripes(23)), expected) << name;
  }
}

TEST(ImageEncoder, AWholeClipInOneFileServes) {
  TSG_REQUIRE_ENGINE();
  ModelSet models = makeSmallModels();
  models.image_encoder = TSG_SOURCE_DIR "/test/unit/language/networks/clip_both_towers.onnx";
  models.embedding_size = 12;
  const ImageEncoder encoder(models, withThreads(2), {});
  const EmbeddingMatrix rows = encoder.encode(makeStripes(23), {}, cropStripes(23));
  ASSERT_EQ(rows.rows(), 23);
  for (int i = 0; i < 23; ++i) {
    for (int k = 0; k < 12; ++k) {  // what test/support/make_text_encoders.py says
      double expected = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double mean = (10.0 * i / 255.0 - models.image_mean[c]) / models.image_std[c];
        expected += mean * std::sin(0.3 + 12.0 * static_cast<double>(c) + k);
      }
      EXPECT_NEAR(rows(i, k), expected, 1e-4);
    }
  }
}

TEST(ImageEncoder, AfterCancelNothingIsEncoded) {
  TSG_REQUIRE_ENGINE();
  ImageEncoder encoder(makeSmallModels(), withThreads(2), {});
  encoder.cancel();
  EXPECT_THROW(encoder.encode(makeStripes(5), {}, cropStripes(5)), Cancelled);
}

TEST(ImageEncoder, SizesAreTheFilesAndTheModelSets) {
  TSG_REQUIRE_ENGINE();
  const ImageEncoder fixed(makeSmallModels(), {}, {});
  EXPECT_EQ(fixed.inputSize(), 8);
  EXPECT_EQ(fixed.embeddingSize(), 4);
  ModelSet models = makeSmallModels();
  models.image_encoder = findNetwork("encoder_open_size");
  models.image_encoder_input_size_px = 12;
  EXPECT_EQ(ImageEncoder(models, {}, {}).inputSize(), 12);
}

}  // namespace
}  // namespace tsg::segmentation
