// SPDX-License-Identifier: BSD-3-Clause
// Renders a walk through a generated apartment or another world into a bag, with its ground truth
// beside it.
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>

#include "task_scene_graph/config/config.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/core/trajectory.h"
#include "task_scene_graph/mapping/ply.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/drift.h"
#include "task_scene_graph/simulation/ground_truth.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/seen_surface.h"
#include "task_scene_graph/simulation/segment_simulator.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"
#include "task_scene_graph/simulation/world.h"
#include "task_scene_graph/simulation/world_mesh.h"

namespace {

namespace fs = std::filesystem;
using namespace tsg;
using namespace tsg::simulation;

constexpr const char* kUsage =
    R"(usage: simulate_apartment --output FILE.bag [options]
Renders a walk through a generated apartment. Beside the bag: FILE.object_tasks.yaml and
FILE.place_tasks.yaml (names and embeddings), FILE.ground_truth/ (instances, rooms, tasks, poses, labels, mesh).
Worlds other than the apartment have things that touch, such as stacks of books; object_tasks is about
them one by one, FILE.coarse_tasks.yaml and FILE.ground_truth/coarse_tasks.yaml are about the stacks.
  --world NAME        apartment, cubicle, office or building (apartment)
  --seed N            the apartment and its noise follow from it (1)
  --rooms N           of an apartment: 3 to 8, the corridor among them (6)
  --duration S        the walk ends after S seconds; 0 = when every room has been seen (0)
  --rate HZ           frames per second (10)
  --width W           of the images; the field of view stays the same (640)
  --height H          (480)
  --laps N            how often the rooms are seen; not over stairs (1)
  --drift SHARE       tf is odometry that drifts: its position by this share of the way, its heading by
                      1 degree, both after 10 m; FILE.ground_truth/poses.txt stays true, odometry.txt
                      beside it is what tf says (0)
  --noise on|off      depth as an active stereo camera measures it, or exact (on)
  --no-segmentation   no /segmentation, and tasks in words only: for networks that look at the images
  --threads N         the result does not depend on it (all cores)
)";

// ROS reads time 0 as "not set"; messages of a frame are recorded apart, so that players keep them
// in order.
constexpr std::int64_t kStart_ns = 1000000000;
constexpr std::int64_t kRecordingStep_ns = 100000;
constexpr int kStopsInClutter = 2;  ///< of a room: small things hide behind others
constexpr const char* kCameraFrame = "camera_color_optical_frame";

struct Options {
  fs::path output;
  WorldKind world = WorldKind::kApartment;
  ApartmentConfig apartment;
  WalkConfig walk;
  DriftConfig drift;
  CameraModel camera;
  bool drifts() const { return drift.position_per_m != 0.0; }
  bool noise = true;
  bool segmentation = true;
  int num_threads = 1;
};

double parseNumber(const std::string& option, const std::string& text) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size()) {
    throw std::invalid_argument(option + " '" + text + "', expected a number");
  }
  return value;
}

int parseInteger(const std::string& option, const std::string& text) {
  const double value = parseNumber(option, text);
  if (value != static_cast<double>(static_cast<int>(value))) {
    throw std::invalid_argument(option + " '" + text + "', expected a whole number");
  }
  return static_cast<int>(value);
}

bool parseSwitch(const std::string& option, const std::string& text) {
  if (text != "on" && text != "off") {
    throw std::invalid_argument(option + " '" + text + "', expected on or off");
  }
  return text == "on";
}

Options parseOptions(const std::vector<std::string>& arguments) {
  Options options;
  options.camera.width_px = 640;
  options.camera.height_px = 480;
  options.drift.position_per_m = 0.0;
  options.num_threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  using Setter = std::function<void(const std::string&, const std::string&)>;
  const auto setInteger = [](int& to) -> Setter {
    return [&to](const std::string& o, const std::string& v) { to = parseInteger(o, v); };
  };
  const auto setNumber = [](double& to) -> Setter {
    return [&to](const std::string& o, const std::string& v) { to = parseNumber(o, v); };
  };
  const std::map<std::string, Setter> setters = {
      {"--output",
       [&](const std::string&, const std::string& v) { options.output = expandPath(v); }},
      {"--world",
       [&](const std::string&, const std::string& v) { options.world = parseWorldKind(v); }},
      {"--seed", setInteger(options.apartment.seed)},
      {"--rooms", setInteger(options.apartment.num_rooms)},
      {"--duration", setNumber(options.walk.duration_s)},
      {"--rate", setNumber(options.walk.rate_hz)},
      {"--width", setInteger(options.camera.width_px)},
      {"--height", setInteger(options.camera.height_px)},
      {"--laps", setInteger(options.walk.laps)},
      {"--drift", setNumber(options.drift.position_per_m)},
      {"--threads", setInteger(options.num_threads)},
      {"--noise",
       [&](const std::string& o, const std::string& v) { options.noise = parseSwitch(o, v); }}};
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--no-segmentation") {
      options.segmentation = false;
      continue;
    }
    const auto found = setters.find(arguments[i]);
    if (found == setters.end()) throw std::invalid_argument("unknown option " + arguments[i]);
    if (i + 1 == arguments.size()) throw std::invalid_argument(arguments[i] + ": expected a value");
    found->second(arguments[i], arguments[i + 1]);
    ++i;
  }
  if (options.output.empty()) throw std::invalid_argument("--output is missing");
  if (options.num_threads < 1) throw std::invalid_argument("--threads, expected at least 1");
  options.drift.seed = options.apartment.seed;
  config::validate(options.drift, "drift");
  options.camera = makeDefaultCamera(options.camera.width_px, options.camera.height_px);
  options.camera.validate();
  return options;
}

