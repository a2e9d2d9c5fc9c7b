// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/text_encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/language/prompts.h"
#include "test_vocabulary.h"

namespace tsg::language {
namespace {

using Texts = std::vector<std::string>;

constexpr int kWidth = 8;
constexpr int kSize = 12;

/// What test/support/make_text_encoders.py says the networks compute, for one row of tokens.
Eigen::RowVectorXf computeExpected(const TokenMatrix& tokens) {
  Eigen::Index end = 0;
  tokens.row(0).maxCoeff(&end);
  Eigen::RowVectorXd sums = Eigen::RowVectorXd::Zero(kWidth);
  for (Eigen::Index p = 0; p <= end; ++p) {
    for (int j = 0; j < kWidth; ++j) {
      const auto id = static_cast<double>(tokens(0, p) % 61);
      sums[j] += std::tanh(std::sin(1.0 + kWidth * id + j) +
                           std::cos(kWidth * static_cast<double>(p) + j) / 2.0);
    }
  }
  Eigen::RowVectorXd vector = Eigen::RowVectorXd::Zero(kSize);
  for (int j = 0; j < kWidth; ++j) {
    for (int k = 0; k < kSize; ++k) vector[k] += sums[j] * std::sin(0.3 + kSize * j + k);
  }
  return vector.normalized().cast<float>();
}

class TextEncoderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto vocabulary = test::findClipVocabulary();
    if (!vocabulary) GTEST_SKIP() << "CLIP's vocabulary is not here";
    try {
      segmentation::Network(networkPath("text_encoder"), {});
    } catch (const segmentation::InferenceError& e) {
      GTEST_SKIP() << e.what();
    }
    vocabulary_ = *vocabulary;
  }

  static std::string networkPath(const std::string& name) {
    return TSG_SOURCE_DIR "/test/unit/language/networks/" + name + ".onnx";
  }

  segmentation::ModelSet makeModels(const std::string& network, int embedding_size = kSize) const {
    segmentation::ModelSet models;
    models.name = "small";
    models.text_encoder = network.empty() ? "" : networkPath(network);
    models.tokenizer = vocabulary_;
    models.embedding_size = embedding_size;
    return models;
  }

  EmbeddingMatrix computeAllExpected(const Texts& texts) const {
    const Tokenizer tokenizer(Vocabulary::load(vocabulary_));
    EmbeddingMatrix expected(static_cast<Eigen::Index>(texts.size()), kSize);
    for (std::size_t i = 0; i < texts.size(); ++i) {
      expected.row(static_cast<Eigen::Index>(i)) = computeExpected(tokenizer.tokenize({texts[i]}));
    }
    return expected;
  }

