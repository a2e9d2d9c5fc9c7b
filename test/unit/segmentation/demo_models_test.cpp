// SPDX-License-Identifier: BSD-3-Clause
// The networks in models/demo, on apartments whose seeds they were not trained on.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "networks.h"
#include "segment_score.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/language/vocabulary.h"
#include "task_scene_graph/segmentation/segmenter.h"
#include "task_scene_graph/simulation/random.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/variation.h"

namespace tsg::segmentation {
namespace {

namespace fs = std::filesystem;

constexpr float kTolerance = 1e-4F;
const std::string kFolder = TSG_SOURCE_DIR "/models/demo/";

/// What PyTorch computed when the files were exported (training/demo_models/export.py).
nlohmann::json loadReference() {
  std::ifstream file(TSG_SOURCE_DIR "/test/data/demo_models_reference.json");
  return nlohmann::json::parse(file);
}

/// The picture that export.py's make_pattern makes: RGB planes, values in 0..1.
std::vector<float> makePattern(int size_px) {
  std::vector<float> values;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < size_px; ++y) {
      for (int x = 0; x < size_px; ++x) {
        values.push_back(static_cast<float>((7 * x + 13 * y + 29 * c + x * y / 16) % 256) / 255.0F);
      }
    }
  }
  return values;
}

void expectNear(const std::vector<float>& expected, const float* values, const std::string& what) {
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const float scale = std::max(1.0F, std::abs(expected[i]));
    ASSERT_NEAR(expected[i], values[i], kTolerance * scale) << what << ", value " << i;
  }
}

TEST(DemoModels, FilesAreSmallEnoughToBeCommitted) {
  std::uintmax_t total = 0;
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    EXPECT_LE(entry.file_size(), 10'000'000U) << entry.path();
    total += entry.file_size();
  }
  EXPECT_GT(total, 1'000'000U);
  EXPECT_LE(total, 16'000'000U);
}

TEST(DemoModels, SegmenterComputesWhatItDidWhenExported) {
  TSG_REQUIRE_ENGINE();
  const ModelSet models = loadModelSet(kFolder + "models.yaml");
  const Network network(models.segmenter, {});
  const std::int64_t side = network.inputs().at(0).shape.at(2);
  const std::vector<float> pattern = makePattern(static_cast<int>(side));
  const auto outputs = network.run({{1, 3, side, side}, pattern.data(), nullptr});
  ASSERT_EQ(outputs.at(0).shape.at(1), 37);
  const auto num_cells = static_cast<std::size_t>(outputs[0].shape.at(2));
  const nlohmann::json reference = loadReference();
  std::size_t cell = 0;
  for (const auto& row : reference.at("segmenter_cells")) {
    const auto expected = row.get<std::vector<float>>();
    std::vector<float> values;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      values.push_back(outputs[0].values[k * num_cells + cell]);
    }
    expectNear(expected, values.data(), "cell " + std::to_string(cell));
    cell += 97;
  }
  EXPECT_GE(cell, num_cells);
}

TEST(DemoModels, ImageEncoderComputesWhatItDidWhenExported) {
  TSG_REQUIRE_ENGINE();
  const ModelSet models = loadModelSet(kFolder + "models.yaml");
  const Network network(models.image_encoder, {});
  const std::int64_t side = network.inputs().at(0).shape.at(2);
  std::vector<float> pattern = makePattern(static_cast<int>(side));
  for (float& value : pattern) {
    value = (value - static_cast<float>(models.image_mean[0])) /
            static_cast<float>(models.image_std[0]);
  }
  const auto outputs = network.run({{1, 3, side, side}, pattern.data(), nullptr});
  expectNear(loadReference().at("image").get<std::vector<float>>(), outputs.at(0).values, "image");
}

/// The text encoder and the segmenter together, on renders.
class DemoModelsOnRenders : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string obstacle = findEngineObstacle();
    if (!obstacle.empty()) GTEST_SKIP() << obstacle;
    if (!language::findInstalledVocabulary()) {
      GTEST_SKIP() << "CLIP's vocabulary is not here (scripts/install_vocabulary gets it)";
    }
    models_ = loadModelSet(kFolder + "models.yaml");
    text_encoder_ = std::make_unique<language::TextEncoder>(models_, EngineConfig{});
  }

  ModelSet models_;
  std::unique_ptr<language::TextEncoder> text_encoder_;
};