sensor_msgs::CameraInfo toCameraInfo(const CameraModel& camera, Stamp stamp) {
  sensor_msgs::CameraInfo info;
  info.header.stamp = ros_interface::toRosTime(stamp);
  info.header.frame_id = kCameraFrame;
  info.width = static_cast<std::uint32_t>(camera.width_px);
  info.height = static_cast<std::uint32_t>(camera.height_px);
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0.0);
  info.K = {camera.fx_px, 0.0, camera.cx_px, 0.0, camera.fy_px, camera.cy_px, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {camera.fx_px, 0.0, camera.cx_px, 0.0, 0.0, camera.fy_px,
            camera.cy_px, 0.0, 0.0,          0.0, 1.0, 0.0};
  return info;
}

tf2_msgs::TFMessage toTfMessage(const Pose& T_world_camera, Stamp stamp) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.stamp = ros_interface::toRosTime(stamp);
  message.transforms[0].header.frame_id = "world";
  message.transforms[0].child_frame_id = kCameraFrame;
  message.transforms[0].transform = ros_interface::toTransform(T_world_camera);
  return message;
}

class BagWriter {
 public:
  BagWriter(const Options& options, const Apartment& apartment)
      : options_(options),
        renderer_(apartment, options.num_threads),
        segments_(apartment, SegmentConfig{}) {}

  /// @param T_world_odometry  where odometry says that the camera is
  void writeFrame(rosbag::Bag& bag, const WalkPose& pose, const Pose& T_world_odometry,
                  std::int64_t frame) {
    const RenderedView view = renderer_.render(options_.camera, pose.T_world_camera);
    seen_.add(view, options_.camera, pose.T_world_camera);
    const Stamp stamp{kStart_ns + pose.stamp.ns};
    int step = 0;
    const auto write = [&](const char* topic, const auto& message) {
      const Stamp recorded{stamp.ns + kRecordingStep_ns * step++};
      bag.write(topic, ros_interface::toRosTime(recorded), message);
    };
    write("/tf", toTfMessage(T_world_odometry, stamp));
    write("/camera/color/camera_info", toCameraInfo(options_.camera, stamp));
    write("/camera/aligned_depth_to_color/image_raw",
          *ros_interface::toImageMessage(measureDepth(view, frame), "16UC1", stamp, kCameraFrame));
    write("/camera/color/image_raw",
          *ros_interface::toImageMessage(view.color, "rgb8", stamp, kCameraFrame));
    if (!options_.segmentation) return;
    const Segmentation segmentation = segments_.segment(view, stamp, frame);
    write("/segmentation", *ros_interface::toMessage(segmentation, kCameraFrame));
  }

  const SeenSurface& seen() const { return seen_; }

 private:
  cv::Mat measureDepth(const RenderedView& view, std::int64_t frame) const {
    const DepthNoiseConfig noise;
    if (!options_.noise) return toMillimetres(view.depth_m, noise.min_range_m, noise.max_range_m);
    return simulateDepthSensor(view.depth_m, options_.camera, noise,
                               static_cast<std::uint64_t>(options_.apartment.seed), frame,
                               options_.num_threads);
  }

  const Options& options_;
  SeenSurface seen_;
  Renderer renderer_;
  SegmentSimulator segments_;
};

