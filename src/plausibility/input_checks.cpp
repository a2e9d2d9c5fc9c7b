// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/input_checks.h"

#include <algorithm>
#include <cmath>

namespace tsg::plausibility {
namespace {

constexpr std::uint64_t kMinImages = 20;
constexpr double kMinUnmatchedShare = 0.2;
constexpr double kMaxTolerance_s = 0.1;  // farther apart, images do not show the same
constexpr double kMaxOffCentre = 0.15;   // of the principal point, share of the image's size
constexpr double kMinView_deg = 15.0;
constexpr double kMaxView_deg = 150.0;
constexpr double kMaxAspect = 1.67;

std::string stripSlash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

bool differ(const std::string& a, const std::string& b) {
  return !a.empty() && !b.empty() && stripSlash(a) != stripSlash(b);
}

std::string milliseconds(double seconds) { return formatNumber(1000.0 * seconds) + " ms"; }

double computeView_deg(int size_px, double focal_px) {
  return 2.0 * std::atan(0.5 * size_px / focal_px) * 180.0 / 3.14159265358979323846;
}

bool isInside(double center_px, int size_px) {
  return std::abs(center_px / size_px - 0.5) <= kMaxOffCentre;
}

bool isView(double view_deg) { return view_deg >= kMinView_deg && view_deg <= kMaxView_deg; }

Finding describeNoMatch(const MatchCounts& counts) {
  Finding finding;
  finding.meaning = "usually the streams are not synchronised, or one of them has other stamps";
  const bool is_near = counts.nearest_unmatched_s && *counts.nearest_unmatched_s <= kMaxTolerance_s;
  finding.remedy =
      is_near ? "set input/sync_tolerance_s (process_bag: --sync-tolerance) to " +
                    formatNumber(std::ceil(*counts.nearest_unmatched_s * 1200.0) / 1000.0) +
                    ", or have the driver synchronise the streams"
              : "have the driver synchronise the streams, and check that one clock stamps both";
  return finding;
}

Finding describeSomeMatch() {
  return {"", "", "usually depth comes at a lower rate than colour, or images are lost on the way",
          "nothing, if the rates are meant to differ: what has no partner is left out; else have"
          " the driver send both at one rate, or raise input/sync_tolerance_s (process_bag:"
          " --sync-tolerance)"};
}

}  // namespace

std::vector<Finding> checkFrameIds(const FrameIds& ids) {
  std::vector<Finding> findings;
  if (differ(ids.color, ids.depth)) {
    findings.push_back(
        {"frame ids", "depth is stamped '" + ids.depth + "', colour '" + ids.color + "'",
         "usually depth is not registered to colour: a pixel of one is another point in the other",
         "use the driver's registered depth (aligned_depth_to_color, depth_registered); if it is"
         " registered and only stamped so, nothing"});
  }
  if (differ(ids.color, ids.camera_info) && differ(ids.depth, ids.camera_info)) {
    findings.push_back(
        {"camera_info frame",
         "camera_info is stamped '" + ids.camera_info + "', colour '" + ids.color + "'",
         "usually the intrinsics are those of another camera",
         "use the camera_info topic beside the colour images"});
  }
  return findings;
}

std::optional<Finding> checkMatches(const MatchCounts& counts) {
  if (counts.color_images < kMinImages) return std::nullopt;
  const double share =
      static_cast<double>(counts.unmatched) / static_cast<double>(counts.color_images);
  if (share < kMinUnmatchedShare) return std::nullopt;
  const bool none_matches = counts.unmatched * 50 >= counts.color_images * 49;
  Finding finding = none_matches ? describeNoMatch(counts) : describeSomeMatch();
  finding.check = "matching";
  finding.seen = std::to_string(counts.unmatched) + " of " + std::to_string(counts.color_images) +
                 " colour images (" + formatShare(share) + ") have no depth image within " +
                 milliseconds(counts.tolerance_s);
  if (counts.nearest_unmatched_s) {
    finding.seen += "; the smallest distance found is " + milliseconds(*counts.nearest_unmatched_s);
  }
  return finding;
}

std::optional<Finding> checkIntrinsics(const CameraModel& camera) {
  const double wide_deg = computeView_deg(camera.width_px, camera.fx_px);
  const double high_deg = computeView_deg(camera.height_px, camera.fy_px);
  const double aspect = std::max(camera.fx_px / camera.fy_px, camera.fy_px / camera.fx_px);
  const bool is_plausible = isInside(camera.cx_px, camera.width_px) &&
                            isInside(camera.cy_px, camera.height_px) && isView(wide_deg) &&
                            isView(high_deg) && aspect <= kMaxAspect;
  if (is_plausible) return std::nullopt;
  return Finding{
      "intrinsics",
      "images of " + std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px) +
          " come with fx " + formatNumber(camera.fx_px) + ", fy " + formatNumber(camera.fy_px) +
          ", cx " + formatNumber(camera.cx_px) + ", cy " + formatNumber(camera.cy_px) +
          " px: a field of view of " + formatNumber(wide_deg) + " by " + formatNumber(high_deg) +
          " degrees with the principal point at " + formatShare(camera.cx_px / camera.width_px) +
          " of the width and " + formatShare(camera.cy_px / camera.height_px) + " of the height",
      "usually the intrinsics belong to another resolution or another camera",
      "give those of the images that are used: the camera_info topic beside them, or a file"
      " (--intrinsics)"};
}

}  // namespace tsg::plausibility
