// SPDX-License-Identifier: BSD-3-Clause
// Corrects the trajectory of a recorded walk by loop closures of our own.
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../command_line.h"
#include "input_options.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/loops/loop_closer.h"
#include "task_scene_graph/ros/input_config.h"
#include "task_scene_graph/ros/rgbd_bag.h"
#include "task_scene_graph/trajectory/correction.h"
#include "task_scene_graph/trajectory/trajectory_error.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  std::vector<std::string> bags;
  std::string output;
  std::string list;
  std::string truth;
  int passes = 2;
  loops::LoopConfig loops;
  tools::InputOptions input;
};

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  loops::LoopConfig& loops = arguments.loops;
  options::options_description description(
      "Finds places that a recorded walk sees again, and corrects its trajectory.\n"
      "usage: close_loops --bag B [B2 ...] --output NEW.tum [options]\n"
      "Poses are odometry's (tf, --pose-topic or --trajectory). Recorded segmentations, if there\n"
      "are, say what looks alike; else shape alone decides. Neither file is written unless both\n"
      "can be.\noptions");
  description.add_options()("help,h", "print this")(
      "bag", options::value(&arguments.bags)->required()->multitoken(),
      "rosbags with colour, depth, camera info, poses; several are read as one")(
      "output", tools::pathOption(arguments.output)->required(),
      "corrected poses of all frames, TUM's format")(
      "list", tools::pathOption(arguments.list),
      "JSON: each pair of places that was tried, in each pass, whether it was accepted, and why "
      "not")("truth", tools::pathOption(arguments.truth),
             "true poses, TUM's format: prints the error before and after")(
      "max-drift", options::value(&loops.max_drift),
      "of odometry, share of the way: farther apart no place is looked for; the larger, the less "
      "odometry is believed (0.05)")("max-candidates", options::value(&loops.max_candidates),
                                     "tried for each place (5)")(
      "min-overlap", options::value(&loops.min_overlap), "share of points that must fit (0.3)")(
      "min-eigenvalue", options::value(&loops.min_eigenvalue),
      "clouds that fix a motion less are refused (0.002)")(
      "passes", options::value(&arguments.passes),
      "from the second on, the result of the one before takes odometry's place (2)");
  options::options_description input("input: as process_bag's");
  arguments.input.addTo(input);
  description.add(input);
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  if (arguments.passes < 1 || arguments.passes > 10) {
    throw options::error("--passes is " + std::to_string(arguments.passes) + ", expected 1 to 10");
  }
  for (auto& bag : arguments.bags) bag = expandPath(bag).string();
  return arguments;
}

ros_interface::InputConfig loadInput(const Arguments& arguments) {
  return config::load<ros_interface::InputConfig>(
      std::vector<config::Source>{{"command line", arguments.input.toYaml(), {}}}, "input");
}

nlohmann::json toJson(const loops::LoopRecord& record, const loops::LoopCloser& closer) {
  const auto& keyframes = closer.keyframes();
  const auto& found = record.registration;
  const Eigen::Vector3d t = found.T_target_source.translation();
  const Eigen::Quaterniond q(found.T_target_source.linear());
  return {{"stamp_a_ns", keyframes.find(record.a)->stamp.ns},
          {"stamp_b_ns", keyframes.find(record.b)->stamp.ns},
          {"accepted", loops::isAccepted(record, closer.graph())},
          {"reason", loops::describeOutcome(record, closer.graph())},
          {"image_cosine", record.image_cosine},
          {"landmarks", record.num_landmarks},
          {"T_a_b", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}},
          {"overlap", found.overlap},
          {"rms_m", found.rms_m},
          {"share_through", record.visibility.shareThrough()},
          {"num_seen", record.visibility.num_seen + record.visibility.num_through},
          {"least_eigenvalue", found.least_eigenvalue}};
}

void requireNoFolder(const std::string& path) {
  if (!std::filesystem::is_directory(path)) return;
  throw std::runtime_error("'" + path + "' is a folder, expected a file to write");
}

