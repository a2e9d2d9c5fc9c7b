// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/model_set.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support.h"
#include "task_scene_graph/config/config.h"

namespace tsg::segmentation {
namespace {

class ModelSetTest : public ::testing::Test {
 protected:
  std::string write(const std::string& yaml) const {
    const auto path = folder_.path() / "models.yaml";
    std::ofstream(path) << yaml;
    return path.string();
  }
  void touch(const std::string& name) const { std::ofstream(folder_.path() / name) << "x"; }

  std::string errorOf(const std::string& yaml) const {
    try {
      loadModelSet(write(yaml));
    } catch (const config::ConfigError& e) {
      return e.what();
    }
    return "";
  }

  test::TemporaryFolder folder_;
};

TEST_F(ModelSetTest, PathsAreRelativeToTheFile) {
  touch("seg.onnx");
  touch("clip.onnx");
  const ModelSet models = loadModelSet(
      write("{name: tiny, segmenter: seg.onnx, image_encoder: ./clip.onnx, embedding_size: 8, "
            "image_mean: [0.1, 0.2, 0.3], alpha: 0.4}"));
  EXPECT_EQ(models.segmenter, (folder_.path() / "seg.onnx").string());
  EXPECT_EQ(models.image_encoder, (folder_.path() / "clip.onnx").string());
  EXPECT_EQ(models.text_encoder, "");
  EXPECT_EQ(models.embedding_size, 8);
  EXPECT_DOUBLE_EQ(models.image_mean.at(1), 0.2);
  EXPECT_DOUBLE_EQ(models.alpha, 0.4);
}

TEST_F(ModelSetTest, AnAbsolutePathStaysAsItIs) {
  touch("seg.onnx");
  touch("clip.onnx");
  const std::string path = (folder_.path() / "seg.onnx").string();
  const ModelSet models =
      loadModelSet(write("{segmenter: " + path + ", image_encoder: clip.onnx, embedding_size: 8}"));
  EXPECT_EQ(models.segmenter, path);
}

TEST_F(ModelSetTest, VariablesAndTheFileSchemeAreExpanded) {
  touch("seg.onnx");
  touch("clip.onnx");
  setenv("TSG_TEST_MODELS", folder_.path().c_str(), 1);
  const ModelSet models =
      loadModelSet(write("{segmenter: $TSG_TEST_MODELS/seg.onnx, image_encoder: 'file://" +
                         folder_.path().string() + "/clip.onnx', embedding_size: 8}"));
  unsetenv("TSG_TEST_MODELS");
  EXPECT_EQ(models.segmenter, (folder_.path() / "seg.onnx").string());
  EXPECT_EQ(models.image_encoder, (folder_.path() / "clip.onnx").string());
  EXPECT_NE(errorOf("{segmenter: $TSG_NOT_SET/a, image_encoder: clip.onnx, embedding_size: 8}")
                .find("'segmenter': path '$TSG_NOT_SET/a': the environment variable"),
            std::string::npos);
}

TEST_F(ModelSetTest, AllMissingFilesAreNamedAtOnce) {
  touch("seg.onnx");
  const std::string error = errorOf(
      "{segmenter: seg.onnx, image_encoder: no_clip.onnx, tokenizer: no_bpe.txt, "
      "embedding_size: 8, image_std: [1, 1]}");
  EXPECT_NE(error.find("models.yaml"), std::string::npos) << error;
  EXPECT_NE(error.find("'image_encoder': file '"), std::string::npos) << error;
  EXPECT_NE(error.find("no_clip.onnx' is not there"), std::string::npos) << error;
  EXPECT_NE(error.find("no_bpe.txt' is not there"), std::string::npos) << error;
  EXPECT_NE(error.find("'image_std' has 2 numbers, expected 3"), std::string::npos) << error;
  EXPECT_EQ(error.find("seg.onnx'"), std::string::npos) << error;
}

TEST_F(ModelSetTest, AFileNotNamedAtAllIsAnError) {
  const std::string error = errorOf("{embedding_size: 8}");
  EXPECT_NE(error.find("'segmenter' names no file"), std::string::npos) << error;
  EXPECT_NE(error.find("'image_encoder' names no file"), std::string::npos) << error;
}

TEST_F(ModelSetTest, UnknownKeysMissingSizeAndZeroDeviationAreErrors) {
  const std::string error =
      errorOf("{segmentor: seg.onnx, image_std: [0.2, 0.0, 0.2], segmenter_iou_threshold: 2}");
  EXPECT_NE(error.find("unknown parameter 'segmentor', did you mean 'segmenter'?"),
            std::string::npos)
      << error;
  EXPECT_NE(error.find("'embedding_size' is 0"), std::string::npos) << error;
  EXPECT_NE(error.find("'image_std' is 0"), std::string::npos) << error;
  EXPECT_NE(error.find("'segmenter_iou_threshold' is 2"), std::string::npos) << error;
}

TEST_F(ModelSetTest, TheSharedSetLoads) {
  TSG_REQUIRE_SHARED(path, "models/models.yaml");
  const ModelSet models = loadModelSet(path.string());
  EXPECT_EQ(models.name, "coco-segmenter_conse-encoder");
  EXPECT_EQ(models.embedding_size, 384);
  EXPECT_DOUBLE_EQ(models.segmenter_score_threshold, 0.05);
}

}  // namespace
}  // namespace tsg::segmentation