TEST_F(DemoModelsOnRenders, TextEncoderComputesWhatItDidWhenExported) {
  const nlohmann::json reference = loadReference();
  const auto sentences = reference.at("sentences").get<std::vector<std::string>>();
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    const EmbeddingMatrix row = text_encoder_->encode({sentences[i]});
    expectNear(reference.at("texts").at(i).get<std::vector<float>>(), row.data(), sentences[i]);
  }
}

struct Score {
  int things = 0;
  int found = 0;
  int named = 0;
};

/// Counts, among the instances of more than 400 px, those segmented and those named right.
void scoreView(const simulation::Apartment& apartment, const simulation::RenderedView& view,
               const Segmentation& segmentation, const std::vector<std::string>& phrases,
               const EmbeddingMatrix& texts, Score& score) {
  for (const auto& match : test::matchThings(view.labels, segmentation.labels, 400, 0.5)) {
    ++score.things;
    if (!match.segment) continue;
    ++score.found;
    const auto row = static_cast<Eigen::Index>(*match.segment);
    Eigen::Index text = 0;
    (texts * segmentation.embeddings.row(row).transpose()).maxCoeff(&text);
    const auto& instance = apartment.instances[static_cast<std::size_t>(match.thing - 1)];
    if (phrases[static_cast<std::size_t>(text)] == instance.phrase) ++score.named;
  }
}

TEST_F(DemoModelsOnRenders, MostThingsOfAnUnknownApartmentAreSegmentedAndNamed) {
  const simulation::Apartment apartment = simulation::buildApartment({3, 6});
  std::vector<std::string> phrases;
  for (const auto& instance : apartment.instances) phrases.push_back(instance.phrase);
  std::sort(phrases.begin(), phrases.end());
  phrases.erase(std::unique(phrases.begin(), phrases.end()), phrases.end());
  const EmbeddingMatrix texts = text_encoder_->encode(phrases);
  SegmenterConfig config;
  config.encoder.fit = CropFit::kSquash;
  Segmenter segmenter(models_, config);
  const simulation::Renderer renderer(apartment, 1);
  simulation::Random random(7);
  Score score;
  for (const Pose& T_world_camera : simulation::pickRandomViews(apartment, 12, random)) {
    const auto view = renderer.render(simulation::makeDefaultCamera(640, 480), T_world_camera);
    const Segmentation segmentation =
        segmenter.segment({{}, view.color, ColorOrder::kRgb, nullptr});
    scoreView(apartment, view, segmentation, phrases, texts, score);
  }
  EXPECT_GT(score.things, 40);
  EXPECT_GE(score.found, 0.75 * score.things);
  EXPECT_GE(score.named, 0.75 * score.found);
}

TEST_F(DemoModelsOnRenders, RoomsAreNamedFromWholeImages) {
  const simulation::Apartment apartment = simulation::buildApartment({3, 6});
  std::vector<std::string> rooms;
  for (const auto& room : apartment.rooms) rooms.push_back(room.phrase);
  const EmbeddingMatrix texts = text_encoder_->encode(rooms);
  SegmenterConfig config;
  config.encoder.fit = CropFit::kSquash;
  Segmenter segmenter(models_, config);
  const simulation::Renderer renderer(apartment, 1);
  simulation::Random random(8);
  int views = 0;
  int right = 0;
  for (const Pose& T_world_camera : simulation::pickRandomViews(apartment, 20, random)) {
    const auto view = renderer.render(simulation::makeDefaultCamera(640, 480), T_world_camera);
    const auto main = std::max_element(view.room_pixels.begin() + 1, view.room_pixels.end());
    if (*main < 0.7 * 640 * 480) continue;
    const Segmentation segmentation =
        segmenter.segment({{}, view.color, ColorOrder::kRgb, nullptr});
    Eigen::Index text = 0;
    (texts * segmentation.image_embedding).maxCoeff(&text);
    ++views;
    if (text == main - view.room_pixels.begin() - 1) ++right;
  }
  EXPECT_GT(views, 8);
  EXPECT_GE(right, 0.75 * views);
}

TEST_F(DemoModelsOnRenders, ThingsThatNoApartmentHasStayBelowAlphaOfThoseItHas) {
  const EmbeddingMatrix texts =
      text_encoder_->encode({"get the coffee mug", "coffee mug", "repair the bicycle"});
  EXPECT_GT(texts.row(0).dot(texts.row(1)), 0.8F);
  EXPECT_LT(texts.row(0).dot(texts.row(2)), 0.5F);
}

}  // namespace
}  // namespace tsg::segmentation
