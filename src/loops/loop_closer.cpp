// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/loop_closer.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::loops {
namespace {

using trajectory::computeAngle;
using trajectory::KeyframeId;
using trajectory::PoseEdge;
using trajectory::Verdict;

constexpr double kScorePerLandmark = 0.03;  ///< as much as this much more cosine
constexpr std::size_t kMostCounted = 10;    ///< landmarks
constexpr double kScorePerMetre = 0.05;     ///< less, as odometry is not all wrong
constexpr double kThroughMargin_m = 0.1;
constexpr double kLeastFixed = 1e-3;  ///< of the information of clouds that fix all directions
constexpr std::size_t kMostClouds = 40;

std::string toNumber(double value) {
  std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 4);
}

void judge(const LoopConfig& config, LoopRecord& record) {
  const Registration& found = record.registration;
  if (found.overlap < config.min_overlap) {
    record.outcome = LoopOutcome::kLittleOverlap;
    record.message = "overlap " + toNumber(found.overlap) + ", expected at least " +
                     toNumber(config.min_overlap);
  } else if (found.rms_m > config.max_rms_m) {
    record.outcome = LoopOutcome::kRough;
    record.message =
        "residual " + toNumber(found.rms_m) + " m, expected at most " + toNumber(config.max_rms_m);
  } else if (found.least_eigenvalue < config.min_eigenvalue) {
    record.outcome = LoopOutcome::kDegenerate;
    record.message = "least eigenvalue " + toNumber(found.least_eigenvalue) +
                     ", expected at least " + toNumber(config.min_eigenvalue);
  } else if (record.visibility.shareThrough() > config.max_share_through) {
    record.outcome = LoopOutcome::kLookedThrough;
    record.message = toNumber(record.visibility.shareThrough()) +
                     " of the surfaces in sight were looked through, expected at most " +
                     toNumber(config.max_share_through);
  } else {
    record.outcome = LoopOutcome::kUnsupported;
    record.message = "no other loop closure near it says the same";
  }
}

/// The camera itself where there is no point.
Eigen::Vector3d computeMiddle(const Points& points) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : points) sum_m += p.cast<double>();
  return sum_m / std::max(1.0, static_cast<double>(points.size()));
}

/// As if normals went to all sides. The less two clouds share, the less sure is what lies between:
/// measured on generated apartments.
trajectory::Matrix6d makePlainInformation(const LoopConfig& config, double overlap) {
  const double spread = std::pow(overlap, -1.5);
  trajectory::Vector6d deviations;
  deviations << Eigen::Vector3d::Constant(spread * config.loop_position_m),
      Eigen::Vector3d::Constant(spread * config.loop_angle_rad);
  return deviations.array().square().inverse().matrix().asDiagonal();
}

/// Less where the surfaces let it slide or turn, down to kLeastFixed of it.
trajectory::Matrix6d makeInformation(const LoopConfig& config, const Registration& found) {
  const trajectory::Matrix6d plain = makePlainInformation(config, found.overlap);
  const Eigen::SelfAdjointEigenSolver<trajectory::Matrix6d> solver(found.fixation);
  const trajectory::Vector6d shares =
      (3.0 * solver.eigenvalues()).cwiseMax(kLeastFixed).cwiseMin(1.0);
  const trajectory::Matrix6d fixed =
      solver.eigenvectors() * shares.asDiagonal() * solver.eigenvectors().transpose();
  const trajectory::Matrix6d root = plain.cwiseSqrt();
  const trajectory::Matrix6d information = root * fixed * root;
  return 0.5 * (information + information.transpose());
}

}  // namespace

LoopCloserConfig makeLoopCloserConfig(const LoopConfig& loops) {
  config::validate(loops, "loops");
  LoopCloserConfig config;
  config.loops = loops;
  const double factor = std::max(loops.max_drift, 0.01) / LoopConfig{}.max_drift;
  config.odometry.position_m *= factor;
  config.odometry.angle_rad *= factor;
  config.graph.odometry_scale *= factor;
  config.graph.odometry_turn_rad_per_m *= factor;
  return config;
}

