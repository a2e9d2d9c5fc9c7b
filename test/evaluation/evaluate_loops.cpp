// SPDX-License-Identifier: BSD-3-Clause
// Walks with drift through generated apartments: what loop closures take away of the error.
#include <boost/program_options.hpp>
#include <cstdio>
#include <iostream>

#include "drifting_walk.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/loops/loop_closer.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/random.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/segment_simulator.h"
#include "task_scene_graph/simulation/variation.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  int first_seed = 1;
  int num_seeds = 5;
  int rooms = 6;
  int laps = 2;
  int width = 160;
  double false_share = 0.3;
  bool without_images = false;
  bool verbose = false;
  std::string trajectories;
  loops::LoopCloserConfig config;
  std::vector<double> drifts{0.01, 0.02, 0.03};
};

/// A graph and what its keyframes' errors are measured with.
struct World {
  DriftingWalk walk;
  std::vector<std::size_t> indices;

  double computeError(const trajectory::PoseGraph& graph) const {
    return computeTrajectoryError(
        walk, indices, [&](std::size_t k) { return graph.keyframes()[k].T_world_keyframe; });
  }
  const Pose& truth(trajectory::KeyframeId id) const {
    return walk.truth[indices[id.value - 1]].T_world_camera;
  }
};

void feed(const World& world, const Arguments& arguments, loops::LoopCloser& closer) {
  const CameraModel camera =
      simulation::makeDefaultCamera(arguments.width, arguments.width * 3 / 4);
  const simulation::Renderer renderer(world.walk.apartment, 2);
  const simulation::SegmentSimulator segmenter(world.walk.apartment, {});
  const auto seed = static_cast<std::uint64_t>(world.walk.apartment.config.seed);
  for (const std::size_t i : world.indices) {
    const auto view = renderer.render(camera, world.walk.truth[i].T_world_camera);
    const auto frame_number = static_cast<std::int64_t>(i);
    RgbdFrame frame;
    frame.stamp = world.walk.odometry[i].stamp;
    frame.camera = camera;
    frame.T_world_camera = world.walk.odometry[i].T_world_camera;
    frame.color.image = view.color;
    frame.depth.image =
        simulation::simulateDepthSensor(view.depth_m, camera, {}, seed, frame_number, 2);
    SegmentationPtr segmentation;
    if (!arguments.without_images) {
      segmentation =
          std::make_shared<Segmentation>(segmenter.segment(view, frame.stamp, frame_number));
    }
    closer.add(frame, segmentation);
  }
  closer.finish();
}

/// The odometry, what was verified, and more, all at once.
trajectory::PoseGraph rebuild(const loops::LoopCloser& closer,
                              const loops::LoopCloserConfig& config,
                              const std::vector<trajectory::PoseEdge>& more) {
  auto graph = trajectory::makePoseGraph(closer.keyframes(), config.odometry, config.graph);
  std::vector<trajectory::PoseEdge> loops = more;
  for (const auto& edge : closer.graph().edges()) {
    if (edge.kind != trajectory::EdgeKind::kLoop) continue;
    graph.addEdge(edge);
    loops.push_back(edge);
  }
  const loops::LoopSupport support(closer.keyframes(), config.odometry, config.support,
                                   config.graph);
  for (const auto& edge : more) {
    if (support.isSupported(edge, loops)) graph.addEdge(edge);
  }
  graph.optimize();
  return graph;
}

/// Loop closures between random keyframes, with poses within 2 m of what odometry says.
std::vector<trajectory::PoseEdge> makeFalseLoops(const loops::LoopCloser& closer, double share,
                                                 std::uint64_t seed) {
  const auto& list = closer.keyframes().list();
  trajectory::PoseEdge like;
  std::size_t num_loops = 0;
  for (const auto& edge : closer.graph().edges()) {
    if (edge.kind != trajectory::EdgeKind::kLoop) continue;
    like = edge;
    ++num_loops;
  }
  std::vector<trajectory::PoseEdge> edges;
  simulation::Random random(seed);
  const double wanted = share / (1.0 - share) * static_cast<double>(num_loops);
  while (static_cast<double>(edges.size()) < wanted) {
    const auto& a = list[static_cast<std::size_t>(random.integer(static_cast<int>(list.size())))];
    const auto& b = list[static_cast<std::size_t>(random.integer(static_cast<int>(list.size())))];
    if (a.id == b.id) continue;
    Pose off = Pose::Identity();
    off.linear() = Eigen::AngleAxisd(random.uniform(-0.3, 0.3), Eigen::Vector3d::UnitY()).matrix();
    off.translation() = Eigen::Vector3d(random.uniform(-2.0, 2.0), 0.0, random.uniform(-2.0, 2.0));
    edges.push_back({a.id, b.id, a.T_world_camera.inverse() * b.T_world_camera * off,
                     like.information, trajectory::EdgeKind::kLoop});
  }
  return edges;
}

