// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/model_set.h"

#include <gtest/gtest.h>

#include <filesystem>
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

TEST_F(ModelSetTest, TheResultKnowsItsFile) {
  touch("seg.onnx");
  touch("clip.onnx");
  const std::string path = write(
      "{name: tiny, segmenter: seg.onnx, image_encoder: clip.onnx, embedding_size: 8, "
      "image_encoder_output: pooler_output, text_encoder_output: e, text_context_length: 32}");
  const ModelSet models = loadModelSet(path);
  EXPECT_EQ(models.file, path);
  EXPECT_EQ(describe(models), "model set 'tiny' (" + path + ")");
  EXPECT_EQ(models.image_encoder_output, "pooler_output");
  EXPECT_EQ(models.text_encoder_output, "e");
  EXPECT_EQ(models.text_context_length, 32);
  EXPECT_EQ(describe(ModelSet{}), "model set ''");
}

/// Makes a folder the current one while it lives.
class CurrentFolder {
 public:
  explicit CurrentFolder(const std::filesystem::path& folder)
      : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~CurrentFolder() { std::filesystem::current_path(before_); }

 private:
  std::filesystem::path before_;
};

TEST_F(ModelSetTest, PathsAreAbsoluteAlsoIfTheFilesIsNot) {
  touch("seg.onnx");
  touch("clip.onnx");
  write("{segmenter: seg.onnx, image_encoder: clip.onnx, embedding_size: 8}");
  ModelSet models;
  {
    const CurrentFolder current(folder_.path());
    models = loadModelSet("models.yaml");
  }
  EXPECT_EQ(models.segmenter, (folder_.path() / "seg.onnx").string());
  EXPECT_EQ(models.file, (folder_.path() / "models.yaml").string());
}

TEST_F(ModelSetTest, MissingFilesAreNamedWithTheWholePathLookedFor) {
  write("{segmenter: a/../seg.onnx, image_encoder: ../clip.onnx, embedding_size: 8}");
  const CurrentFolder current(folder_.path());
  try {
    loadModelSet("models.yaml");
    FAIL();
  } catch (const config::ConfigError& e) {
    const std::string error = e.what();
    for (const std::filesystem::path& path :
         {folder_.path() / "models.yaml", folder_.path() / "seg.onnx",
          folder_.path().parent_path() / "clip.onnx"}) {
      EXPECT_NE(error.find("'" + path.string() + "'"), std::string::npos) << path << ' ' << error;
    }
  }
}

TEST_F(ModelSetTest, FoldersInPlaceOfFilesAreReported) {
  std::filesystem::create_directory(folder_.path() / "seg");
  touch("clip.onnx");
  const std::string error =
      errorOf("{segmenter: seg, image_encoder: clip.onnx, embedding_size: 8}");
  EXPECT_NE(error.find("/seg' is a folder"), std::string::npos) << error;
  try {
    loadModelSet(folder_.path().string());
    FAIL();
  } catch (const config::ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find(folder_.path().string()), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("it is a folder"), std::string::npos) << e.what();
  }
}

TEST_F(ModelSetTest, AMissingFileIsNamedWithTheWholePath) {
  const CurrentFolder current(folder_.path());
  try {
    loadModelSet("no_such.yaml");
    FAIL();
  } catch (const config::ConfigError& e) {
    EXPECT_EQ(std::string(e.what()), "model set '" + (folder_.path() / "no_such.yaml").string() +
                                         "':\n  the file is not there");
  }
}

TEST_F(ModelSetTest, WhateverIsWrongTheFileIsNamed) {
  touch("seg.onnx");
  touch("clip.onnx");
  const std::string good = "segmenter: seg.onnx, image_encoder: clip.onnx, embedding_size: 8";
  for (const std::string& yaml :
       {std::string(""), std::string("- a list"), std::string("just text"), std::string("{a: [}"),
        std::string("? [a, b]\n: c\n"), std::string("\x01\x02"), "{" + good + ", alpha: high}",
        "{" + good + ", alpha: .nan}", "{" + good + ", image_mean: [.nan, 0.4, 0.4]}",
        "{" + good + ", image_mean: [.inf, 0.4, 0.4]}",
        "{" + good + ", image_std: [.nan, 0.4, 0.4]}", "{" + good + ", image_mean: {r: 1}}",
        "{" + good + ", text_context_length: 1}", "{" + good + ", embedding_size: 512.5}",
        "{" + good + ", [x]: y}"}) {
    const std::string error = errorOf(yaml);
    EXPECT_NE(error.find((folder_.path() / "models.yaml").string()), std::string::npos)
        << yaml << " gives: " << error;
  }
}

TEST_F(ModelSetTest, MeansAndDeviationsOfValuesUpTo255AreRefused) {
  touch("seg.onnx");
  touch("clip.onnx");
  const std::string error = errorOf(
      "{segmenter: seg.onnx, image_encoder: clip.onnx, embedding_size: 8, "
      "image_mean: [123.675, 116.28, 103.53], image_std: [58.395, 57.12, 57.375]}");
  EXPECT_NE(error.find("'image_mean' is 123.675, expected a value in [0, 1]"), std::string::npos)
      << error;
  EXPECT_NE(error.find("'image_std' is 58.395"), std::string::npos) << error;
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