/// The list's temporary file is complete before the trajectory is written, and gets its name after:
/// where either cannot be written, neither is there.
std::vector<WrittenFile> writeFiles(const Arguments& arguments, const nlohmann::json& list,
                                    const Trajectory& corrected) {
  const auto writeTrajectory = [&] {
    writeTumTrajectory(arguments.output, corrected, "T_world_camera, corrected");
  };
  std::vector<WrittenFile> files{{arguments.output, formatCount(corrected.size(), "pose")}};
  if (arguments.list.empty()) {
    writeTrajectory();
    return files;
  }
  writeFileAtomically(arguments.list, [&](std::ostream& out) {
    out << list.dump(1) << '\n' << std::flush;
    if (out) writeTrajectory();
  });
  files.push_back({arguments.list, formatCount(list.size(), "pair")});
  return files;
}

void printError(const Trajectory& truth, const Trajectory& before, const Trajectory& after) {
  const double before_m = trajectory::computeTrajectoryError(truth, before);
  const double after_m = trajectory::computeTrajectoryError(truth, after);
  std::cout << "error (root mean square, first pose fixed): " << before_m << " m before, "
            << after_m << " m after\n";
}

/// How many pairs ended how.
void printOutcomes(const loops::LoopCloser& closer) {
  std::map<std::string, int> counts;
  for (const auto& record : closer.records()) {
    if (record.edge) {
      ++counts[loops::describeOutcome(record, closer.graph())];
    } else {
      ++counts[loops::toText(record.outcome)];
    }
  }
  std::cout << closer.keyframes().list().size() << " keyframes, " << closer.records().size()
            << " pairs of places tried\n";
  for (const auto& [text, count] : counts) std::cout << "  " << count << ": " << text << '\n';
}

/// A pass over the whole walk.
struct Pass {
  loops::LoopCloser closer;
  Trajectory poses;  ///< as given: odometry, or what the pass before made of it
};

/// @param former  poses in odometry's place; null: the bag's
Pass closeLoops(ros_interface::RgbdBag& bag, const Arguments& arguments,
                const std::string& world_frame, const Trajectory* former) {
  Pass pass{loops::LoopCloser(world_frame, loops::makeLoopCloserConfig(arguments.loops)), {}};
  bag.forEachFrame(
      [&](const RgbdFramePtr& frame, const SegmentationPtr& recorded) {
        RgbdFrame moved = *frame;
        if (former != nullptr) moved.T_world_camera = former->poses().at(frame->stamp.ns);
        pass.closer.add(moved, recorded);
        pass.poses.add(moved.stamp, moved.T_world_camera);
        return true;
      },
      [](std::size_t) {});
  pass.closer.finish();
  return pass;
}

/// Adds the pairs of a pass, numbered from 1.
void listPairs(const loops::LoopCloser& closer, int pass, nlohmann::json& list) {
  for (const auto& record : closer.records()) {
    list.push_back(toJson(record, closer));
    list.back()["pass"] = pass;
  }
}

Trajectory computeCorrected(const Pass& pass) {
  const auto correction =
      trajectory::computeCorrection(pass.closer.keyframes(), pass.closer.correctedKeyframes());
  return trajectory::applyCorrection(correction, pass.closer.keyframes(), pass.poses);
}

void run(const Arguments& arguments) {
  const ros_interface::InputConfig input = loadInput(arguments);
  for (const std::string& path : {arguments.output, arguments.list}) requireNoFolder(path);
  std::optional<Trajectory> truth;
  if (!arguments.truth.empty()) truth = loadTumTrajectory(arguments.truth);
  ros_interface::RgbdBag bag(arguments.bags, input, true);
  Pass pass = closeLoops(bag, arguments, input.world_frame, nullptr);
  for (const auto& [reason, drops] : bag.drops()) {
    std::cerr << "dropped " << drops.count << " (" << reason << "): " << drops.example << "\n";
  }
  if (pass.poses.isEmpty()) {
    throw std::runtime_error("nothing was written: none of " +
                             std::to_string(bag.numColorImages()) + " colour images could be used");
  }
  const Trajectory odometry = pass.poses;
  nlohmann::json list = nlohmann::json::array();
  Trajectory corrected = odometry;
  for (int i = 1; i <= arguments.passes; ++i) {
    if (i > 1) pass = closeLoops(bag, arguments, input.world_frame, &corrected);
    corrected = computeCorrected(pass);
    if (arguments.passes > 1) std::cout << "pass " << i << ": ";
    printOutcomes(pass.closer);
    listPairs(pass.closer, i, list);
  }
  if (truth) printError(*truth, odometry, corrected);
  std::cout << describeWritten({}, writeFiles(arguments, list, corrected)) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("close_loops", argc, argv, parseArguments, run);
}
