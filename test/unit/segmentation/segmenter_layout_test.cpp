// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/segmenter_layout.h"

#include <gtest/gtest.h>

#include <limits>

namespace tsg::segmentation {
namespace {

using Shape = std::vector<std::int64_t>;

std::size_t countValues(const Shape& shape) {
  std::size_t count = 1;
  for (const std::int64_t size : shape) count *= static_cast<std::size_t>(size);
  return count;
}

/// The outputs of a network of which the first is filled with `value`, the others with zeros.
struct FakeRun {
  FakeRun(const std::vector<Shape>& shapes, float value) {
    for (const Shape& shape : shapes) {
      infos.push_back({"output" + std::to_string(infos.size()), "float32", shape});
      data.emplace_back(countValues(shape), data.empty() ? value : 0.0F);
      outputs.push_back({shape, data.back().data(), nullptr});
    }
  }

  std::vector<TensorInfo> infos;
  std::vector<std::vector<float>> data;
  std::vector<TensorView> outputs;
};

std::string errorOf(const FakeRun& run, int input_size_px = 640) {
  try {
    findSegmenterLayout(run.infos, run.outputs, input_size_px, "file.onnx");
  } catch (const InferenceError& e) {
    return e.what();
  }
  return "";
}

void expectWords(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << word << " is not in: " << text;
  }
}

/// Plausible candidates of a 640 px input: centres all over it, boxes of 10 px, scores of 0.1.
FakeRun makePlausible(int classes, bool anchors_first = false) {
  const std::int64_t rows = 4 + classes + 32;
  FakeRun run({anchors_first ? Shape{1, 8400, rows} : Shape{1, rows, 8400}, {1, 32, 160, 160}},
              0.1F);
  const auto at = [&](std::int64_t row, std::int64_t anchor) -> float& {
    return run.data[0][static_cast<std::size_t>(anchors_first ? anchor * rows + row
                                                              : row * 8400 + anchor)];
  };
  for (std::int64_t a = 0; a < 8400; ++a) {
    at(0, a) = at(1, a) = 640.0F * static_cast<float>(a) / 8400.0F;
    at(2, a) = at(3, a) = 10.0F;
  }
  return run;
}

TEST(SegmenterLayout, FastSamsAndThoseOfSeveralClassesAreRecognised) {
  for (const int classes : {1, 2, 80, 365}) {
    const FakeRun run = makePlausible(classes);
    const SegmenterLayout layout = findSegmenterLayout(run.infos, run.outputs, 640, "file.onnx");
    EXPECT_FALSE(layout.are_anchors_first);
    const RawDetections raw = interpretOutputs(run.outputs, layout, "file.onnx");
    EXPECT_EQ(raw.num_classes, classes);
    EXPECT_EQ(raw.num_anchors, 8400U);
    EXPECT_EQ(raw.num_prototypes, 32);
    EXPECT_EQ(raw.prototype_size_px, 160);
  }
}

TEST(SegmenterLayout, ExchangedRowsAndColumnsOfOneClassAreExchangedBack) {
  const FakeRun run = makePlausible(1, true);
  const SegmenterLayout layout = findSegmenterLayout(run.infos, run.outputs, 640, "file.onnx");
  EXPECT_TRUE(layout.are_anchors_first);
  const RawDetections raw = interpretOutputs(run.outputs, layout, "file.onnx");
  const FakeRun usual = makePlausible(1);
  EXPECT_TRUE(std::equal(usual.data[0].begin(), usual.data[0].end(), raw.predictions));
}

TEST(SegmenterLayout, ShapesOfOtherNetworksAreRefusedWithTheirUsualCause) {
  const Shape prototypes = {1, 32, 160, 160};
  const std::pair<std::vector<Shape>, std::vector<std::string>> cases[] = {
      {{{1, 300, 38}, prototypes}, {"NMS inside", "nms=False", "end2end=False"}},
      {{{1, 100, 38}, prototypes}, {"NMS inside"}},
      {{{1, 0, 38}, prototypes}, {"NMS inside"}},  // nothing found, sizes open
      {{{1, 25200, 117}, prototypes}, {"YOLOv5", "objectness"}},
      {{{1, 25200, 38}, prototypes}, {"YOLOv5"}},
      {{{1, 102000, 117}, prototypes}, {"YOLOv5"}},  // with strides of 4 to 32
      {{{1, 8400, 38}, prototypes}, {"NMS inside"}},
      {{{1, 8400, 116}, prototypes}, {"rows and columns exchanged"}},
      {{{1, 36, 8400}, prototypes}, {"no row for a score"}},
      {{{1, 116, 0}, prototypes}, {"neither"}},
      {{{1, 300, 100}, prototypes}, {"neither"}},
      {{{2, 37, 8400}, prototypes}, {"more than one image"}},
      {{{1, 37, 8400}, {2, 32, 160, 160}}, {"more than one image", "batch=1"}},
      {{{1, 37, 8400}, {1, 160, 160, 32}}, {"channels last"}},
      {{{1, 37, 8400}, {1, 32, 120, 160}}, {"square grid"}},
      {{{1, 37, 8400}, {1, 32, 0, 0}}, {"empty"}},
      {{{1, 84, 8400}}, {"no mask prototypes", "boxes only"}},
      {{{1, 300, 6}}, {"no mask prototypes"}},
      {{{1, 300, 84}}, {"no mask prototypes"}},       // RT-DETR
      {{{1, 256, 64, 64}}, {"expected one output"}},  // SAM's image encoder
      {{{1, 300, 4}, {1, 300, 91}, {1, 300, 108, 108}}, {"expected one output"}},  // RF-DETR
      {{{7, 4}, {7}, {7}, {7, 1, 640, 640}}, {"expected one output"}},             // Mask R-CNN
      {{{1, 1000}}, {"expected one output"}}};
  for (const auto& [shapes, words] : cases) {
    const std::string error = errorOf(FakeRun(shapes, 0.0F));
    expectWords(error, words);
    expectWords(error, {"segmenter 'file.onnx'", toText(shapes[0]), "scripts/export_models"});
  }
}

TEST(SegmenterLayout, FewCandidatesOfASmallInputAreNoOtherLayout) {
  FakeRun run({{1, 38, 21}, {1, 32, 8, 8}}, 0.5F);  // 32 px
  EXPECT_EQ(errorOf(run, 32), "");
  run = FakeRun({{1, 116, 84}, {1, 32, 16, 16}}, 0.5F);  // 64 px: more rows than candidates
  std::fill_n(run.data[0].begin(), 168, 30.0F);
  EXPECT_EQ(errorOf(run, 64), "");
}

TEST(SegmenterLayout, OutputsThatAreNoFloatsAreNamedWithTheirType) {
  FakeRun run = makePlausible(1);
  run.infos[0].element_type = "float64";
  run.outputs[0].values = nullptr;
  expectWords(errorOf(run), {"output0 float64[1,37,8400]", "expected one output"});
}

TEST(SegmenterLayout, BoxesInSharesOfTheImageAreRefused) {
  FakeRun run = makePlausible(1);
  for (std::size_t i = 0; i < 4 * 8400; ++i) run.data[0][i] /= 640.0F;
  expectWords(errorOf(run), {"its boxes reach 0.9", "expected pixels"});
}

TEST(SegmenterLayout, BoxesByTwoCornersAreRefused) {
  FakeRun run = makePlausible(1);
  for (std::size_t i = 2 * 8400; i < 4 * 8400; ++i) run.data[0][i] += run.data[0][i - 2 * 8400];
  expectWords(errorOf(run), {"two corners"});
}

TEST(SegmenterLayout, ScoresOutsideZeroToOneAreRefused) {
  for (const float score : {-7.0F, 1.5F}) {
    FakeRun run = makePlausible(1);
    run.data[0][4 * 8400 + 17] = score;
    expectWords(errorOf(run), {"its scores run from", "expected 0 to 1"});
  }
}

TEST(SegmenterLayout, ValuesThatAreNotFiniteAreRefused) {
  const std::pair<std::size_t, const char*> places[] = {
      {3, "a box"}, {4 * 8400 + 3, "a score"}, {9 * 8400, "a mask value"}};
  for (const auto& [place, word] : places) {
    FakeRun run = makePlausible(1);
    run.data[0][place] = std::numeric_limits<float>::quiet_NaN();
    expectWords(errorOf(run), {word, "not finite"});
  }
  FakeRun run = makePlausible(1);
  run.data[1].back() = std::numeric_limits<float>::infinity();
  expectWords(errorOf(run), {"a mask value is not finite"});
}

TEST(SegmenterLayout, InputsMayLeaveSizesOpen) {
  for (const Shape& shape :
       {Shape{1, 3, 640, 640}, Shape{-1, 3, -1, -1}, Shape{-1, -1, -1, -1}, Shape{1, 3, 640, -1}}) {
    EXPECT_EQ(explainSegmenterInputs({{"images", "float32", shape}}), "") << toText(shape);
    EXPECT_EQ(explainSegmenterInputs({{"images", "float16", shape}}), "") << toText(shape);
  }
}

TEST(SegmenterLayout, InputsOfOtherNetworksAreExplained) {
  const TensorInfo image{"images", "float32", {1, 3, 640, 640}};
  expectWords(explainSegmenterInputs({image, {"point_coords", "float32", {1, -1, 2}}}),
              {"something else than one image"});
  expectWords(explainSegmenterInputs({}), {"something else"});
  expectWords(explainSegmenterInputs({{"images", "float32", {1, 1, 640, 640}}}),
              {"1 channels", "for red, green, blue"});
  expectWords(explainSegmenterInputs({{"images", "float64", {1, 3, 640, 640}}}),
              {"pixels as float64"});
  expectWords(explainSegmenterInputs({{"images", "float32", {3, 640, 640}}}), {"something else"});
}

TEST(SegmenterLayout, ARunOfAnotherShapeThanTheFirstIsRefused) {
  const FakeRun run({{1, 30, 8400}, {1, 32, 160, 160}}, 0.0F);
  EXPECT_THROW(interpretOutputs(run.outputs, {}, "file.onnx"), InferenceError);
}

}  // namespace
}  // namespace tsg::segmentation