LoopCloser::LoopCloser(std::string frame, const LoopCloserConfig& config)
    : config_(config), keyframes_(std::move(frame), config.keyframes), graph_(config.graph) {
  config::validate(config.odometry, "odometry");
  config::validate(config.scene, "scene");
  config::validate(config.constellation, "constellation");
  config::validate(config.registration, "registration");
  config::validate(config.loops, "loops");
  config::validate(config.support, "support");
}

bool LoopCloser::add(const RgbdFrame& frame, const SegmentationPtr& segmentation) {
  if (!keyframes_.add(frame.stamp, frame.T_world_camera)) return false;
  extendGraph();
  const std::size_t index = keyframes_.list().size() - 1;
  const double progress_m = progress_m_.back();
  waiting_.push_back({index, progress_m, makeScene(frame, segmentation, config_.scene)});
  if (!last_anchor_m_ || progress_m - *last_anchor_m_ >= config_.loops.anchor_spacing_m) {
    pending_.push_back(index);
    last_anchor_m_ = progress_m;
  }
  return searchUpTo(progress_m - config_.loops.anchor_spacing_m);
}

bool LoopCloser::finish() { return searchUpTo(progress_m_.empty() ? 0.0 : progress_m_.back()); }

void LoopCloser::extendGraph() {
  const auto& list = keyframes_.list();
  const trajectory::Keyframe& now = list.back();
  if (list.size() == 1) {
    graph_.addKeyframe(now.id, now.T_world_camera);
    ways_m_.push_back(0.0);
    progress_m_.push_back(0.0);
    return;
  }
  const PoseEdge edge = trajectory::makeOdometryEdge(list[list.size() - 2], now, config_.odometry);
  graph_.extend(edge);
  const double step_m = edge.T_a_b.translation().norm();
  ways_m_.push_back(ways_m_.back() + step_m);
  progress_m_.push_back(progress_m_.back() + step_m +
                        config_.loops.turn_m_per_rad * computeAngle(edge.T_a_b));
}

/// Anchors up to there are complete: what comes later is too far from them.
bool LoopCloser::searchUpTo(double progress_m) {
  bool has_moved = false;
  while (!pending_.empty() && progress_m_[pending_.front()] <= progress_m) {
    const std::size_t index = pending_.front();
    pending_.pop_front();
    Anchor anchor = makeAnchor(index, progress_m_[index]);
    has_moved = closeLoops(anchor) || has_moved;
    anchors_.push_back(std::move(anchor));
  }
  const double needed_m = progress_m - config_.loops.anchor_spacing_m;
  while (!waiting_.empty() && waiting_.front().progress_m < needed_m) waiting_.pop_front();
  return has_moved;
}

LoopCloser::Anchor LoopCloser::makeAnchor(std::size_t keyframe, double progress_m) const {
  const auto& list = keyframes_.list();
  const Pose T_anchor_world = list[keyframe].T_world_camera.inverse();
  std::vector<std::pair<Pose, const Scene*>> parts;
  for (const Waiting& waiting : waiting_) {
    if (std::abs(waiting.progress_m - progress_m) > config_.loops.anchor_spacing_m) continue;
    parts.emplace_back(T_anchor_world * list[waiting.keyframe].T_world_camera, &waiting.scene);
  }
  Scene scene = joinScenes(parts, config_.scene, config_.constellation.min_cosine);
  const Eigen::Vector3d middle_m = computeMiddle(scene.points);
  return {list[keyframe].id, ways_m_[keyframe], std::move(scene), middle_m};
}

Eigen::Vector3d LoopCloser::middleOf(const Anchor& anchor) const {
  return poseOf(anchor.id) * anchor.middle_m;
}

const Pose& LoopCloser::poseOf(KeyframeId id) const { return graph_.find(id)->T_world_keyframe; }

