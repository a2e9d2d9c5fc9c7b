// SPDX-License-Identifier: BSD-3-Clause
// A walk through a building without end: CPU time per frame and resident memory over the minutes,
// as CSV for plot_long_walk.py. Frames are small, rendered in closed form and not counted.
#include <unistd.h>

#include <boost/program_options.hpp>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iostream>
#include <random>

#include "synthetic_scene.h"
#include "task_scene_graph/mapping/background_map.h"
#include "task_scene_graph/mapping/mesh_table.h"
#include "task_scene_graph/pipeline/background_fusion.h"

namespace tsg::mapping {
namespace {

constexpr double kSpeed_mps = 0.5;
constexpr double kBay_m = 3.0;  // furniture repeats in kind, not in place
const CameraModel kCamera{120, 90, 100.0, 100.0, 59.5, 44.5};

/// Crates of this stretch of the corridor, the same each time it is asked for.
void addBay(int bay, std::vector<test::Solid>& scene) {
  std::mt19937 random(static_cast<unsigned>(bay + 1000));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d size(0.3 + unit(random), 0.3 + 0.3 * unit(random),
                               0.3 + 1.2 * unit(random));
    const Eigen::Vector3d low(kBay_m * (bay + 0.5 * unit(random)), side > 0 ? 1.8 - size.y() : -1.8,
                              0.0);
    const auto shade = static_cast<std::uint8_t>(60 + 150 * unit(random));
    scene.push_back(test::makeBox({low, low + size}, {shade, 90, 60}));
  }
}

std::vector<test::Solid> makeScene(double x_m) {
  std::vector<test::Solid> scene{test::makePlane({0, 0, 0}, {0, 0, 1}, {90, 90, 90}),
                                 test::makePlane({0, 1.8, 0}, {0, -1, 0}, {150, 200, 90}),
                                 test::makePlane({0, -1.8, 0}, {0, 1, 0}, {90, 120, 200})};
  const int bay = static_cast<int>(std::floor(x_m / kBay_m));
  for (int i = bay - 2; i <= bay + 2; ++i) addBay(i, scene);
  return scene;
}

RgbdFrame makeFrame(double seconds) {
  const double x_m = kSpeed_mps * seconds;
  const double look_rad = 0.9 * std::sin(0.8 * seconds);  // left and right
  const Eigen::Vector3d eye(x_m, 0.3 * std::sin(0.3 * seconds), 1.3);
  const Eigen::Vector3d ahead(std::cos(look_rad), std::sin(look_rad), -0.25);
  auto frame = test::render(makeScene(x_m), kCamera, test::lookAt(eye, eye + ahead)).frame;
  frame.stamp = Stamp::fromSeconds(seconds);
  return frame;
}

double readResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0.0;
  statm >> pages >> pages;  // the second number
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// CPU time of this process: one thread works here, and others may share the machine.
class Clock {
 public:
  double elapsedMs() const {
    return 1e3 * static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC;
  }

 private:
  std::clock_t start_ = std::clock();
};

struct Options {
  double minutes = 30.0;
  double rate_hz = 5.0;
  bool archive = true;
  bool snapshots = false;
};

/// What saving costs: the time that integration waits for a table of all meshes, and the time that
/// the reader of the table takes for the whole mesh, during which integration once waited.
void printSnapshot(BackgroundMap& map) {
  const Clock taking;
  map.updateMesh();
  const MeshTable table = map.meshes();
  const double taking_ms = taking.elapsedMs();
  const Clock reading;
  const Mesh whole = mergeMeshes(table);
  std::cout << ',' << taking_ms << ',' << reading.elapsedMs() << ',' << whole.triangles.size();
}

void walk(const Options& options) {
  pipeline::BackgroundFusionConfig defaults;
  for (auto* map : {&defaults.background, &defaults.free_space}) {
    map->tsdf.num_threads = 1;
    map->archive_blocks = options.archive;
  }
  BackgroundMap background(defaults.background);
  BackgroundMap free_space(defaults.free_space);
  std::cout << "minute,integration_ms,mesh_ms,resident_mb,blocks,archive_file_mb"
            << (options.snapshots ? ",snapshot_ms,whole_mesh_ms,triangles\n" : "\n");
  double integration_ms = 0.0;
  double mesh_ms = 0.0;
  int frames = 0;
  const int per_update = static_cast<int>(std::ceil(options.rate_hz));
  const int per_row = static_cast<int>(std::ceil(30.0 * options.rate_hz));
  const int total = static_cast<int>(60.0 * options.minutes * options.rate_hz);
  for (int i = 1; i <= total; ++i) {
    const RgbdFrame frame = makeFrame(i / options.rate_hz);
    const Clock integration;
    background.integrate(frame);
    free_space.integrate(frame);
    integration_ms += integration.elapsedMs();
    ++frames;
    if (i % per_update == 0) {
      const Clock mesh;
      background.updateMesh();
      mesh_ms += mesh.elapsedMs();
    }
    if (i % per_row != 0) continue;
    std::cout << i / options.rate_hz / 60.0 << ',' << integration_ms / frames << ','
              << mesh_ms / frames << ',' << readResidentMegabytes() << ','
              << background.volume().blocks().size() + free_space.volume().blocks().size() << ','
              << static_cast<double>(background.archive().fileBytes()) / 1e6;
    if (options.snapshots) printSnapshot(background);
    std::cout << std::endl;
    integration_ms = mesh_ms = 0.0;
    frames = 0;
  }
}

}  // namespace
}  // namespace tsg::mapping

int main(int argc, char** argv) {
  namespace po = boost::program_options;
  tsg::mapping::Options options;
  po::options_description description("usage: long_walk_benchmark [options] > walk.csv");
  auto add = description.add_options();
  add("help", "print this");
  add("minutes", po::value(&options.minutes), "length of the walk (30)");
  add("rate_hz", po::value(&options.rate_hz), "frames per second (5)");
  add("snapshots", po::value(&options.snapshots), "also read the whole mesh with each row (false)");
  add("archive", po::value(&options.archive), "drop voxels far away and long unseen (true)");
  try {
    po::variables_map given;
    po::store(po::parse_command_line(argc, argv, description), given);
    po::notify(given);
    if (given.count("help") > 0) {
      std::cout << description;
      return 0;
    }
    tsg::mapping::walk(options);
  } catch (const std::exception& e) {
    std::cerr << "long_walk_benchmark: " << e.what() << "\n";
    return 1;
  }
  return 0;
}
