// SPDX-License-Identifier: BSD-3-Clause
#include "verdict_findings.h"

#include <cmath>
#include <string>

#include "depth_findings.h"

namespace tsg::plausibility {
namespace {

using Kind = Hypothesis::Kind;

bool isUsualDepth(double median_m) { return median_m >= 0.3 && median_m <= 8.0; }

/// "reprojected between neighbouring frames (9 groups of views), 57 % of the depth readings
/// disagree as given, 1 % if ..."
std::string describeCosts(const Verdict& verdict, const std::string& condition) {
  std::string text = "reprojected between neighbouring frames (" +
                     std::to_string(verdict.num_groups) + " groups of views), " +
                     formatShare(verdict.given_cost) + " of the depth readings disagree as given";
  if (!condition.empty()) text += ", " + formatShare(verdict.reading_cost) + " if " + condition;
  return text;
}

std::string describeAxes(const Eigen::Matrix3d& R_given_true) {
  if (R_given_true.isApprox(openglAxes())) return "x right, y up, z backward (OpenGL)";
  if (R_given_true.isApprox(bodyAxes())) return "x forward, y left, z up (a robot's body)";
  std::string names;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (R_given_true(row, column) == 0.0) continue;
      names += std::string(column > 0 ? ", " : "") + (R_given_true(row, column) < 0.0 ? "-" : "") +
               "xyz"[row];
    }
  }
  return "such that right, down and forward are its " + names;
}

Finding describeInverse(const Verdict& verdict) {
  return {"pose direction", describeCosts(verdict, "the poses are inverted"),
          "usually the poses map world to camera coordinates",
          "set input/pose_direction to world_to_camera where they come from a pose topic or a"
          " trajectory (process_bag, dataset_to_bag: --poses); a tf that does so has to be mended"
          " where it is made"};
}

Finding describeWrongAxes(const Verdict& verdict, const std::vector<ViewGroup>& groups) {
  const Eigen::Matrix3d& R = verdict.reading.R_given_true;
  Finding finding;
  finding.check = "camera axes";
  finding.seen = describeCosts(verdict, "the camera's axes are " + describeAxes(R));
  if (computeDownShare(groups, Hypothesis{}) == 0.0) {
    finding.seen += "; the camera's y axis never points down in the world";
  }
  const bool is_body = R.isApprox(bodyAxes());
  finding.meaning = is_body ? "usually the images are stamped with a frame that is not optical"
                            : "usually the poses are those of a camera with other axes";
  finding.remedy =
      "the camera's frame has to be x right, y down, z forward: set input/camera_frame to the"
      " camera's optical frame (process_bag: --camera-frame), or input/camera_axes to body or"
      " opengl (process_bag, dataset_to_bag: --camera-axes)";
  return finding;
}

Finding describeTilt(const Verdict& verdict) {
  const Eigen::Matrix3d& R = verdict.reading.R_given_true;
  const double down_deg = std::atan2(-R(2, 1), R(1, 1)) * 180.0 / 3.14159265358979323846;
  return {"camera axes",
          describeCosts(verdict, "the camera looks about " + formatNumber(std::abs(down_deg)) +
                                     " degrees farther " + (down_deg < 0.0 ? "down" : "up")),
          "usually the camera is mounted with another pitch than the robot's description says",
          "correct the transform from the robot to the camera's optical frame"};
}

Finding describeMirror(const Verdict& verdict) {
  return {"camera axes", describeCosts(verdict, "one axis of the poses is mirrored"),
          "usually the poses come from a left-handed world (Unity, Unreal)",
          "convert the poses to right-handed coordinates: negate one axis of the world and the same"
          " one of the camera, then x right, y down, z forward"};
}

/// The middle of the factors of depth that fit.
double computeFactor(const Verdict& verdict) {
  return std::sqrt(verdict.factors.low * verdict.factors.high);
}

Finding describePoseScale(const Verdict& verdict) {
  const double factor = computeFactor(verdict);
  const std::string times = factor > 1.0 ? formatNumber(factor) + " times smaller"
                                         : formatNumber(1.0 / factor) + " times larger";
  return {"pose scale", describeCosts(verdict, "the poses' translations are about " + times),
          "usually the poses are not in metres (millimetres, centimetres)",
          "give poses with translations in metres"};
}

Finding describeDepthScale(const Verdict& verdict, const InputFacts& facts) {
  const double low = verdict.factors.low / 1.08 * facts.metres_per_unit;
  const double high = verdict.factors.high * 1.08 * facts.metres_per_unit;
  const auto units = findDepthUnits(low, high, computeFactor(verdict) * facts.metres_per_unit);
  const double factor =
      units.empty() ? computeFactor(verdict) : units.front().metres / facts.metres_per_unit;
  Finding finding;
  finding.check = "depth scale";
  finding.seen = "the median depth is " + formatNumber(facts.median_depth_m) + " m with " +
                 formatNumber(facts.metres_per_unit) + " m per unit; " +
                 describeCosts(verdict, "depth is " + formatNumber(factor) + " times as large");
  finding.meaning = units.empty() ? "usually the depth unit is wrong, or the scale of the poses is "
                                    "(that of monocular SLAM is arbitrary)"
                                  : "usually the depth unit is wrong";
  const std::string value =
      units.empty() ? "about " + formatNumber(factor * facts.metres_per_unit) : listUnits(units);
  finding.remedy =
      "set input/depth_scale (process_bag: --depth-scale), metres per unit, to " + value;
  return finding;
}

