// SPDX-License-Identifier: BSD-3-Clause
#include "resampling.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "task_scene_graph/core/vectorize.h"

namespace tsg::segmentation {
namespace {

// Pillow's fixed point: 8-bit values, 2 bits of headroom for the kernel's overshoot, in 32 bits.
constexpr int kFractionBits = 32 - 8 - 2;

/// Which source samples make up each wanted sample of one axis, and with which weights.
struct Kernel {
  struct Sample {
    int first = 0;             ///< index of the first source sample
    std::vector<int> weights;  ///< fixed point, sum close to 1 << kFractionBits
  };
  std::vector<Sample> samples;

  int begin() const { return samples.front().first; }
  int end() const { return samples.back().first + static_cast<int>(samples.back().weights.size()); }
};

/// Cubic convolution kernel with a = -1/2 [Keys81].
double computeCubic(double x) {
  constexpr double a = -0.5;
  x = std::abs(x);
  if (x < 1.0) return ((a + 2.0) * x - (a + 3.0)) * x * x + 1.0;
  if (x < 2.0) return ((x - 5.0) * x + 8.0) * x * a - 4.0 * a;
  return 0.0;
}

Kernel::Sample computeSample(int source_size, double scale, int index) {
  const double stretch = std::max(scale, 1.0);  // antialias when shrinking
  const double support = 2.0 * stretch;
  const double center = (index + 0.5) * scale;
  const int first = std::max(0, static_cast<int>(center - support + 0.5));
  const int last = std::min(source_size, static_cast<int>(center + support + 0.5));
  std::vector<double> weights;
  double sum = 0.0;
  for (int i = first; i < last; ++i) {
    weights.push_back(computeCubic((i - center + 0.5) * (1.0 / stretch)));
    sum += weights.back();
  }
  Kernel::Sample sample;
  sample.first = first;
  for (const double weight : weights) {
    const double fixed = weight / sum * (1 << kFractionBits);
    sample.weights.push_back(static_cast<int>(fixed + (fixed < 0.0 ? -0.5 : 0.5)));
  }
  return sample;
}

Kernel computeKernel(int source_size, int resized, int first, int count) {
  Kernel kernel;
  const double scale = static_cast<double>(source_size) / resized;
  for (int i = first; i < first + count; ++i) {
    kernel.samples.push_back(computeSample(source_size, scale, i));
  }
  return kernel;
}

std::uint8_t toByte(int fixed) {
  return static_cast<std::uint8_t>(std::clamp(fixed >> kFractionBits, 0, 255));
}

constexpr int kHalf = 1 << (kFractionBits - 1);

/// One row along x. Four bytes are read per pixel, the last one for nothing, so that one vector
/// holds them: `source` has one byte more than its pixels.
TSG_VECTORIZE void resizeRow(const std::uint8_t* source, const Kernel& kernel, std::uint8_t* to) {
  for (const Kernel::Sample& sample : kernel.samples) {
    const std::uint8_t* from = source + 3 * sample.first;
    int sum[4] = {kHalf, kHalf, kHalf, kHalf};
    for (const int weight : sample.weights) {
      for (int c = 0; c < 4; ++c) sum[c] += weight * from[c];
      from += 3;
    }
    for (int c = 0; c < 3; ++c) *to++ = toByte(sum[c]);
  }
}

/// Source rows [first_row, last_row), each resized along x.
cv::Mat resizeColumns(const cv::Mat& image, const Kernel& kernel, int first_row, int last_row) {
  cv::Mat result(last_row - first_row, static_cast<int>(kernel.samples.size()), CV_8UC3);
  const auto num_bytes = static_cast<std::size_t>(3 * image.cols);
  std::vector<std::uint8_t> source(num_bytes + 1);
  for (int v = 0; v < result.rows; ++v) {
    std::copy_n(image.ptr<std::uint8_t>(v + first_row), num_bytes, source.begin());
    resizeRow(source.data(), kernel, result.ptr<std::uint8_t>(v));
  }
  return result;
}

TSG_VECTORIZE void addWeighted(const std::uint8_t* from, int weight, std::size_t count, int* sums) {
  for (std::size_t i = 0; i < count; ++i) sums[i] += weight * from[i];
}

TSG_VECTORIZE void toBytes(const int* sums, std::size_t count, std::uint8_t* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = toByte(sums[i]);
}

/// Resized along y; row 0 of `image` is source row `first_row`.
cv::Mat resizeRows(const cv::Mat& image, const Kernel& kernel, int first_row) {
  cv::Mat result(static_cast<int>(kernel.samples.size()), image.cols, CV_8UC3);
  std::vector<int> sums(static_cast<std::size_t>(3 * image.cols));
  for (int v = 0; v < result.rows; ++v) {
    const Kernel::Sample& sample = kernel.samples[static_cast<std::size_t>(v)];
    std::fill(sums.begin(), sums.end(), kHalf);
    int row = sample.first - first_row;
    for (const int weight : sample.weights) {
      addWeighted(image.ptr<std::uint8_t>(row++), weight, sums.size(), sums.data());
    }
    toBytes(sums.data(), sums.size(), result.ptr<std::uint8_t>(v));
  }
  return result;
}

void check(const cv::Mat& image, cv::Size resized, cv::Rect window) {
  const bool valid = image.type() == CV_8UC3 && !image.empty() && !window.empty() &&
                     (window & cv::Rect({0, 0}, resized)) == window;
  if (valid) return;
  throw std::invalid_argument(
      "resizing a " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
      " image of OpenCV type " + cv::typeToString(image.type()) + " to " +
      std::to_string(resized.width) + "x" + std::to_string(resized.height) +
      ", expected CV_8UC3, sizes that are not 0, and a window inside the result");
}

}  // namespace

cv::Mat resizeBicubic(const cv::Mat& image, cv::Size resized_px, cv::Rect window_px) {
  check(image, resized_px, window_px);
  const Kernel along_x = computeKernel(image.cols, resized_px.width, window_px.x, window_px.width);
  const Kernel along_y =
      computeKernel(image.rows, resized_px.height, window_px.y, window_px.height);
  const cv::Mat narrow = resizeColumns(image, along_x, along_y.begin(), along_y.end());
  return resizeRows(narrow, along_y, along_y.begin());
}

}  // namespace tsg::segmentation
