// SPDX-License-Identifier: BSD-3-Clause
// The whole chain (depth integration, mesh, tracker, objects, places, scene graph) on a walk down a
// corridor with rooms on both sides: time per frame and memory by the distance walked, as CSV for
// plot_growth.py. Images are small, rendered in closed form; rendering is not counted.
#include <malloc.h>
#include <unistd.h>

#include <boost/program_options.hpp>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>

#include "synthetic_scene.h"
#include "task_scene_graph/pipeline/pipeline.h"
#include "task_scene_graph/simulation/embedding_space.h"
#include "task_scene_graph/simulation/random.h"

namespace tsg {
namespace {

constexpr double kBay_m = 6.0;  // a room to the left and one to the right
constexpr double kHalfWidth_m = 1.2;
constexpr double kRoomDepth_m = 4.0;
constexpr double kWall_m = 0.2;
constexpr double kHeight_m = 2.5;
const CameraModel kCamera{120, 90, 75.0, 75.0, 59.5, 44.5};

const std::vector<std::string> kPhrases{"red box",   "office chair", "bookshelf", "waste bin",
                                        "desk lamp", "printer",      "sofa",      "plant"};

/// A thing in a room; its label is its place in the scene's list, from 1.
struct Thing {
  std::string phrase;
  std::uint64_t id = 0;
};

struct Scene {
  std::vector<test::Solid> solids;
  std::vector<Thing> things;
};

test::Solid makeBox(double x0, double y0, double z0, double x1, double y1, double z1,
                    cv::Vec3b color, std::uint16_t label = 0) {
  return test::makeBox(
      {Eigen::Vector3d(x0, std::min(y0, y1), z0), Eigen::Vector3d(x1, std::max(y0, y1), z1)}, color,
      label);
}

/// The walls of a bay on one side (+1 or -1), with a door of 1.2 m, and two things in its room.
void addRoom(int bay, double side, Scene& scene) {
  const double x = kBay_m * bay + (side > 0 ? 0.0 : 0.5 * kBay_m);  // one door after the other
  const double y = side * kHalfWidth_m;
  const double back = side * (kHalfWidth_m + kWall_m + kRoomDepth_m);
  const cv::Vec3b paint(200, static_cast<std::uint8_t>(150 + 10 * (bay % 10)), 170);
  scene.solids.push_back(makeBox(x, y, 0, x + 2.4, y + side * kWall_m, kHeight_m, paint));
  scene.solids.push_back(makeBox(x + 3.6, y, 0, x + kBay_m, y + side * kWall_m, kHeight_m, paint));
  scene.solids.push_back(makeBox(x, y, 0, x + kWall_m, back, kHeight_m, paint));
  scene.solids.push_back(makeBox(x, back, 0, x + kBay_m, back + side * kWall_m, kHeight_m, paint));
  simulation::Random random(
      simulation::combineSeeds(static_cast<std::uint64_t>(bay + 1000), side > 0 ? 1 : 2));
  for (int i = 0; i < 2; ++i) {
    const double at_x = x + 1.4 + 2.0 * i + random.uniform(0.0, 0.4);
    const double at_y = y + side * random.uniform(1.5, 2.5);
    const double height_m = random.uniform(0.5, 1.2);
    scene.things.push_back(
        {kPhrases[static_cast<std::size_t>(random.integer(8))],
         static_cast<std::uint64_t>(1000 * (bay + 10) + 2 * i) + (side > 0 ? 1U : 0U)});
    const auto shade = static_cast<std::uint8_t>(40 + random.integer(180));
    scene.solids.push_back(makeBox(at_x, at_y, 0, at_x + 0.6, at_y + side * 0.6, height_m,
                                   {shade, 90, 200},
                                   static_cast<std::uint16_t>(scene.things.size())));
  }
}

Scene makeScene(double x_m) {
  Scene scene;
  scene.solids.push_back(test::makePlane({0, 0, 0}, {0, 0, 1}, {120, 120, 110}));
  const int bay = static_cast<int>(std::floor(x_m / kBay_m));
  for (int i = bay - 1; i <= bay + 1; ++i) {
    addRoom(i, 1.0, scene);
    addRoom(i, -1.0, scene);
  }
  return scene;
}

/// Walks along x and looks into the rooms to both sides, one after the other.
Pose computePose(double x_m) {
  const double look_rad = 1.2 * std::sin(2.0 * M_PI * (x_m - 1.0) / kBay_m);
  const Eigen::Vector3d eye(x_m, 0.2 * std::sin(0.3 * x_m), 1.4);
  return test::lookAt(eye, eye + Eigen::Vector3d(std::cos(look_rad), std::sin(look_rad), -0.35));
}

class Walker {
 public:
  /// A frame and what a segmenter would say of it.
  std::pair<RgbdFramePtr, SegmentationPtr> observe(double x_m, double seconds) {
    const Scene scene = makeScene(x_m);
    auto rendering = test::render(scene.solids, kCamera, computePose(x_m));
    auto frame = std::make_shared<RgbdFrame>(std::move(rendering.frame));
    frame->stamp = Stamp::fromSeconds(seconds);
    auto segmentation = std::make_shared<Segmentation>();
    segmentation->stamp = frame->stamp;
    segmentation->labels = rendering.labels;
    segmentation->embeddings.resize(static_cast<Eigen::Index>(scene.things.size()),
                                    simulation::EmbeddingSpace::kSize);
    for (std::size_t i = 0; i < scene.things.size(); ++i) {
      const Thing& thing = scene.things[i];
      segmentation->embeddings.row(static_cast<Eigen::Index>(i)) =
          space_.encodeImage({{thing.phrase, 1.0}}, thing.phrase, thing.id, ++num_views_);
    }
    segmentation->confidences.assign(scene.things.size(), 0.9F);
    segmentation->image_embedding =
        space_.encodeImage({{"office corridor", 1.0}}, "corridor", 1, ++num_views_);
    return {frame, segmentation};
  }
  scene_graph::TaskList makeTasks() const {
    scene_graph::TaskList tasks;
    for (const auto& phrase : {"office chair", "bookshelf", "plant"}) {
      tasks.names.push_back(phrase);
      tasks.embeddings.conservativeResize(static_cast<Eigen::Index>(tasks.names.size()),
                                          simulation::EmbeddingSpace::kSize);
      tasks.embeddings.bottomRows(1) = space_.encodeText(phrase).transpose();
    }
    return tasks;
  }