/// The best ones, from other visits first: those near each other along the way say the same once
/// more, while each visit ties its own part of the trajectory down.
/// @param candidates  the best first
std::vector<LoopCloser::Candidate> LoopCloser::pickDifferent(std::vector<Candidate> candidates,
                                                             std::size_t most, double apart_m) {
  std::vector<Candidate> picked;
  std::vector<Candidate> others;
  for (Candidate& candidate : candidates) {
    const bool is_visited = std::any_of(picked.begin(), picked.end(), [&](const Candidate& other) {
      return std::abs(other.anchor->way_m - candidate.anchor->way_m) < apart_m;
    });
    (is_visited ? others : picked).push_back(std::move(candidate));
  }
  picked.insert(picked.end(), std::make_move_iterator(others.begin()),
                std::make_move_iterator(others.end()));
  if (picked.size() > most) {
    picked.erase(picked.begin() + static_cast<std::ptrdiff_t>(most), picked.end());
  }
  return picked;
}

std::vector<LoopCloser::Candidate> LoopCloser::findCandidates(const Anchor& query) const {
  const LoopConfig& loops = config_.loops;
  const Eigen::Vector3d here_m = middleOf(query);
  std::vector<Candidate> candidates;
  for (const Anchor& anchor : anchors_) {
    const double way_m = query.way_m - anchor.way_m;
    const double distance_m = (middleOf(anchor) - here_m).norm();
    if (way_m < loops.min_way_m) continue;
    if (distance_m > loops.least_reach_m + loops.max_drift * way_m) continue;
    const bool has_images =
        query.scene.image.size() > 0 && query.scene.image.size() == anchor.scene.image.size();
    const double cosine = has_images ? computeCosine(anchor.scene.image, query.scene.image) : 0.0;
    if (has_images && cosine < loops.min_image_cosine) continue;
    Candidate candidate{
        &anchor, cosine,
        matchConstellation(anchor.scene.landmarks, query.scene.landmarks, config_.constellation),
        0.0};
    const std::size_t counted = std::min(kMostCounted, candidate.constellation.pairs.size());
    candidate.score =
        cosine + kScorePerLandmark * static_cast<double>(counted) - kScorePerMetre * distance_m;
    candidates.push_back(std::move(candidate));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& x, const Candidate& y) { return x.score > y.score; });
  return pickDifferent(std::move(candidates), static_cast<std::size_t>(loops.max_candidates),
                       2.0 * loops.anchor_spacing_m);
}

bool LoopCloser::closeLoops(const Anchor& query) {
  const std::vector<Candidate> candidates = findCandidates(query);
  if (candidates.empty()) return false;
  const RegisteredCloud cloud(query.scene.points, config_.registration);
  for (const Candidate& candidate : candidates) {
    records_.push_back(verify(candidate, query, cloud));
    if (records_.back().outcome != LoopOutcome::kUnsupported) continue;
    verified_.push_back(makePlainEdge(records_.back()));
    unsupported_.push_back(records_.size() - 1);
  }
  return addSupported();
}

/// Much was looked at and all of it is as it should be: chance does not do that.
bool LoopCloser::needsNoSupport(const LoopRecord& record) const {
  return record.share_in_sight >= config_.loops.min_lone_share_in_sight &&
         record.visibility.shareThrough() <= config_.loops.max_lone_share_through;
}

/// A new one may support those that wait.
bool LoopCloser::addSupported() {
  const LoopSupport support(keyframes_, config_.odometry, config_.support, config_.graph);
  std::vector<std::size_t> still_waiting;
  bool has_moved = false;
  for (const std::size_t index : unsupported_) {
    if (needsNoSupport(records_[index]) ||
        support.isSupported(makePlainEdge(records_[index]), verified_)) {
      has_moved = addToGraph(makeEdge(records_[index]), records_[index]) || has_moved;
    } else {
      still_waiting.push_back(index);
    }
  }
  unsupported_ = std::move(still_waiting);
  return has_moved;
}

/// For its support: where it could slide, another may say anything, and that is no support.
PoseEdge LoopCloser::makePlainEdge(const LoopRecord& record) const {
  return {record.a, record.b, record.registration.T_target_source,
          makePlainInformation(config_.loops, record.registration.overlap),
          trajectory::EdgeKind::kLoop};
}

PoseEdge LoopCloser::makeEdge(const LoopRecord& record) const {
  PoseEdge edge = makePlainEdge(record);
  edge.information = makeInformation(config_.loops, record.registration);
  return edge;
}

