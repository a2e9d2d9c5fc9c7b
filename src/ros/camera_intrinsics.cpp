// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/camera_intrinsics.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "task_scene_graph/config/scalar.h"
#include "task_scene_graph/config/yaml_text.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/source_image.h"

namespace tsg::ros_interface {
namespace {

constexpr auto kExpected =
    "expected 'fx,fy,cx,cy', 'fx,fy,cx,cy,width,height', a 3x3 or 4x4 matrix, or YAML as "
    "camera_calibration writes it";
constexpr double kNegligibleDistortion = 1e-9;

[[noreturn]] void failFormat(const std::string& source, const std::string& what) {
  throw InputError("intrinsics '" + source + "': " + what + "; " + kExpected, "bad intrinsics");
}

void setMatrix(sensor_msgs::CameraInfo& info, double fx, double fy, double cx, double cy) {
  info.K = {fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0};
}

std::optional<sensor_msgs::CameraInfo> fromNumbers(const std::vector<double>& n) {
  sensor_msgs::CameraInfo info;
  if (n.size() == 4 || n.size() == 6) {
    setMatrix(info, n[0], n[1], n[2], n[3]);
    if (n.size() == 6) {
      info.width = static_cast<std::uint32_t>(std::max(0.0, n[4]));
      info.height = static_cast<std::uint32_t>(std::max(0.0, n[5]));
    }
  } else if (n.size() == 9 || n.size() == 16) {
    const std::size_t row = n.size() == 9 ? 3 : 4;
    setMatrix(info, n[0], n[row + 1], n[2], n[row + 2]);
  } else {
    return std::nullopt;
  }
  return info;
}

std::vector<double> readData(const YAML::Node& matrix) {
  return (matrix.IsMap() ? matrix["data"] : matrix).as<std::vector<double>>();
}

template <typename Array>
void copyMatrix(const YAML::Node& yaml, const char* name, Array& target) {
  if (!yaml[name]) return;
  const auto values = readData(yaml[name]);
  if (values.size() != target.size()) {
    throw std::runtime_error(std::string(name) + " has " + std::to_string(values.size()) +
                             " values, expected " + std::to_string(target.size()));
  }
  std::copy(values.begin(), values.end(), target.begin());
}

/// As camera_info_manager reads it.
sensor_msgs::CameraInfo fromCalibration(const YAML::Node& yaml) {
  sensor_msgs::CameraInfo info;
  if (yaml["image_width"]) info.width = yaml["image_width"].as<std::uint32_t>();
  if (yaml["image_height"]) info.height = yaml["image_height"].as<std::uint32_t>();
  copyMatrix(yaml, "camera_matrix", info.K);
  copyMatrix(yaml, "rectification_matrix", info.R);
  copyMatrix(yaml, "projection_matrix", info.P);
  if (yaml["distortion_coefficients"]) info.D = readData(yaml["distortion_coefficients"]);
  info.distortion_model =
      yaml["distortion_model"] ? yaml["distortion_model"].as<std::string>() : "plumb_bob";
  return info;
}

sensor_msgs::CameraInfo fromKeys(const YAML::Node& yaml) {
  sensor_msgs::CameraInfo info;
  setMatrix(info, yaml["fx"].as<double>(), yaml["fy"].as<double>(), yaml["cx"].as<double>(),
            yaml["cy"].as<double>());
  if (yaml["width"]) info.width = yaml["width"].as<std::uint32_t>();
  if (yaml["height"]) info.height = yaml["height"].as<std::uint32_t>();
  if (yaml["distortion_coefficients"]) info.D = readData(yaml["distortion_coefficients"]);
  info.distortion_model =
      yaml["distortion_model"] ? yaml["distortion_model"].as<std::string>() : "plumb_bob";
  return info;
}

sensor_msgs::CameraInfo fromYaml(const std::string& text, const std::string& path) {
  const std::string endless = config::findEndlessBrackets(text);
  if (!endless.empty()) failFormat(path, endless);
  try {
    const YAML::Node yaml = YAML::Load(config::endLine(text));
    if (yaml.IsMap() && yaml["camera_matrix"]) return fromCalibration(yaml);
    if (yaml.IsMap() && yaml["fx"]) return fromKeys(yaml);
  } catch (const std::exception& e) {
    failFormat(path, e.what());
  }
  failFormat(path, "no camera_matrix, and no fx, in it");
}

std::string readFile(const std::string& name) {
  const std::string path = expandPath(name).string();
  std::ifstream file(path);
  if (!file) failFormat(path, "neither numbers nor a file that can be opened");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

template <typename Values>
void requireFinite(const Values& values, const char* name, const std::string& topic) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw InputError("camera_info on " + topic + " has " + name + "[" + std::to_string(i) +
                         "] = " + std::to_string(values[i]) + ", expected a finite number",
                     "bad intrinsics");
  }
}

bool isFisheye(const sensor_msgs::CameraInfo& info) {
  return info.distortion_model == "equidistant" || info.distortion_model == "fisheye" ||
         info.distortion_model == "kannala_brandt4";
}

void checkDistortion(const sensor_msgs::CameraInfo& info, const std::string& topic) {
  const std::size_t count = info.D.size();
  const bool is_known = isFisheye(info) || info.distortion_model.empty() ||
                        info.distortion_model == "plumb_bob" ||
                        info.distortion_model == "rational_polynomial";
  const bool is_fit = isFisheye(info)
                          ? count == 4
                          : count == 4 || count == 5 || count == 8 || count == 12 || count == 14;
  if (is_known && is_fit) return;
  throw InputError("camera_info on " + topic + " has distortion model '" + info.distortion_model +
                       "' with " + std::to_string(count) +
                       " coefficients, expected plumb_bob (4 or 5), rational_polynomial (8, 12 or "
                       "14) or equidistant (4)",
                   "bad intrinsics");
}

/// fx, fy, cx, cy of a 3x3 or the left of a 3x4 matrix.
template <typename Matrix>
CameraModel toModel(const Matrix& m, cv::Size size) {
  const std::size_t row = m.size() / 3;
  return {size.width, size.height, m[0], m[row + 1], m[2], m[row + 2]};
}

/// The sensor's pixels that the images were made of, by ROS's rules: cut out, then binned.
CameraModel cutAndBin(CameraModel camera, const sensor_msgs::CameraInfo& info, cv::Size size) {
  const double bin_x = std::max<std::uint32_t>(1, info.binning_x);
  const double bin_y = std::max<std::uint32_t>(1, info.binning_y);
  camera.fx_px /= bin_x;
  camera.fy_px /= bin_y;
  camera.cx_px = (camera.cx_px - info.roi.x_offset) / bin_x;
  camera.cy_px = (camera.cy_px - info.roi.y_offset) / bin_y;
  camera.width_px = size.width;
  camera.height_px = size.height;
  return camera;
}

cv::Size expectedSize(const sensor_msgs::CameraInfo& info) {
  const bool has_roi = info.roi.width > 0 && info.roi.height > 0;
  const std::uint32_t width = has_roi ? info.roi.width : info.width;
  const std::uint32_t height = has_roi ? info.roi.height : info.height;
  return {static_cast<int>(width / std::max<std::uint32_t>(1, info.binning_x)),
          static_cast<int>(height / std::max<std::uint32_t>(1, info.binning_y))};
}

std::string formatSize(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void checkSize(const sensor_msgs::CameraInfo& info, cv::Size size, const std::string& topic) {
  const cv::Size expected = expectedSize(info);
  if (expected.width == 0 || expected.height == 0 || expected == size) return;
  throw InputError("camera_info on " + topic + " is for " + formatSize(expected) +
                       ", the colour images are " + formatSize(size) +
                       "; expected the camera_info of these images (input/camera_info_topic, or "
                       "input/intrinsics)",
                   "sizes differ");
}

/// Of K and P, only one need be there; the one that is used must be whole.
void checkModel(const CameraModel& camera, const std::string& topic) {
  try {
    camera.validate();
  } catch (const std::invalid_argument& e) {
    throw InputError("camera_info on " + topic + ": " + e.what(), "bad intrinsics");
  }
}

cv::Mat toMatrix(const CameraModel& c) {
  return (cv::Mat_<double>(3, 3) << c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0);
}

/// R, or the identity where it is all zeros.
cv::Mat toRotation(const sensor_msgs::CameraInfo& info) {
  cv::Mat rotation = cv::Mat::eye(3, 3, CV_64F);
  if (std::all_of(info.R.begin(), info.R.end(), [](double r) { return r == 0.0; })) return rotation;
  std::copy(info.R.begin(), info.R.end(), rotation.ptr<double>());
  return rotation;
}

ImageWarpPtr makeRectification(const sensor_msgs::CameraInfo& info, const CameraModel& raw,
                               const CameraModel& rectified, const std::string& topic) {
  requireFinite(info.D, "D", topic);
  if (!hasDistortion(info)) return nullptr;
  requireFinite(info.R, "R", topic);
  checkDistortion(info, topic);
  const cv::Mat distortion(info.D, true);
  const cv::Mat rotation = toRotation(info);
  const cv::Size size(rectified.width_px, rectified.height_px);
  cv::Mat source_x;
  cv::Mat source_y;
  if (isFisheye(info)) {
    cv::fisheye::initUndistortRectifyMap(toMatrix(raw), distortion, rotation, toMatrix(rectified),
                                         size, CV_32FC1, source_x, source_y);
  } else {
    cv::initUndistortRectifyMap(toMatrix(raw), distortion, rotation, toMatrix(rectified), size,
                                CV_32FC1, source_x, source_y);
  }
  return std::make_shared<ImageWarp>(source_x, source_y, size);
}

}  // namespace

sensor_msgs::CameraInfo loadIntrinsics(const std::string& text_or_path) {
  const auto numbers = config::parseNumbers(text_or_path);
  std::optional<sensor_msgs::CameraInfo> info;
  if (numbers) {
    info = fromNumbers(*numbers);
    if (!info) failFormat(text_or_path, std::to_string(numbers->size()) + " numbers");
  } else {
    const std::string text = readFile(text_or_path);
    const auto in_file = config::parseNumbers(text);
    info = in_file ? fromNumbers(*in_file) : fromYaml(text, text_or_path);
    if (!info) failFormat(text_or_path, std::to_string(in_file->size()) + " numbers in the file");
  }
  checkCameraInfo(*info, "intrinsics '" + text_or_path + "'");
  return *info;
}

bool isRectifiedTopic(const std::string& image_topic) {
  std::string name = image_topic;
  if (const auto slash = name.rfind('/'); slash != std::string::npos && isCompressedTopic(name)) {
    name.erase(slash);
  }
  name = name.substr(name.rfind('/') + 1);
  std::istringstream parts(name);
  for (std::string part; std::getline(parts, part, '_');) {
    if (part == "rect" || part == "rectified") return true;
  }
  return false;
}

Intrinsics toIntrinsics(const sensor_msgs::CameraInfo& info, cv::Size size,
                        Rectification rectification, const std::string& topic) {
  checkCameraInfo(info, topic);
  checkSize(info, size, topic);
  const bool has_projection = info.P[0] > 0.0;
  const bool has_matrix = info.K[0] > 0.0;
  const CameraModel raw =
      cutAndBin(has_matrix ? toModel(info.K, size) : toModel(info.P, size), info, size);
  const CameraModel rectified = has_projection ? cutAndBin(toModel(info.P, size), info, size) : raw;
  checkModel(rectified, topic);
  if (rectification == Rectification::kWanted) {
    checkModel(raw, topic);
    const auto warp = makeRectification(info, raw, rectified, topic);
    return {warp ? rectified : raw, warp};
  }
  const bool is_distorted = hasDistortion(info) && rectification == Rectification::kIgnored;
  if (is_distorted) checkModel(raw, topic);
  return {is_distorted ? raw : rectified, nullptr};
}

void checkCameraInfo(const sensor_msgs::CameraInfo& info, const std::string& topic) {
  requireFinite(info.K, "K", topic);
  requireFinite(info.P, "P", topic);
  checkModel(info.P[0] > 0.0 ? toModel(info.P, {1, 1}) : toModel(info.K, {1, 1}), topic);
}

CameraModel resizeCamera(const CameraModel& camera, cv::Size size) {
  const double scale_x = static_cast<double>(size.width) / camera.width_px;
  const double scale_y = static_cast<double>(size.height) / camera.height_px;
  return {size.width,
          size.height,
          camera.fx_px * scale_x,
          camera.fy_px * scale_y,
          (camera.cx_px + 0.5) * scale_x - 0.5,
          (camera.cy_px + 0.5) * scale_y - 0.5};
}

}  // namespace tsg::ros_interface