 private:
  simulation::EmbeddingSpace space_;
  std::uint64_t num_views_ = 0;
};

double readResidentMegabytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double pages = 0.0;
  statm >> pages >> pages;  // the second number
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// CPU time of this process, all threads: others may share the machine.
double readCpuMs() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Wall time that each stage took since the row before, per frame.
class StageDurations {
 public:
  std::map<std::string, double> computeSinceLastRow(const StageTimes& times, int frames) {
    std::map<std::string, double> per_frame_ms;
    for (const auto& [name, summary] : times.summarize()) {
      const double total_ms = summary.mean_ms * static_cast<double>(summary.count);
      per_frame_ms[name] = (total_ms - totals_ms_[name]) / frames;
      totals_ms_[name] = total_ms;
    }
    return per_frame_ms;
  }

 private:
  std::map<std::string, double> totals_ms_;
};

struct Options {
  double metres = 1000.0;
  double speed_mps = 1.0;
  double rate_hz = 5.0;
  double row_m = 25.0;
};

void walk(const Options& options) {
  Walker walker;
  pipeline::PipelineConfig config;
  config.mesh_fusion.background_fusion.background.tsdf.num_threads = 1;
  config.mesh_fusion.background_fusion.free_space.tsdf.num_threads = 1;
  pipeline::Pipeline chain(config, walker.makeTasks(), {}, nullptr);
  std::cout << "metres,cpu_ms,background_ms,tracking_ms,objects_ms,places_ms,scene_graph_ms,"
               "resident_mb,places,primitives\n";
  StageDurations durations;
  double cpu_ms = 0.0;
  int frames = 0;
  double next_row_m = options.row_m;
  const double step_m = options.speed_mps / options.rate_hz;
  for (double x_m = 0.0; x_m <= options.metres; x_m += step_m) {
    const auto [frame, segmentation] = walker.observe(x_m, x_m / options.speed_mps);
    const double start_ms = readCpuMs();
    chain.process(frame, segmentation);
    cpu_ms += readCpuMs() - start_ms;
    ++frames;
    if (x_m + step_m < next_row_m) continue;
    auto stages = durations.computeSinceLastRow(chain.times(), frames);
    std::cout << next_row_m << ',' << cpu_ms / frames << ',' << stages["background"] << ','
              << stages["tracking"] << ',' << stages["objects"] << ',' << stages["places"] << ','
              << stages["scene_graph"] << ',' << readResidentMegabytes() << ','
              << chain.places().graph().places.size() << ','
              << chain.sceneGraph().primitiveCounters().clustered << std::endl;
    next_row_m += options.row_m;
    cpu_ms = 0.0;
    frames = 0;
  }
}

}  // namespace
}  // namespace tsg

int main(int argc, char** argv) {
  namespace po = boost::program_options;
  tsg::Options options;
  po::options_description description("usage: growth_benchmark [options] > growth.csv");
  auto add = description.add_options();
  add("help", "print this");
  add("metres", po::value(&options.metres), "length of the walk (1000)");
  add("speed_mps", po::value(&options.speed_mps), "speed of the walk, metres per second (1)");
  add("rate_hz", po::value(&options.rate_hz), "frames per second (5)");
  add("row_m", po::value(&options.row_m), "a row for every so many metres (25)");
  try {
    po::variables_map given;
    po::store(po::parse_command_line(argc, argv, description), given);
    po::notify(given);
    if (given.count("help") > 0) {
      std::cout << description;
      return 0;
    }
    tsg::walk(options);
  } catch (const std::exception& e) {
    std::cerr << "growth_benchmark: " << e.what() << "\n";
    return 1;
  }
  return 0;
}
