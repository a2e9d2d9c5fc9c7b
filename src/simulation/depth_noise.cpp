// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/parallel.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg::simulation {
namespace {

constexpr double kEdgeStep = 0.04;  ///< relative jump of depth that makes an edge

std::uint16_t roundToMillimetres(double z_m) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(z_m * 1000.0), 0L, 65534L));
}

void requireFloatImage(const cv::Mat& depth_m) {
  if (depth_m.type() != CV_32FC1) {
    throw std::invalid_argument("depth image of OpenCV type " + std::to_string(depth_m.type()) +
                                ", expected CV_32FC1 (metres)");
  }
}

class Sensor {
 public:
  Sensor(const cv::Mat& depth_m, const CameraModel& camera, const DepthNoiseConfig& config,
         std::uint64_t seed)
      : depth_m_(depth_m), camera_(camera), config_(config), seed_(seed) {}

  std::uint16_t measure(int u, int v) const {
    const auto z = static_cast<double>(depth_m_.at<float>(v, u));
    const auto pixel = static_cast<std::uint64_t>(v) * 65536U + static_cast<std::uint64_t>(u);
    const std::uint64_t bits = combineSeeds(seed_, pixel);
    if (z < config_.min_range_m || z > config_.max_range_m || isDropped(u, v, z, mixBits(bits))) {
      return 0;
    }
    const double noisy = z + toNormal(bits) * (config_.axial_m + config_.axial_per_m * z * z);
    return roundToMillimetres(quantise(std::max(noisy, 0.05)));
  }

 private:
  double at(int u, int v) const {
    return static_cast<double>(depth_m_.at<float>(std::clamp(v, 0, depth_m_.rows - 1),
                                                  std::clamp(u, 0, depth_m_.cols - 1)));
  }

  bool isDropped(int u, int v, double z, std::uint64_t bits) const {
    const double chance = toUnitInterval(bits);
    const double steps[4] = {at(u - 1, v) - z, at(u + 1, v) - z, at(u, v - 1) - z,
                             at(u, v + 1) - z};
    const double cosine = computeCosine(u, v, z, steps);
    // Seen edge-on, a plane has steps as large as an edge's, but alike on both sides.
    const double jump = std::max(std::abs(steps[0] + steps[1]), std::abs(steps[2] + steps[3]));
    if (jump > kEdgeStep * z) return chance < config_.edge_dropout;
    return chance > cosine / std::max(config_.grazing_cosine, 1e-9);
  }

  /// Between the ray and the normal of the plane through the neighbours.
  double computeCosine(int u, int v, double z, const double (&steps)[4]) const {
    const auto slope = [](double before, double after) {
      return std::abs(before) < std::abs(after) ? -before : after;  // the flatter side
    };
    const double zu = slope(steps[0], steps[1]) * camera_.fx_px / z;
    const double zv = slope(steps[2], steps[3]) * camera_.fy_px / z;
    const double x = (u - camera_.cx_px) / camera_.fx_px;
    const double y = (v - camera_.cy_px) / camera_.fy_px;
    // Normal of z(x, y): (zu, zv, -(1 + x zu + y zv)) up to scale; its product with (x, y, 1) is
    // -1.
    const double nz = 1.0 + x * zu + y * zv;
    return 1.0 / std::sqrt((zu * zu + zv * zv + nz * nz) * (x * x + y * y + 1.0));
  }

  double quantise(double z) const {
    if (config_.subpixel_px <= 0.0) return z;
    const double scale = camera_.fx_px * config_.baseline_m / config_.subpixel_px;
    return scale / std::max(1.0, std::round(scale / z));
  }

  const cv::Mat& depth_m_;
  const CameraModel& camera_;
  const DepthNoiseConfig& config_;
  std::uint64_t seed_;
};

}  // namespace

cv::Mat simulateDepthSensor(const cv::Mat& depth_m, const CameraModel& camera,
                            const DepthNoiseConfig& config, std::uint64_t seed, std::int64_t frame,
                            int num_threads) {
  config::validate(config, "depth noise");
  camera.validate();
  requireFloatImage(depth_m);
  const Sensor sensor(depth_m, camera, config,
                      combineSeeds(seed, static_cast<std::uint64_t>(frame)));
  cv::Mat measured(depth_m.size(), CV_16UC1);
  parallelFor(static_cast<std::size_t>(depth_m.rows), num_threads, [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < depth_m.cols; ++u) {
      measured.at<std::uint16_t>(v, u) = sensor.measure(u, v);
    }
  });
  return measured;
}

cv::Mat toMillimetres(const cv::Mat& depth_m, double min_range_m, double max_range_m) {
  requireFloatImage(depth_m);
  cv::Mat result(depth_m.size(), CV_16UC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    for (int u = 0; u < depth_m.cols; ++u) {
      const auto z = static_cast<double>(depth_m.at<float>(v, u));
      const bool seen = z >= min_range_m && z <= max_range_m;
      result.at<std::uint16_t>(v, u) = seen ? roundToMillimetres(z) : std::uint16_t{0};
    }
  }
  return result;
}

}  // namespace tsg::simulation