void showProgress(std::size_t done, std::size_t total) {
  const bool is_terminal = isatty(STDERR_FILENO) == 1;
  if (!is_terminal && done != total && done % std::max<std::size_t>(1, total / 10) != 0) return;
  if (is_terminal) {
    const std::size_t filled = 40 * done / total;
    std::cerr << "\r[" << std::string(filled, '#') << std::string(40 - filled, '.') << "] " << done
              << "/" << total << " frames" << (done == total ? "\n" : "") << std::flush;
  } else {
    std::cerr << "[simulate_apartment] " << done << "/" << total << " frames\n";
  }
}

SeenSurface writeBag(const Options& options, const Apartment& apartment,
                     const std::vector<WalkPose>& walk, const std::vector<WalkPose>& odometry) {
  BagWriter writer(options, apartment);
  replaceFile(options.output, [&](const fs::path& temporary) {
    rosbag::Bag bag(temporary.string(), rosbag::bagmode::Write);
    for (std::size_t i = 0; i < walk.size(); ++i) {
      writer.writeFrame(bag, walk[i], odometry[i].T_world_camera, static_cast<std::int64_t>(i));
      showProgress(i + 1, walk.size());
    }
    bag.close();
  });
  return writer.seen();
}

void writeOdometry(const fs::path& path, const std::vector<WalkPose>& odometry) {
  Trajectory trajectory;
  for (const WalkPose& pose : odometry) {
    trajectory.add({kStart_ns + pose.stamp.ns}, pose.T_world_camera);
  }
  writeTumTrajectory(path.string(), trajectory, "T_world_camera by odometry");
}

/// Tasks and truth beside the bag. Returns what was written.
std::vector<WrittenFile> writeTruth(const Options& options, const Apartment& world,
                                    const SeenSurface& seen, std::vector<WalkPose> walk) {
  fs::path stem = options.output;
  if (stem.extension() == ".bag") stem.replace_extension();
  const bool is_apartment = options.world == WorldKind::kApartment;
  const fs::path truth = stem.string() + ".ground_truth";
  std::vector<WrittenFile> files{{options.output.string(), formatCount(walk.size(), "frame")}};
  const auto writeTasks = [&](const char* ending, const std::vector<TaskTruth>& tasks) {
    const fs::path path = stem.string() + ending;
    (options.segmentation ? writeTaskEmbeddings : writeTaskNames)(path, tasks);
    files.push_back({path.string(), formatCount(tasks.size(), "task")});
  };
  const std::vector<TaskTruth> tasks =
      is_apartment ? makeObjectTasks(world) : makeGroupTasks(world, TaskGrain::kFine);
  writeTasks(".object_tasks.yaml", tasks);
  writeTasks(".place_tasks.yaml", makePlaceTasks(world));
  for (WalkPose& pose : walk) pose.stamp.ns += kStart_ns;
  writeGroundTruth(truth, world, tasks, walk);
  mapping::writePly(truth / "mesh.ply", computeMesh(world));
  seen.write(truth / "labels.ply", world, tasks);
  if (!is_apartment) {
    const std::vector<TaskTruth> coarse = makeGroupTasks(world, TaskGrain::kCoarse);
    writeTasks(".coarse_tasks.yaml", coarse);
    writeTaskTruth(truth / "coarse_tasks.yaml", world, coarse);
    seen.write(truth / "coarse_labels.ply", world, coarse);
  }
  files.push_back({truth.string() + "/", formatCount(world.instances.size(), "instance")});
  return files;
}

void simulate(const Options& options) {
  const Apartment world = buildWorld(options.world, options.apartment);
  WalkConfig walk_config = options.walk;
  if (options.world != WorldKind::kApartment) walk_config.stops_per_room = kStopsInClutter;
  const std::vector<WalkPose> walk = planWalk(world, walk_config);
  std::cout << "[simulate_apartment] seed " << options.apartment.seed << ": " << world.rooms.size()
            << " rooms, " << world.instances.size() << " things, " << walk.size() << " frames\n";
  if (walk.empty()) throw std::runtime_error("the walk has no frame; raise --duration or --rate");
  const auto odometry = options.drifts() ? simulateDrift(walk, options.drift) : walk;
  const SeenSurface seen = writeBag(options, world, walk, odometry);
  const std::vector<WrittenFile> files = writeTruth(options, world, seen, walk);
  if (options.drifts()) writeOdometry(fs::path(files.back().name) / "odometry.txt", odometry);
  std::cout << "[simulate_apartment] " << describeWritten({}, files) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  for (const std::string& argument : arguments) {
    if (argument == "--help" || argument == "-h") {
      std::cout << kUsage;
      return 0;
    }
  }
  try {
    simulate(parseOptions(arguments));
  } catch (const std::invalid_argument& error) {
    std::cerr << "simulate_apartment: " << error.what() << "\n" << kUsage;
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "simulate_apartment: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
