// SPDX-License-Identifier: BSD-3-Clause
#include "image_checks.h"

#include <algorithm>
#include <cmath>

namespace tsg::plausibility {
namespace {

constexpr int kGridWidth_px = 40;
constexpr double kMoved_m = 0.001;
constexpr double kTurned_rad = 0.1 * 3.14159265358979323846 / 180.0;
constexpr double kViewMoved_m = 0.05;
constexpr double kViewTurned_rad = 2.0 * 3.14159265358979323846 / 180.0;
constexpr float kChange = 0.1F;
constexpr double kChangedShare = 0.5;
constexpr std::size_t kMinDarkImages = 10;
constexpr double kDarkMean = 5.0;  // of 255

/// Share of the readings valid in both that differ by more than a tenth.
double computeChangedShare(const DepthGrid& a, const DepthGrid& b) {
  if (a.z_m.size() != b.z_m.size()) return 0.0;
  std::size_t both = 0;
  std::size_t changed = 0;
  for (std::size_t i = 0; i < a.z_m.size(); ++i) {
    if (!(a.z_m[i] > 0.0F && b.z_m[i] > 0.0F)) continue;
    ++both;
    changed += std::abs(a.z_m[i] - b.z_m[i]) > kChange * std::min(a.z_m[i], b.z_m[i]) ? 1 : 0;
  }
  return 4 * both < a.z_m.size() ? 0.0 : static_cast<double>(changed) / static_cast<double>(both);
}

}  // namespace

void StillnessCheck::add(const RgbdFrame& frame) {
  if (!first_pose_) {
    first_pose_ = frame.T_world_camera;
    first_ = sampleDepth(frame, kGridWidth_px);
    return;
  }
  const Pose T_first_now = first_pose_->inverse(Eigen::Isometry) * frame.T_world_camera;
  const double turned_rad = Eigen::AngleAxisd(T_first_now.linear()).angle();
  has_moved_ |= T_first_now.translation().norm() >= kMoved_m || turned_rad >= kTurned_rad;
  has_changed_view_ |=
      turned_rad >= kViewTurned_rad || std::abs(T_first_now.translation().z()) >= kViewMoved_m;
  if (has_moved_) return;
  changed_shares_.push_back(computeChangedShare(first_, sampleDepth(frame, kGridWidth_px)));
  if (changed_shares_.size() > kMemory) changed_shares_.pop_front();
}

std::optional<Finding> StillnessCheck::findConstantPose() const {
  if (has_moved_ || changed_shares_.size() < kMemory) return std::nullopt;
  const auto changed = std::count_if(changed_shares_.begin(), changed_shares_.end(),
                                     [](double share) { return share > kChangedShare; });
  if (static_cast<std::size_t>(changed) + 2 < kMemory) return std::nullopt;
  return Finding{"constant pose",
                 "more than half of the depth readings have changed since the first image, but the"
                 " camera's pose never has",
                 "usually the poses are not the camera's, or nobody moves them: a static transform"
                 " in the place of odometry, or one pose for all images",
                 "check that the transform from input/world_frame to the camera (or pose_topic,"
                 " trajectory) moves with the camera"};
}

void DarknessCheck::add(const cv::Mat& color) {
  if (color.type() != CV_8UC3 || color.empty()) return;
  const int step_px = std::max(1, color.cols / kGridWidth_px);
  double sum = 0.0;
  double count = 0.0;
  for (int v = step_px / 2; v < color.rows; v += step_px) {
    for (int u = step_px / 2; u < color.cols; u += step_px) {
      const auto& pixel = color.at<cv::Vec3b>(v, u);
      sum += pixel[0] + pixel[1] + pixel[2];
      count += 3.0;
    }
  }
  ++num_images_;
  num_dark_ += sum < kDarkMean * count ? 1 : 0;
}

std::optional<Finding> DarknessCheck::finding() const {
  if (num_images_ < kMinDarkImages || num_dark_ * 10 < num_images_ * 9) return std::nullopt;
  return Finding{"dark images",
                 formatShare(static_cast<double>(num_dark_) / static_cast<double>(num_images_)) +
                     " of " + std::to_string(num_images_) +
                     " colour images that were looked at are black (mean below " +
                     formatNumber(kDarkMean) + " of 255)",
                 "usually there is no light, the lens is covered or exposure is wrong",
                 "look at the colour image; nothing can be segmented in it"};
}

std::optional<Finding> checkConstantDepth(const DepthStatistics& depth, bool has_changed_view) {
  const auto value_m = depth.constantValue_m();
  if (!value_m || !has_changed_view || depth.numImages() < 10) return std::nullopt;
  return Finding{"constant depth",
                 "every valid reading of " + std::to_string(depth.numImages()) +
                     " depth images is " + formatNumber(static_cast<double>(*value_m)) +
                     " m, while the camera moves",
                 "usually the depth images are not depth (a mask, a placeholder) or are clipped",
                 "check the depth topic and the type of its images"};
}

}  // namespace tsg::plausibility
