// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/plausibility/input_plausibility.h"

#include <algorithm>
#include <optional>

#include "consistency.h"
#include "depth_findings.h"
#include "depth_statistics.h"
#include "edge_alignment.h"
#include "image_checks.h"
#include "pose_smoothness.h"
#include "task_scene_graph/core/period.h"
#include "verdict_findings.h"
#include "view_groups.h"

namespace tsg::plausibility {
namespace {

constexpr double kSlowPeriod_s = 0.25;
constexpr double kGrossCost = 0.95;

void append(std::vector<Finding>& findings, std::optional<Finding> finding) {
  if (finding) findings.push_back(std::move(*finding));
}

/// Where poses jump to and fro, whatever makes their motion small seems to fit: whether the reading
/// is more than that.
bool isSure(const Verdict& verdict) {
  const bool is_small_change = verdict.given_cost < kGrossCost;
  switch (verdict.reading.kind) {
    case Hypothesis::Kind::kDelay:
      return false;
    case Hypothesis::Kind::kDepthScale:
      return !is_small_change;
    default:
      return verdict.beats_standstill;
  }
}

}  // namespace

class InputPlausibility::Implementation {
 public:
  explicit Implementation(const PlausibilityConfig& config) : config_(config) {}

  void addFrame(const RgbdFrame& frame);
  std::vector<Finding> findings();

  FrameIds ids;
  MatchCounts matches;

 private:
  std::vector<Finding> findDepthFaults();
  std::vector<Finding> findDisagreement();
  void addSlowChecks(const RgbdFrame& frame);

  const PlausibilityConfig config_;
  DepthStatistics depth_;
  ViewGroups groups_;
  ConsistencyCheck consistency_;
  PoseSmoothness smoothness_;
  EdgeAlignment edges_;
  StillnessCheck stillness_;
  DarknessCheck darkness_;
  std::optional<Stamp> last_slow_check_;
  std::optional<CameraModel> camera_;
  double metres_per_unit_ = 0.001;
};

void InputPlausibility::Implementation::addFrame(const RgbdFrame& frame) {
  if (!isUsable(frame)) return;
  camera_ = frame.camera;
  metres_per_unit_ = frame.depth.metres_per_unit;
  depth_.add(frame.depth);
  smoothness_.add(frame.stamp, frame.T_world_camera);
  const bool starts_group = groups_.add(frame);
  if (starts_group && frame.color.image.type() == CV_8UC3) {
    edges_.add(sampleDepth(frame, ViewGroups::kGridWidth_px), frame.color.image);
  }
  if (isDue(last_slow_check_, frame.stamp, kSlowPeriod_s)) addSlowChecks(frame);
}

void InputPlausibility::Implementation::addSlowChecks(const RgbdFrame& frame) {
  last_slow_check_ = frame.stamp;
  stillness_.add(frame);
  darkness_.add(frame.color.image);
}

std::vector<Finding> InputPlausibility::Implementation::findDisagreement() {
  const Verdict verdict = consistency_.judge(groups_.groups(), depth_.median_m());
  const bool is_fault =
      verdict.kind == Verdict::Kind::kOtherReading || verdict.kind == Verdict::Kind::kNoneFits;
  if (is_fault && !isSure(verdict) && smoothness_.isRough()) {
    return {describeRoughness(smoothness_.computeRoughness())};
  }
  return describeVerdict(verdict, groups_.groups(),
                         {depth_.median_m(), metres_per_unit_, *camera_});
}

std::vector<Finding> InputPlausibility::Implementation::findDepthFaults() {
  const auto constant = checkConstantDepth(depth_, stillness_.hasChangedView());
  if (constant) return {*constant};
  std::vector<Finding> findings = findDisagreement();
  const auto range =
      checkDepthRange(depth_, metres_per_unit_, config_.min_range_m, config_.max_range_m);
  if (!range || hasFinding(findings, "depth scale")) return findings;  // that knows the unit better
  // With depth in a wrong unit no pose fits.
  const auto is_vague = [](const Finding& finding) { return finding.check == "reprojection"; };
  findings.erase(std::remove_if(findings.begin(), findings.end(), is_vague), findings.end());
  findings.insert(findings.begin(), *range);
  return findings;
}

std::vector<Finding> InputPlausibility::Implementation::findings() {
  std::vector<Finding> findings = checkFrameIds(ids);
  append(findings, checkMatches(matches));
  if (!camera_) return findings;
  append(findings, checkIntrinsics(*camera_));
  append(findings, darkness_.finding());
  append(findings, stillness_.findConstantPose());
  for (Finding& finding : findDepthFaults()) {
    if (!hasFinding(findings, finding.check)) findings.push_back(std::move(finding));
  }
  const int step_px =
      (camera_->width_px + ViewGroups::kGridWidth_px - 1) / ViewGroups::kGridWidth_px;
  append(findings, checkRegistration(edges_, step_px));
  return findings;
}

InputPlausibility::InputPlausibility(const PlausibilityConfig& config)
    : implementation_(std::make_unique<Implementation>(config)) {}
InputPlausibility::~InputPlausibility() = default;

void InputPlausibility::addFrame(const RgbdFrame& frame) { implementation_->addFrame(frame); }

void InputPlausibility::noteFrameIds(const FrameIds& ids) { implementation_->ids = ids; }

void InputPlausibility::noteMatches(const MatchCounts& counts) {
  implementation_->matches = counts;
}

std::vector<Finding> InputPlausibility::findings() { return implementation_->findings(); }

}  // namespace tsg::plausibility
