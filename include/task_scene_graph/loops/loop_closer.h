// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "task_scene_graph/loops/constellation.h"
#include "task_scene_graph/loops/loop_support.h"
#include "task_scene_graph/loops/registration.h"
#include "task_scene_graph/loops/scene.h"
#include "task_scene_graph/trajectory/keyframes.h"

namespace tsg::loops {

/// Which places are looked at again, and what makes a loop closure of two of them.
struct LoopConfig {
  double anchor_spacing_m = 2.0;
  double turn_m_per_rad = 0.5;
  double min_way_m = 6.0;
  double max_drift = 0.05;
  double least_reach_m = 1.5;
  int max_candidates = 5;
  double min_image_cosine = 0.0;
  double min_overlap = 0.3;
  double max_rms_m = 0.04;
  double min_eigenvalue = 0.002;
  double max_share_through = 0.025;
  double max_lone_share_through = 0.005;
  double min_lone_share_in_sight = 0.3;
  double loop_position_m = 0.01;
  double loop_angle_rad = 0.004;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("anchor_spacing_m", self.anchor_spacing_m, {0.1, 100.0}, "m",
            "after so much way there is the next anchor: a place that can be found again");
    v.field("turn_m_per_rad", self.turn_m_per_rad, {0.0, 10.0}, "m/rad",
            "a turn counts as so much way, as it shows more of a place");
    v.field("min_way_m", self.min_way_m, {0.1, 1e4}, "m",
            "no loop closure between places with less way between them");
    v.field(
        "max_drift", self.max_drift, {0.0, 1.0}, "",
        "places whose clouds' middles seem farther apart than this share of the way between them "
        "are not tried; the larger, the less odometry is believed");
    v.field("least_reach_m", self.least_reach_m, {0.0, 100.0}, "m", "... and this");
    v.field("max_candidates", self.max_candidates, {1.0, 100.0}, "",
            "so many places are tried for each anchor, those that look most alike");
    v.field("min_image_cosine", self.min_image_cosine, {-1.0, 1.0}, "",
            "places whose images look less alike are not tried");
    v.field("min_overlap", self.min_overlap, {0.01, 1.0}, "",
            "share of both clouds' points that must fit");
    v.field("max_rms_m", self.max_rms_m, {0.001, 1.0}, "m",
            "largest root mean square distance of those that fit from the other cloud's planes");
    v.field("min_eigenvalue", self.min_eigenvalue, {0.0, 0.33}, "",
            "clouds that fix a motion less, such as a corridor's, are refused; those that fix it "
            "little count less in the directions in which they could slide or turn");
    v.field(
        "max_share_through", self.max_share_through, {0.0, 1.0}, "",
        "share of the surfaces of one place in sight of the other that this one looked through");
    v.field("max_lone_share_through", self.max_lone_share_through, {0.0, 1.0}, "",
            "... of a loop closure that needs no other to say the same");
    v.field("min_lone_share_in_sight", self.min_lone_share_in_sight, {0.0, 1.0}, "",
            "... which takes this share of all surfaces of both in sight of the other");
    v.field(
        "loop_position_m", self.loop_position_m, {0.001, 10.0}, "m",
        "deviation of each coordinate of a loop closure of full overlap; 1 / overlap^1.5 of that "
        "of others");
    v.field("loop_angle_rad", self.loop_angle_rad, {0.0001, 3.0}, "rad",
            "deviation of each angle, likewise");
  }
};

/// Lets odometry have a bias, as real odometry drifts to one side: a scale of 3 %, and 1.7 degrees
/// after 10 m.
inline trajectory::PoseGraphConfig makeLoopGraphConfig() {
  trajectory::PoseGraphConfig config;
  config.odometry_scale = 0.03;
  config.odometry_turn_rad_per_m = 0.003;
  return config;
}

/// All that closing loops needs to know.
struct LoopCloserConfig {
  trajectory::KeyframeConfig keyframes;
  trajectory::OdometryNoise odometry;
  trajectory::PoseGraphConfig graph = makeLoopGraphConfig();
  SceneConfig scene;
  ConstellationConfig constellation;
  RegistrationConfig registration;
  LoopConfig loops;
  SupportConfig support;
};

/// With what `loops.max_drift` says of odometry: its noise and the deviations of its bias are those
/// above at 5 %, and in proportion at other shares (from 1 % on). @throws config::ConfigError
LoopCloserConfig makeLoopCloserConfig(const LoopConfig& loops);

enum class LoopOutcome {
  kAdded,          ///< part of the pose graph; its verdict says whether it is believed
  kLittleOverlap,  ///< the clouds do not lie on each other
  kRough,          ///< they do, but not closely
  kDegenerate,     ///< they do, but could slide or turn
  kLookedThrough,  ///< one has surfaces where the other saw free space
  kUnsupported,    ///< nothing else says the same
  kUnsolved        ///< the pose graph with it has no solution
};

