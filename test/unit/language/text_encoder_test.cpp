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
  segmentation::ModelSet models = makeModels("text_encoder", 512);
  models.file = "/home/a/models.yaml";
  const std::string error = errorOf(models);
  EXPECT_NE(error.find("text_encoder.onnx' gives embedding float32[1,12]"), std::string::npos)
      << error;
  EXPECT_NE(error.find("embeddings of 12 values, but model set 'small' (/home/a/models.yaml) says "
                       "embedding_size 512"),
            std::string::npos)
      << error;
}

TEST_F(TextEncoderTest, NetworksOfOtherShapesAreRefusedAtStartWithWhatToDo) {
  const std::pair<const char*, const char*> cases[] = {
      {"text_encoder_per_token", "'embedding' is [1,77,8], the hidden states"},
      {"text_encoder_float", "'text' is float32"},
      {"text_encoder_64", "it reads 64 tokens, not 77. SigLIP's"},
      {"text_encoder_pooler", "'pooler_output' comes before the projection"},
      {"text_encoder_hidden_named_embeds", "'text_embeds' is [1,77,8], the hidden states"},
      {"text_encoder_ambiguous", "text_encoder_output: first"},
      {"text_encoder_bert", "BERT's tokenizer"},
      {"text_encoder_same_for_all", "the same for '' and 'a red mug'"},
      {"text_encoder_nan", "a vector of length nan"}};
  for (const auto& [name, words] : cases) {
    const std::string error = errorOf(makeModels(name));
    EXPECT_NE(error.find("text encoder '" + networkPath(name) + "'"), std::string::npos) << error;
    EXPECT_NE(error.find(words), std::string::npos) << words << " is not in: " << error;
  }
}

TEST_F(TextEncoderTest, ImageEncoderInItsPlaceIsReported) {
  segmentation::ModelSet models = makeModels("text_encoder", 4);
  models.text_encoder = TSG_SOURCE_DIR "/test/data/networks/encoder.onnx";
  EXPECT_NE(errorOf(models).find("an image encoder?"), std::string::npos) << errorOf(models);
}

TEST_F(TextEncoderTest, FilesWithMasksOrSeveralOutputsOrBothTowersGiveTheSame) {
  for (const char* name :
       {"text_encoder_mask", "text_encoder_mask_int32", "text_encoder_named", "clip_both_towers"}) {
    const TextEncoder encoder(makeModels(name), {});
    EXPECT_LT((encoder.encode(kTexts) - computeAllExpected(kTexts)).cwiseAbs().maxCoeff(), 1e-5F)
        << name;
  }
}

TEST_F(TextEncoderTest, TheModelSetMayNameTheOutput) {
  for (const auto& [name, output] :
       {std::pair<const char*, const char*>{"text_encoder_pooler", "pooler_output"},
        {"text_encoder_ambiguous", "second"}}) {
    segmentation::ModelSet models = makeModels(name);
    models.text_encoder_output = output;
    const TextEncoder encoder(models, {});
    EXPECT_LT((encoder.encode(kTexts) - computeAllExpected(kTexts)).cwiseAbs().maxCoeff(), 1e-5F)
        << name;
  }
}

TEST_F(TextEncoderTest, AContextThatTheModelSetConfirmsIsUsed) {
  segmentation::ModelSet models = makeModels("text_encoder_64");
  models.text_context_length = 64;
  const TextEncoder encoder(models, {});
  EXPECT_LT((encoder.encode(kTexts) - computeAllExpected(kTexts)).cwiseAbs().maxCoeff(), 1e-5F);
  // Longer than the context: cut to it, with the end mark last.
  std::string words = "mug";
  for (int i = 0; i < 100; ++i) words += " mug";
  const Tokenizer tokenizer(Vocabulary::load(vocabulary_), 64);
  EXPECT_LT((encoder.encode({words}) - computeExpected(tokenizer.tokenize({words}))).norm(), 1e-5F);
}

TEST_F(TextEncoderTest, AnOpenContextHasTheModelSetsLength) {
  segmentation::ModelSet models = makeModels("text_encoder_mask");
  models.text_context_length = 20;
  std::string words = "mug";
  for (int i = 0; i < 100; ++i) words += " mug";
  const Tokenizer tokenizer(Vocabulary::load(vocabulary_), 20);
  const TextEncoder encoder(models, {});
  EXPECT_LT((encoder.encode({words}) - computeExpected(tokenizer.tokenize({words}))).norm(), 1e-5F);
}

TEST_F(TextEncoderTest, TokensThatTheNetworkCannotReadAreExplained) {
  segmentation::ModelSet models = makeModels("text_encoder_mask");
  models.text_context_length = 80;  // it has 77 positions
  const std::string error = errorOf(models);
  EXPECT_NE(error.find("cannot read 80 tokens of CLIP's tokenizer"), std::string::npos) << error;
}

TEST_F(TextEncoderTest, AbsentFilesAreNamed) {
  EXPECT_NE(errorOf(makeModels("")).find("model set 'small' has no text encoder"),
            std::string::npos);
  EXPECT_NE(errorOf(makeModels("no_such_network")).find("no_such_network.onnx"), std::string::npos);
  segmentation::ModelSet models = makeModels("");
  models.file = "/home/a/models.yaml";
  EXPECT_NE(errorOf(models).find("/home/a/models.yaml"), std::string::npos);
  models = makeModels("text_encoder");
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