  /// The message of the error that making an encoder ends with.
  std::string errorOf(const segmentation::ModelSet& models) const {
    try {
      const TextEncoder encoder(models, {});
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "no exception";
  }

  std::string vocabulary_;
};

const Texts kTexts = {"a mug",        "wash the dishes", "",     "get my notes and books",
                      "a dog's bowl", "a sofa",          "a bed"};

TEST_F(TextEncoderTest, EmbeddingsEqualAComputationByHand) {
  const TextEncoder encoder(makeModels("text_encoder"), {});
  EXPECT_EQ(encoder.embeddingSize(), kSize);
  EXPECT_LT((encoder.encode(kTexts) - computeAllExpected(kTexts)).cwiseAbs().maxCoeff(), 1e-5F);
}

TEST_F(TextEncoderTest, BatchSizeDoesNotMatter) {
  const EmbeddingMatrix expected = computeAllExpected(kTexts);
  for (const int max_batch : {1, 2, 3, 7, 64}) {
    TextEncoderConfig config;
    config.max_batch = max_batch;
    const TextEncoder encoder(makeModels("text_encoder"), {}, config);
    EXPECT_LT((encoder.encode(kTexts) - expected).cwiseAbs().maxCoeff(), 1e-5F) << max_batch;
  }
}

TEST_F(TextEncoderTest, NetworkOfInt32TokensAndFixedBatchGivesTheSame) {
  const TextEncoder encoder(makeModels("text_encoder_int32_batch4"), {});
  EXPECT_LT((encoder.encode(kTexts) - computeAllExpected(kTexts)).cwiseAbs().maxCoeff(), 1e-5F);
}

TEST_F(TextEncoderTest, NoTextGivesNoRow) {
  const EmbeddingMatrix none = TextEncoder(makeModels("text_encoder"), {}).encodeTasks({});
  EXPECT_EQ(none.rows(), 0);
  EXPECT_EQ(none.cols(), kSize);
}

TEST_F(TextEncoderTest, TasksAreTheAverageOfTheirPrompts) {
  TextEncoderConfig config;
  config.prompt_templates = {"{}", "an image of {}"};
  const TextEncoder encoder(makeModels("text_encoder"), {}, config);
  const EmbeddingMatrix tasks = encoder.encodeTasks({"a mug", "a bed"});
  const EmbeddingMatrix prompts =
      computeAllExpected({"a mug", "an image of a mug", "a bed", "an image of a bed"});
  ASSERT_EQ(tasks.rows(), 2);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const Eigen::RowVectorXf mean = (prompts.row(2 * i) + prompts.row(2 * i + 1)).normalized();
    EXPECT_LT((tasks.row(i) - mean).norm(), 1e-5F);
  }
}

TEST_F(TextEncoderTest, ThreadsMayShareOneEncoder) {
  const TextEncoder encoder(makeModels("text_encoder"), {});
  const EmbeddingMatrix expected = encoder.encode(kTexts);
  std::vector<EmbeddingMatrix> results(4);
  std::vector<std::thread> threads;
  for (auto& result : results) {
    threads.emplace_back([&encoder, &result] { result = encoder.encode(kTexts); });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& result : results) EXPECT_EQ(result, expected);
}

TEST_F(TextEncoderTest, AfterCancelCallsThrow) {
  TextEncoder encoder(makeModels("text_encoder"), {});
  encoder.cancel();
  EXPECT_THROW(encoder.encode({"a mug"}), segmentation::Cancelled);
}

TEST_F(TextEncoderTest, SizeOtherThanTheModelSetsIsReported) {
  const std::string error = errorOf(makeModels("text_encoder", 512));
  EXPECT_NE(error.find("text_encoder.onnx' gives embeddings of 12 values, but model set 'small' "
                       "says embedding_size 512"),
            std::string::npos)
      << error;
}

TEST_F(TextEncoderTest, NetworkOfAnotherShapeIsReported) {
  EXPECT_NE(errorOf(makeModels("text_encoder_per_token"))
                .find("per_token.onnx' gives [1,77,8] for 1 texts, expected [1,D]"),
            std::string::npos);
  EXPECT_NE(errorOf(makeModels("text_encoder_float")).find("has inputs text float32[?,77]"),
            std::string::npos);
}

TEST_F(TextEncoderTest, VectorThatIsNotFiniteIsReported) {
  EXPECT_NE(errorOf(makeModels("text_encoder_nan")).find("a vector of length nan"),
            std::string::npos);
}

TEST_F(TextEncoderTest, AbsentFilesAreNamed) {
  EXPECT_NE(errorOf(makeModels("")).find("model set 'small' has no text encoder"),
            std::string::npos);
  EXPECT_NE(errorOf(makeModels("no_such_network")).find("no_such_network.onnx"), std::string::npos);
  segmentation::ModelSet models = makeModels("text_encoder");
  models.tokenizer = "/no/such/vocabulary.gz";
  EXPECT_NE(errorOf(models).find("/no/such/vocabulary.gz"), std::string::npos);
}

TEST_F(TextEncoderTest, BadTemplateIsRefused) {
  TextEncoderConfig config;
  config.prompt_templates = {"an image"};
  EXPECT_THROW(TextEncoder(makeModels("text_encoder"), {}, config), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::language
