// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/clip_signature.h"

#include <gtest/gtest.h>

namespace tsg::segmentation {
namespace {

using Shape = std::vector<std::int64_t>;

TensorInfo images(const Shape& shape, const char* type = "float32") {
  return {"pixel_values", type, shape};
}
TensorInfo tokens(const char* name = "input_ids", const Shape& shape = {-1, 77}) {
  return {name, "int64", shape};
}
const TensorInfo kMask{"attention_mask", "int64", {-1, 77}};

TEST(ClipInputs, EncodersAloneAndBothInOneAreRecognised) {
  for (const Shape& shape : {Shape{-1, 3, 224, 224}, Shape{1, 3, 224, 224}, Shape{-1, 3, -1, -1},
                             Shape{-1, -1, -1, -1}, Shape{-1, 3, 224, -1}}) {
    EXPECT_EQ(explainClipInputs(Modality::kImage, {images(shape)}), "") << toText(shape);
  }
  EXPECT_EQ(explainClipInputs(Modality::kImage, {images({1, 3, 8, 8}, "float16")}), "");
  EXPECT_EQ(explainClipInputs(Modality::kText, {tokens()}), "");
  EXPECT_EQ(explainClipInputs(Modality::kText, {{"text", "int32", {4, 77}}}), "");
  EXPECT_EQ(explainClipInputs(Modality::kText, {kMask, tokens()}), "");
  for (const Modality modality : {Modality::kImage, Modality::kText}) {
    EXPECT_EQ(explainClipInputs(modality, {tokens(), images({-1, 3, -1, -1}), kMask}), "");
  }
}

TEST(ClipInputs, OfOtherNetworksAreExplained) {
  struct Case {
    Modality modality;
    std::vector<TensorInfo> inputs;
    const char* words;
  };
  const Case cases[] = {
      {Modality::kImage, {tokens()}, "a text encoder?"},
      {Modality::kText, {images({-1, 3, 224, 224})}, "an image encoder?"},
      {Modality::kImage, {images({-1, 224, 224, 3})}, "channels last"},
      {Modality::kImage, {images({-1, 1, 224, 224})}, "1 channels"},
      {Modality::kImage, {images({-1, 3, 224, 224}, "uint8")}, "pixels as uint8"},
      {Modality::kImage, {images({-1, 3, 224, 336})}, "336x224 px"},
      {Modality::kImage, {images({3, 224, 224})}, "'pixel_values'"},
      {Modality::kImage, {images({-1, 3, 8, 8}), images({-1, 3, 8, 8})}, "several"},
      {Modality::kImage, {images({-1, 3, 8, 8}), kMask}, "more masks than tokens"},
      {Modality::kText, {{"text", "float32", {-1, 77}}}, "'text' is float32"},
      {Modality::kText, {{"text", "string", {-1}}}, "'text'"},
      {Modality::kText, {tokens(), tokens("token_type_ids"), kMask}, "BERT's"},
      {Modality::kText, {tokens(), tokens("position_ids")}, "'position_ids'"},
      {Modality::kText, {tokens(), tokens("more_ids")}, "several"},
      {Modality::kText, {}, "no tokens"}};
  for (const Case& c : cases) {
    const std::string why = explainClipInputs(c.modality, c.inputs);
    EXPECT_NE(why.find(c.words), std::string::npos) << c.words << " is not in: " << why;
  }
}

struct Output {
  const char* name;
  Shape shape;
};

/// Name of the output found, or the error.
std::string find(const std::vector<Output>& outputs, Modality modality,
                 const std::string& wanted = "", std::int64_t count = 2) {
  static const float value = 0.0F;
  std::vector<TensorInfo> infos;
  std::vector<TensorView> views;
  for (const Output& output : outputs) {
    infos.push_back({output.name, "float32", output.shape});
    views.push_back({output.shape, &value, nullptr});
  }
  try {
    return infos[findEmbeddingOutput(
                     infos, views,
                     {modality, count, 512, wanted, "encoder 'x.onnx'", "model set 'm'"})]
        .name;
  } catch (const InferenceError& e) {
    return e.what();
  }
}

TEST(EmbeddingOutput, IsFoundByNameElseByShape) {
  const Modality image = Modality::kImage;
  const Modality text = Modality::kText;
  EXPECT_EQ(find({{"anything", {2, 512}}}, image), "anything");
  EXPECT_EQ(find({{"features", {2, 512, 1, 1}}}, image), "features");
  EXPECT_EQ(find({{"features", {2, 1, 512}}}, image), "features");
  EXPECT_EQ(find({{"last_hidden_state", {2, 50, 768}}, {"image_embeds", {2, 512}}}, image),
            "image_embeds");
  EXPECT_EQ(find({{"image_embeds", {2, 512}}, {"text_embeds", {2, 512}}}, text), "text_embeds");
  EXPECT_EQ(find({{"image_embeds", {2, 512}}, {"output", {2, 512}}}, text), "output");
  EXPECT_EQ(
      find({{"last_hidden_state", {2, 77, 512}}, {"pooler_output", {2, 512}}, {"1771", {2, 512}}},
           text),
      "1771");
}

TEST(EmbeddingOutput, TheModelSetsChoiceComesFirst) {
  const std::vector<Output> outputs = {{"last_hidden_state", {2, 196, 512}},
                                       {"pooler_output", {2, 512}},
                                       {"image_embeds", {2, 512}}};
  EXPECT_EQ(find(outputs, Modality::kImage, "pooler_output"), "pooler_output");
  const std::string absent = find(outputs, Modality::kImage, "embedding");
  EXPECT_NE(absent.find("image_encoder_output is 'embedding', which is none of them"),
            std::string::npos)
      << absent;
  const std::string hidden = find(outputs, Modality::kImage, "last_hidden_state");
  EXPECT_NE(hidden.find("'last_hidden_state' is [2,196,512], the hidden states"), std::string::npos)
      << hidden;
}

TEST(EmbeddingOutput, WhatIsNoEmbeddingIsRefusedWithAllOutputsAndWhatToDo) {
  struct Case {
    std::vector<Output> outputs;
    Modality modality;
    std::vector<std::string> words;
  };
  const Case cases[] = {
      {{{"last_hidden_state", {2, 77, 512}}},
       Modality::kText,
       {"'last_hidden_state' is [2,77,512], the hidden states", "CLIPTextModelWithProjection"}},
      {{{"last_hidden_state", {2, 50, 768}}, {"pooler_output", {2, 768}}},
       Modality::kImage,
       {"embeddings of 768 values", "model set 'm' says embedding_size 512"}},
      {{{"last_hidden_state", {2, 77, 512}}, {"pooler_output", {2, 512}}},
       Modality::kText,
       {"before the projection", "CLIPTextModelWithProjection",
        "text_encoder_output: pooler_output"}},
      {{{"pooler_output", {2, 512}}},
       Modality::kImage,
       {"before the projection", "(SigLIP)", "image_encoder_output: pooler_output"}},
      {{{"text_embeds", {2, 77, 512}}, {"12", {2, 512}}}, Modality::kText, {"the hidden states"}},
      {{{"image_embeds", {2, 768}}}, Modality::kImage, {"embeddings of 768 values"}},
      {{{"a", {2, 512}}, {"b", {2, 512}}},
       Modality::kImage,
       {"2 of them could be", "image_encoder_output: a"}},
      {{{"logits", {2, 1000}}}, Modality::kImage, {"embeddings of 1000 values"}},
      {{{"embedding", {512}}}, Modality::kImage, {"not one row for each image"}},
      {{{"embedding", {1, 512}}}, Modality::kText, {"not one row for each text"}},
      {{{"map", {2, 512, 7, 7}}}, Modality::kImage, {"'map' is [2,512,7,7]"}}};
  for (const Case& c : cases) {
    const std::string error = find(c.outputs, c.modality);
    for (const std::string& word : c.words) {
      EXPECT_NE(error.find(word), std::string::npos) << word << " is not in: " << error;
    }
    EXPECT_NE(error.find("encoder 'x.onnx' gives " + std::string(c.outputs[0].name)),
              std::string::npos)
        << error;
  }
}

TEST(EmbeddingOutput, OutputsOfOtherTypesAreNotTaken) {
  const std::vector<TensorInfo> infos = {{"embedding", "float64", {1, 512}}};
  const std::vector<TensorView> views = {{{1, 512}, nullptr, nullptr}};
  try {
    findEmbeddingOutput(infos, views, {Modality::kImage, 1, 512, "", "encoder", "m"});
    FAIL();
  } catch (const InferenceError& e) {
    EXPECT_NE(std::string(e.what()).find("of float64, not floats"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace tsg::segmentation
