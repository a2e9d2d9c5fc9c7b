// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/frame_maker.h"

#include <boost/make_shared.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

// Registered depth shows what colour shows: the sides' ratios agree but for rounding.
constexpr double kMaxAspectDifference = 0.02;

std::string formatSize(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

double computeAspect(cv::Size size) { return static_cast<double>(size.width) / size.height; }

bool isSame(const sensor_msgs::CameraInfo& a, const sensor_msgs::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.K == b.K && a.P == b.P && a.D == b.D &&
         a.R == b.R && a.distortion_model == b.distortion_model && a.binning_x == b.binning_x &&
         a.binning_y == b.binning_y && a.roi == b.roi;
}

}  // namespace

FrameMaker::FrameMaker(const InputConfig& config, InputTopics topics)
    : config_(config),
      topics_(std::move(topics)),
      metres_per_unit_(toMetresPerUnit(config.depth_scale)) {
  if (config_.intrinsics.isEmpty()) return;
  info_ = boost::make_shared<sensor_msgs::CameraInfo>(loadIntrinsics(config_.intrinsics.text));
}

std::optional<std::string> FrameMaker::setCameraInfo(const sensor_msgs::CameraInfoConstPtr& info) {
  if (!config_.intrinsics.isEmpty()) return std::nullopt;
  if (info_ && isSame(*info_, *info)) return std::nullopt;
  checkCameraInfo(*info, topics_.camera_info);
  info_ = info;
  plan_.reset();
  if (config_.rectify || is_warned_of_distortion_ || !hasDistortion(*info) ||
      isRectifiedTopic(topics_.color)) {
    return std::nullopt;
  }
  is_warned_of_distortion_ = true;
  return "camera_info on " + topics_.camera_info + " reports a lens distortion, and images on " +
         topics_.color +
         " are taken as they are: set input/rectify (--rectify), or take the rectified topics of "
         "image_proc";
}

FrameMaker::Result FrameMaker::make(const SourceImage& color, const SourceImage& depth) {
  const auto color_message = color.decode(topics_.color);
  const auto depth_message = depth.decode(topics_.depth);
  Result result;
  result.frame = std::make_shared<RgbdFrame>();
  RgbdFrame& frame = *result.frame;
  frame.stamp = color.stamp();
  frame.color = toColorImage(color_message, topics_.color);
  frame.color.stamp = frame.stamp;
  frame.depth = toDepthImage(depth_message, topics_.depth);
  if (metres_per_unit_ != 0.0) frame.depth.metres_per_unit = metres_per_unit_;
  const Plan& plan = findPlan(frame.color.image.size(), frame.depth.image.size());
  frame.camera = plan.camera;
  if (plan.color_warp) warpColor(frame);
  if (plan.depth_warp) {
    frame.depth.image = plan.depth_warp->applyNearest(frame.depth.image);
    frame.depth.owner = nullptr;
  }
  result.is_color_shared = !color.isCompressed() && isShared(frame.color.image, *color_message);
  result.is_depth_shared = !depth.isCompressed() && isShared(frame.depth.image, *depth_message);
  return result;
}

void FrameMaker::warpColor(RgbdFrame& frame) const {
  frame.published_color = frame.color;
  frame.color_warp = plan_->color_warp;
  cv::Mat image = frame.color.image;
  if (plan_->rectification) image = plan_->rectification->applyLinear(image);
  const cv::Size size(plan_->camera.width_px, plan_->camera.height_px);
  if (image.size() != size) {
    cv::Mat resized;
    // A pixel of a smaller image is the mean of what it covers.
    const bool is_smaller = size.width < image.cols;
    cv::resize(image, resized, size, 0.0, 0.0, is_smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
    image = resized;
  }
  frame.color.image = image;
  frame.color.owner = nullptr;
}

const FrameMaker::Plan& FrameMaker::findPlan(cv::Size color_size, cv::Size depth_size) {
  const bool is_known = plan_ && plan_->color_size == color_size && plan_->depth_size == depth_size;
  if (!is_known) plan_ = makePlan(color_size, depth_size);
  return *plan_;
}

FrameMaker::Plan FrameMaker::makePlan(cv::Size color_size, cv::Size depth_size) const {
  checkSizes(color_size, depth_size);
  const std::string source = config_.intrinsics.isEmpty()
                                 ? topics_.camera_info
                                 : "intrinsics '" + config_.intrinsics.text + "'";
  const Intrinsics intrinsics = toIntrinsics(*info_, color_size, chooseRectification(), source);
  Plan plan{color_size, depth_size, intrinsics.camera, intrinsics.rectification, nullptr, nullptr};
  std::optional<ImageWarp> color_warp;
  std::optional<ImageWarp> depth_warp;
  const auto append = [](std::optional<ImageWarp>& warp, const ImageWarp& next) {
    warp = warp ? warp->followedBy(next) : next;
  };
  const bool differ = color_size != depth_size;
  const bool is_to_depth = config_.match_size == MatchSize::kColorToDepth;
  if (differ && (plan.rectification || !is_to_depth)) {
    append(depth_warp, ImageWarp::resize(depth_size, color_size));
  }
  if (plan.rectification) {
    append(color_warp, *plan.rectification);
    append(depth_warp, *plan.rectification);
  }
  if (differ && is_to_depth) {
    const ImageWarp resize = ImageWarp::resize(color_size, depth_size);
    append(color_warp, resize);
    if (depth_warp) append(depth_warp, resize);
    plan.camera = resizeCamera(plan.camera, depth_size);
  }
  if (color_warp) plan.color_warp = std::make_shared<ImageWarp>(*color_warp);
  if (depth_warp) plan.depth_warp = std::make_shared<ImageWarp>(*depth_warp);
  return plan;
}

Rectification FrameMaker::chooseRectification() const {
  if (isRectifiedTopic(topics_.color)) return Rectification::kDone;
  return config_.rectify ? Rectification::kWanted : Rectification::kIgnored;
}

void FrameMaker::checkSizes(cv::Size color_size, cv::Size depth_size) const {
  if (color_size == depth_size) return;
  const std::string sizes = "depth on " + topics_.depth + " is " + formatSize(depth_size) +
                            ", colour on " + topics_.color + " is " + formatSize(color_size);
  if (config_.match_size == MatchSize::kNone) {
    throw InputError(sizes +
                         "; expected depth registered to colour, of the same size. If it is "
                         "registered, input/match_size (--match-size) color_to_depth or "
                         "depth_to_color brings the sizes together",
                     "sizes differ");
  }
  const double ratio = computeAspect(color_size) / computeAspect(depth_size);
  if (std::abs(ratio - 1.0) <= kMaxAspectDifference) return;
  throw InputError(sizes +
                       ", whose sides have different ratios; expected depth registered to "
                       "colour, which shows the same part of the world",
                   "sizes differ");
}

}  // namespace tsg::ros_interface