/// Anchors near to each other have the same candidates; half a megabyte each.
RegisteredCloud LoopCloser::cloudOf(const Anchor& anchor) {
  const auto known = std::find_if(clouds_.begin(), clouds_.end(),
                                  [&](const auto& entry) { return entry.first == anchor.id; });
  if (known != clouds_.end()) return known->second;
  if (clouds_.size() == kMostClouds) clouds_.pop_front();
  clouds_.emplace_back(anchor.id, RegisteredCloud(anchor.scene.points, config_.registration));
  return clouds_.back().second;
}

LoopRecord LoopCloser::verify(const Candidate& candidate, const Anchor& query,
                              const RegisteredCloud& cloud) {
  LoopRecord record;
  record.a = candidate.anchor->id;
  record.b = query.id;
  record.image_cosine = candidate.cosine;
  record.num_landmarks = candidate.constellation.pairs.size();
  const RegisteredCloud target = cloudOf(*candidate.anchor);
  std::vector<Pose> guesses = {poseOf(record.a).inverse() * poseOf(record.b)};
  if (record.num_landmarks > 0) guesses.push_back(candidate.constellation.T_a_b);
  Pose by_features;
  if (alignByFeatures(cloud, target, config_.registration, by_features)) {
    guesses.push_back(by_features);
  }
  record.registration = registerClouds(cloud, target, guesses, config_.registration);
  const Pose& T_a_b = record.registration.T_target_source;
  const Scene& scene = candidate.anchor->scene;
  record.visibility = lookAt(query.scene.points, T_a_b, scene.views, kThroughMargin_m) +
                      lookAt(scene.points, T_a_b.inverse(), query.scene.views, kThroughMargin_m);
  const std::size_t num_points = query.scene.points.size() + scene.points.size();
  record.share_in_sight =
      static_cast<double>(record.visibility.num_seen + record.visibility.num_through) /
      static_cast<double>(std::max<std::size_t>(1, num_points));
  judge(config_.loops, record);
  return record;
}

/// Tries it in a copy: a fault leaves the graph as it was.
bool LoopCloser::addToGraph(const PoseEdge& edge, LoopRecord& record) {
  trajectory::PoseGraph trial = graph_;
  const std::size_t index = trial.edges().size();
  trial.addEdge(edge);
  const trajectory::SolveReport report = trial.optimize();
  if (report.isFault()) {
    record.outcome = LoopOutcome::kUnsolved;
    record.message = report.message;
    return false;
  }
  record.outcome = LoopOutcome::kAdded;
  record.edge = index;
  graph_ = std::move(trial);
  return report.status == trajectory::SolveStatus::kSolved;
}

trajectory::Keyframes LoopCloser::correctedKeyframes() const {
  std::vector<Pose> poses;
  for (const auto& keyframe : graph_.keyframes()) poses.push_back(keyframe.T_world_keyframe);
  return keyframes_.withPoses(poses);
}

bool isAccepted(const LoopRecord& record, const trajectory::PoseGraph& graph) {
  return record.edge && graph.verdicts()[*record.edge] == Verdict::kBelieved;
}

std::string toText(LoopOutcome outcome) {
  switch (outcome) {
    case LoopOutcome::kAdded:
      return "added";
    case LoopOutcome::kLittleOverlap:
      return "little overlap";
    case LoopOutcome::kRough:
      return "large residual";
    case LoopOutcome::kDegenerate:
      return "could slide or turn";
    case LoopOutcome::kLookedThrough:
      return "surfaces in free space";
    case LoopOutcome::kUnsupported:
      return "unsupported";
    case LoopOutcome::kUnsolved:
      return "pose graph not solved";
  }
  return "";
}

std::string describeOutcome(const LoopRecord& record, const trajectory::PoseGraph& graph) {
  if (!record.edge) return toText(record.outcome) + ": " + record.message;
  switch (graph.verdicts()[*record.edge]) {
    case Verdict::kBelieved:
      return "accepted";
    case Verdict::kOdometryContradicts:
      return "odometry cannot have drifted so far";
    case Verdict::kOtherEdgesContradict:
      return "other loop closures contradict it";
    case Verdict::kUndecided:
      return "undecided";
  }
  return "";
}

}  // namespace tsg::loops