Finding describeScale(const Verdict& verdict, const InputFacts& facts) {
  const bool is_of_poses = isUsualDepth(facts.median_depth_m) &&
                           !isUsualDepth(facts.median_depth_m * computeFactor(verdict));
  return is_of_poses ? describePoseScale(verdict) : describeDepthScale(verdict, facts);
}

Finding describeFocalLength(const Verdict& verdict, const InputFacts& facts) {
  const double factor = verdict.reading.focal_factor;
  return {"intrinsics",
          describeCosts(verdict,
                        "the focal length is about " + formatNumber(factor) +
                            " times as large (fx " + formatNumber(factor * facts.camera.fx_px) +
                            " in the place of " + formatNumber(facts.camera.fx_px) + " px)"),
          "usually the camera_info is that of another stream or resolution, or depth is not"
          " registered to colour and still has the depth camera's own geometry",
          "give the intrinsics of the images that are used (camera_info topic, --intrinsics), and"
          " registered depth (aligned_depth_to_color, depth_registered)"};
}

Finding describeRayDistance(const Verdict& verdict) {
  return {"ray distance", describeCosts(verdict, "depth is the distance from the camera's centre"),
          "usually a simulator wrote distances along the rays",
          "have it write depth along the optical axis (z)"};
}

Finding describeDelay(const Verdict& verdict) {
  const double delay_s = verdict.reading.delay_s;
  const std::string amount = formatNumber(std::abs(delay_s)) + " s";
  return {"pose delay",
          describeCosts(verdict, "each image gets the pose given about " + amount +
                                     (delay_s > 0.0 ? " later" : " earlier")),
          std::string("usually the ") + (delay_s > 0.0 ? "poses" : "images") +
              " are stamped when they arrive, or two computers' clocks differ",
          "have both stamped when they are taken, and the clocks synchronised (chrony)"};
}

Finding describeNoneFits(const Verdict& verdict) {
  return {"reprojection",
          describeCosts(verdict, "") +
              "; no other way of reading poses, axes, depth unit or intrinsics that was tried does"
              " much better",
          "usually the poses are not this camera's (another frame, a wrong mounting, another time),"
          " or depth and camera_info are not of one camera",
          "check input/camera_frame, where the poses come from, and that depth is registered"};
}

Finding describeFrozen(const Verdict& verdict) {
  return {"frozen images",
          "the depth images stay the same, reading for reading, while the pose turns (" +
              std::to_string(verdict.num_groups) + " groups of views)",
          "usually the driver repeats an image, or the poses are not this camera's",
          "check the depth topic, and which frame input/camera_frame names"};
}

std::vector<Finding> describeReading(const Verdict& verdict, const std::vector<ViewGroup>& groups,
                                     const InputFacts& facts) {
  const Hypothesis& reading = verdict.reading;
  std::vector<Finding> findings;
  if (reading.is_inverse) findings.push_back(describeInverse(verdict));
  if (reading.kind == Kind::kAxes || reading.kind == Kind::kInverseAxes) {
    findings.push_back(describeWrongAxes(verdict, groups));
  }
  if (reading.kind == Kind::kTilted) findings.push_back(describeTilt(verdict));
  if (reading.kind == Kind::kMirrored) findings.push_back(describeMirror(verdict));
  if (reading.kind == Kind::kFocalLength) findings.push_back(describeFocalLength(verdict, facts));
  if (reading.kind == Kind::kRayDistance) findings.push_back(describeRayDistance(verdict));
  if (reading.kind == Kind::kDelay) findings.push_back(describeDelay(verdict));
  if (reading.depth_factor != 1.0) findings.push_back(describeScale(verdict, facts));
  return findings;
}

}  // namespace

std::vector<Finding> describeVerdict(const Verdict& verdict, const std::vector<ViewGroup>& groups,
                                     const InputFacts& facts) {
  switch (verdict.kind) {
    case Verdict::Kind::kOtherReading:
      return describeReading(verdict, groups, facts);
    case Verdict::Kind::kNoneFits:
      return {describeNoneFits(verdict)};
    case Verdict::Kind::kFrozenImages:
      return {describeFrozen(verdict)};
    case Verdict::Kind::kUndecided:
    case Verdict::Kind::kConsistent:
      break;
  }
  return {};
}

}  // namespace tsg::plausibility