/// What true poses of the loop closures that were accepted would leave.
double computeBound(const World& world, const loops::LoopCloser& closer,
                    const loops::LoopCloserConfig& config) {
  auto graph = trajectory::makePoseGraph(closer.keyframes(), config.odometry, config.graph);
  const trajectory::Matrix6d information = 400.0 * trajectory::Matrix6d::Identity();
  for (const auto& record : closer.records()) {
    const Pose T_a_b = world.truth(record.a).inverse() * world.truth(record.b);
    if (!loops::isAccepted(record, closer.graph())) continue;
    graph.addEdge({record.a, record.b, T_a_b, information, trajectory::EdgeKind::kLoop});
  }
  graph.optimize();
  return world.computeError(graph);
}

void printRecords(const World& world, const loops::LoopCloser& closer) {
  for (const auto& record : closer.records()) {
    const Pose T_true = world.truth(record.a).inverse() * world.truth(record.b);
    const Pose& T = record.registration.T_target_source;
    std::printf(
        "  %4d %4d away %5.2f cos %.2f landmarks %2d overlap %.2f rms %.3f eig %.3f through %.3f "
        "off "
        "%.3f m %.2f deg: %s\n",
        static_cast<int>(record.a.value), static_cast<int>(record.b.value),
        T_true.translation().norm(), record.image_cosine, static_cast<int>(record.num_landmarks),
        record.registration.overlap, record.registration.rms_m,
        record.registration.least_eigenvalue, record.visibility.shareThrough(),
        (T.translation() - T_true.translation()).norm(),
        57.3 * Eigen::AngleAxisd(Eigen::Matrix3d(T.linear().transpose() * T_true.linear())).angle(),
        loops::describeOutcome(record, closer.graph()).c_str());
  }
}

void writeTrajectories(const World& world, const loops::LoopCloser& closer,
                       const std::string& stem) {
  Trajectory truth;
  Trajectory before;
  Trajectory after;
  const auto& list = closer.keyframes().list();
  for (std::size_t k = 0; k < list.size(); ++k) {
    truth.add(list[k].stamp, world.truth(list[k].id));
    before.add(list[k].stamp, list[k].T_world_camera);
    after.add(list[k].stamp, closer.graph().keyframes()[k].T_world_keyframe);
  }
  writeTumTrajectory(stem + "_truth.tum", truth, "T_world_camera");
  writeTumTrajectory(stem + "_before.tum", before, "T_world_camera");
  writeTumTrajectory(stem + "_after.tum", after, "T_world_camera");
}

/// How wrong what was accepted is, and whether what is said of it is honest: the mean chi2 against
/// true poses, for each degree of freedom; 1 where deviations are as stated, below where they are
/// stated too large.
struct Honesty {
  int num_believed = 0;
  int num_off_10_cm = 0;
  int num_off_30_cm = 0;
  double loops = 0.0;
  double odometry = 0.0;  ///< of the edges between keyframes
};

double computeChi2(const trajectory::PoseEdge& edge, const World& world) {
  const trajectory::Vector6d error =
      trajectory::computeError(edge, world.truth(edge.a), world.truth(edge.b));
  return error.dot(edge.information * error);
}

