// SPDX-License-Identifier: BSD-3-Clause
// The same files in ONNX Runtime and in OpenCV's own runtime give the same numbers.
#include <gtest/gtest.h>

#include <numeric>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "networks.h"

namespace tsg::segmentation {
namespace {

/// Smooth noise in 0..1, [1, 3, S, S].
cv::Mat makeInput(int side) {
  const int shape[] = {1, 3, side, side};
  cv::Mat input(4, shape, CV_32FC1);
  cv::RNG random(3);
  for (int c = 0; c < 3; ++c) {
    cv::Mat coarse(9, 11, CV_32FC1);
    random.fill(coarse, cv::RNG::UNIFORM, 0.0, 1.0);
    cv::Mat plane(side, side, CV_32FC1, input.ptr<float>(0, c));
    cv::resize(coarse, plane, plane.size(), 0, 0, cv::INTER_LINEAR);
  }
  return input;
}

/// All outputs, by the file's order of names.
std::vector<cv::Mat> runInOpenCv(const Network& network, const cv::Mat& input) {
  cv::dnn::Net net = cv::dnn::readNetFromONNX(network.path());
  net.setInput(input);
  std::vector<std::string> names;
  for (const TensorInfo& output : network.outputs()) names.push_back(output.name);
  std::vector<cv::Mat> outputs;
  net.forward(outputs, names);
  return outputs;
}

/// Largest difference of any output, relative to that output's largest value (1 at least).
double compareRuntimes(const std::string& path, int side) {
  const Network network(path, {});
  const cv::Mat input = makeInput(side);
  const auto ours = network.run({{1, 3, side, side}, input.ptr<float>(), nullptr});
  const auto theirs = runInOpenCv(network, input);
  EXPECT_EQ(ours.size(), theirs.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const auto count = std::accumulate(ours[i].shape.begin(), ours[i].shape.end(), std::int64_t{1},
                                       std::multiplies<>());
    EXPECT_EQ(static_cast<std::int64_t>(theirs[i].total()), count);
    const cv::Mat flat(1, static_cast<int>(count), CV_32FC1, const_cast<float*>(ours[i].values));
    const double difference = cv::norm(flat, theirs[i].reshape(1, 1), cv::NORM_INF);
    largest = std::max(largest, difference / std::max(1.0, cv::norm(flat, cv::NORM_INF)));
  }
  return largest;
}

TEST(SecondRuntime, AgreesOnTheDemoModels) {
  TSG_REQUIRE_ENGINE();
  const std::string folder = TSG_SOURCE_DIR "/models/demo/";
  EXPECT_LT(compareRuntimes(folder + "segmenter.onnx", 384), 1e-4);
  EXPECT_LT(compareRuntimes(folder + "image_encoder.onnx", 64), 1e-4);
}

TEST(SecondRuntime, AgreesOnRealWeights) {
  TSG_REQUIRE_ENGINE();
  TSG_REQUIRE_SHARED(folder, "models");
  EXPECT_LT(compareRuntimes((folder / "segmenter_coco_640.onnx").string(), 640), 1e-4);
  EXPECT_LT(compareRuntimes((folder / "image_encoder_conse_224.onnx").string(), 224), 1e-4);
}

TEST(SecondRuntime, AgreesOnTheTestNetwork) {
  TSG_REQUIRE_ENGINE();
  EXPECT_LT(compareRuntimes(findNetwork("encoder"), 8), 1e-4);
}

}  // namespace
}  // namespace tsg::segmentation