/// A pair of places that was tried.
struct LoopRecord {
  trajectory::KeyframeId a;  ///< the earlier one
  trajectory::KeyframeId b;
  LoopOutcome outcome = LoopOutcome::kLittleOverlap;
  double image_cosine = 0.0;
  std::size_t num_landmarks = 0;  ///< of the constellation that both share
  Registration registration;      ///< of b on a
  Visibility visibility;          ///< of each one's surfaces to the other
  double share_in_sight = 0.0;    ///< of all surfaces of both, those that visibility counts
  std::optional<std::size_t> edge = std::nullopt;  ///< of the pose graph, if added
  std::string message;                             ///< for people: why it was not added
};

/// Finds places seen again along a trajectory of odometry, and corrects it. Each keyframe adds an
/// odometry edge; every few metres one is an anchor, with what the keyframes around it saw as its
/// scene. A new anchor is compared with those before it that can show the same by the drift allowed
/// (the middles of their clouds are near), most alike first: by image embeddings and constellations
/// of landmarks. Their clouds are registered from what constellation, features and odometry say;
/// what fits becomes a loop closure as soon as another near it says the same, or at once where much
/// of both was in sight of the other's cameras and nothing looked through; the pose graph is solved
/// anew, and the bias of odometry with it. The same result from run to run. Not thread-safe.
class LoopCloser {
 public:
  /// @param frame  in which odometry is given
  /// @throws config::ConfigError
  explicit LoopCloser(std::string frame, const LoopCloserConfig& config = {});

  /// The next frame, its pose by odometry. Depth is only looked at if it is a keyframe.
  /// @param segmentation  as published; may be null: then loops are found by their shape only
  /// @returns whether the poses of earlier keyframes have changed.
  /// @throws std::invalid_argument as Keyframes::add(); nothing has changed then.
  bool add(const RgbdFrame& frame, const SegmentationPtr& segmentation);
  /// There is no further frame: compares the last anchors too. @returns as add().
  bool finish();

  /// By odometry.
  const trajectory::Keyframes& keyframes() const { return keyframes_; }
  /// Corrected.
  const trajectory::PoseGraph& graph() const { return graph_; }
  trajectory::Keyframes correctedKeyframes() const;
  /// Pairs that were tried, in order.
  const std::vector<LoopRecord>& records() const { return records_; }

 private:
  struct Waiting {
    std::size_t keyframe;  ///< index
    double progress_m;
    Scene scene;
  };
  struct Anchor {
    trajectory::KeyframeId id;
    double way_m;
    Scene scene;
    Eigen::Vector3d middle_m;  ///< of the cloud, in the keyframe's frame
  };
  struct Candidate {
    const Anchor* anchor;
    double cosine;
    Constellation constellation;  ///< T_a_b: of the query in the anchor
    double score;
  };

  void extendGraph();
  bool searchUpTo(double progress_m);
  Anchor makeAnchor(std::size_t keyframe, double progress_m) const;
  static std::vector<Candidate> pickDifferent(std::vector<Candidate> candidates, std::size_t most,
                                              double apart_m);
  std::vector<Candidate> findCandidates(const Anchor& query) const;
  bool closeLoops(const Anchor& query);
  LoopRecord verify(const Candidate& candidate, const Anchor& query, const RegisteredCloud& cloud);
  RegisteredCloud cloudOf(const Anchor& anchor);
  trajectory::PoseEdge makePlainEdge(const LoopRecord& record) const;
  trajectory::PoseEdge makeEdge(const LoopRecord& record) const;
  bool needsNoSupport(const LoopRecord& record) const;
  bool addSupported();
  bool addToGraph(const trajectory::PoseEdge& edge, LoopRecord& record);
  Eigen::Vector3d middleOf(const Anchor& anchor) const;
  const Pose& poseOf(trajectory::KeyframeId id) const;

  LoopCloserConfig config_;
  trajectory::Keyframes keyframes_;
  trajectory::PoseGraph graph_;
  std::vector<double> ways_m_;           ///< of each keyframe: along the trajectory
  std::vector<double> progress_m_;       ///< ... with turns
  std::deque<Waiting> waiting_;          ///< scenes of keyframes that an anchor to come needs
  std::deque<std::size_t> pending_;      ///< indices of keyframes that will be anchors
  std::optional<double> last_anchor_m_;  ///< progress
  std::vector<Anchor> anchors_;
  std::deque<std::pair<trajectory::KeyframeId, RegisteredCloud>>
      clouds_;  ///< of anchors, newest last
  std::vector<LoopRecord> records_;
  std::vector<trajectory::PoseEdge> verified_;  ///< those that fit, added or not
  std::vector<std::size_t> unsupported_;        ///< indices of records
};

/// Part of the pose graph, and believed.
bool isAccepted(const LoopRecord& record, const trajectory::PoseGraph& graph);
/// "little overlap" and the like.
std::string toText(LoopOutcome outcome);
/// "accepted", or why not, in words and numbers.
std::string describeOutcome(const LoopRecord& record, const trajectory::PoseGraph& graph);

}  // namespace tsg::loops