Honesty measureHonesty(const World& world, const trajectory::PoseGraph& graph) {
  Honesty honesty;
  int num_odometry = 0;
  for (std::size_t i = 0; i < graph.edges().size(); ++i) {
    const trajectory::PoseEdge& edge = graph.edges()[i];
    if (edge.kind == trajectory::EdgeKind::kOdometry) {
      ++num_odometry;
      honesty.odometry += computeChi2(edge, world) / 6.0;
    } else if (graph.verdicts()[i] == trajectory::Verdict::kBelieved) {
      const Pose T_true = world.truth(edge.a).inverse() * world.truth(edge.b);
      const double off_m = (edge.T_a_b.translation() - T_true.translation()).norm();
      ++honesty.num_believed;
      honesty.num_off_10_cm += off_m > 0.1 ? 1 : 0;
      honesty.num_off_30_cm += off_m > 0.3 ? 1 : 0;
      honesty.loops += computeChi2(edge, world) / 6.0;
    }
  }
  honesty.loops /= std::max(1, honesty.num_believed);
  honesty.odometry /= std::max(1, num_odometry);
  return honesty;
}

void evaluate(const Arguments& arguments, int seed, double drift) {
  World world;
  world.walk = makeDriftingWalk(seed, arguments.rooms, arguments.laps, drift);
  const loops::LoopCloserConfig& config = arguments.config;
  world.indices = selectPoses(world.walk, config.keyframes);
  loops::LoopCloser closer("odom", config);
  feed(world, arguments, closer);
  const double before_m =
      world.computeError(trajectory::makePoseGraph(closer.keyframes(), config.odometry));
  const double after_m = world.computeError(closer.graph());
  const double bound_m = computeBound(world, closer, config);
  const double at_once_m = world.computeError(rebuild(closer, config, {}));
  const auto wrong = makeFalseLoops(closer, arguments.false_share, 77);
  const double with_false_m = world.computeError(rebuild(closer, config, wrong));
  const Honesty honesty = measureHonesty(world, closer.graph());
  std::printf(
      "%4d  %.2f  %4d  %4d  %4d  %2d  %2d  %6.3f  %6.3f  %5.1f %%  %5.1f %%  %6.3f  %6.3f  %5.2f  "
      "%5.2f\n",
      seed, drift, static_cast<int>(world.indices.size()),
      static_cast<int>(closer.records().size()), honesty.num_believed, honesty.num_off_10_cm,
      honesty.num_off_30_cm, before_m, after_m, 100.0 * (1.0 - after_m / before_m),
      100.0 * (1.0 - bound_m / before_m), at_once_m, with_false_m, honesty.loops, honesty.odometry);
  if (arguments.verbose) printRecords(world, closer);
  if (!arguments.trajectories.empty()) {
    writeTrajectories(world, closer, arguments.trajectories + std::to_string(seed));
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  options::options_description description("options");
  description.add_options()("help,h", "print this")("seed", options::value(&arguments.first_seed),
                                                    "first seed (1)")(
      "seeds", options::value(&arguments.num_seeds), "how many (5)")(
      "rooms", options::value(&arguments.rooms), "(6)")("laps", options::value(&arguments.laps),
                                                        "of each walk (2)")(
      "width", options::value(&arguments.width), "of the images, px (160)")(
      "drift", options::value(&arguments.drifts)->multitoken(), "shares (0.01 0.02 0.03)")(
      "without-images", options::bool_switch(&arguments.without_images), "depth only")(
      "min-overlap", options::value(&arguments.config.loops.min_overlap), "as close_loops")(
      "min-eigenvalue", options::value(&arguments.config.loops.min_eigenvalue), "")(
      "loop-angle", options::value(&arguments.config.loops.loop_angle_rad), "rad, deviation")(
      "verbose", options::bool_switch(&arguments.verbose), "print every pair that was tried")(
      "trajectories", options::value(&arguments.trajectories), "write TUM files of this stem");
  options::variables_map values;
  options::store(options::parse_command_line(argc, argv, description), values);
  options::notify(values);
  if (values.count("help") > 0) {
    std::cout << description;
    return 0;
  }
  std::puts(
      "seed drift keyframes tried believed off_10_cm off_30_cm before_m after_m removed bound "
      "at_once_m false_m chi2_loops chi2_odometry");
  for (const double drift : arguments.drifts) {
    for (int k = 0; k < arguments.num_seeds; ++k)
      evaluate(arguments, arguments.first_seed + k, drift);
  }
  return 0;
}
