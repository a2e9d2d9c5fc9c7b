// SPDX-License-Identifier: BSD-3-Clause
// Place graph and planner against the truth of generated apartments: parts, clearances, lengths of
// ways over places and of planned paths, time of updates (docs/places.md has the table).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <vector>

#include "place_heap.h"
#include "task_scene_graph/core/period.h"
#include "task_scene_graph/pipeline/background_fusion.h"
#include "task_scene_graph/places/place_extractor.h"
#include "task_scene_graph/planning/planner.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"
#include "tools/command_line.h"

namespace options = boost::program_options;
using namespace tsg;

namespace {

struct Arguments {
  int apartments = 10;
  int first_seed = 1;
  int num_starts = 12;
  double rate_hz = 5.0;
  int width_px = 320;
  double max_step_m = 0.12;  ///< lower things are no obstacles of the truth
};

constexpr double kRadius_m = 0.25;
constexpr double kBody_m = 1.2;
constexpr double kLeastDistance_m = 2.0;  ///< of the pairs of positions
constexpr int kGoalsPerStart = 8;

/// An apartment as the robot saw it.
struct Walked {
  std::vector<Eigen::Vector3d> cameras_m;
  std::vector<double> updates_ms;  ///< CPU time
  PlaceGraph graph;
  places::GroundPlan plan;
  test::PlaceHeap heap;
};

double measureCpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// As the running chain does: depth filtered, carved, an update of the places each second.
Walked walkThrough(const Arguments& arguments, const simulation::Apartment& apartment) {
  using namespace simulation;
  Walked walked;
  WalkConfig walk;
  walk.rate_hz = arguments.rate_hz;
  const CameraModel camera = makeDefaultCamera(arguments.width_px, arguments.width_px * 3 / 4);
  const Renderer renderer(apartment, 2);
  const pipeline::BackgroundFusionConfig config;
  pipeline::BackgroundFusion fusion(config);
  places::PlaceExtractor extractor(config.places);
  std::optional<Stamp> last_update;
  const auto update = [&](Stamp stamp) {
    const double start_ms = measureCpu_ms();
    const mapping::TsdfVolume changed = fusion.free_space.takeChangedBlocks();
    extractor.update(changed, changed.sortedBlockIndices(), stamp);
    walked.updates_ms.push_back(measureCpu_ms() - start_ms);
  };
  std::int64_t index = 0;
  for (const WalkPose& pose : planWalk(apartment, walk)) {
    RgbdFrame frame;
    frame.stamp = Stamp{pose.stamp.ns + 1000000000};
    frame.camera = camera;
    frame.T_world_camera = pose.T_world_camera;
    const RenderedView rendered = renderer.render(camera, pose.T_world_camera);
    const auto seed = static_cast<std::uint64_t>(apartment.config.seed);
    frame.depth.image =
        simulateDepthSensor(rendered.depth_m, camera, DepthNoiseConfig{}, seed, index++, 2);
    frame.color.image = cv::Mat::zeros(frame.depth.image.size(), CV_8UC3);
    fusion.free_space.integrate(*fusion.filter(frame));
    extractor.addPose({frame.stamp, frame.T_world_camera});
    walked.cameras_m.push_back(frame.T_world_camera.translation());
    if (isDue(last_update, frame.stamp, config.places_period_s)) {
      last_update = frame.stamp;
      update(frame.stamp);
    }
  }
  update(Stamp{1});
  walked.graph = extractor.graph();
  walked.plan = extractor.plan();
  walked.heap = test::measurePlaceHeap(extractor.memory(), config.places);
  return walked;
}

/// Shortest ways of a circle among the true obstacles: Dijkstra on a lattice of 0.05 m in 40
/// directions, at most 0.8 % too long besides what the lattice misses.
class TrueWays {
 public:
  TrueWays(const simulation::Apartment& apartment, const simulation::FloorMap& map) {
    Eigen::AlignedBox2d box;
    for (const auto& room : apartment.rooms) {
      box.extend(Eigen::Vector2d(room.interior_m.min()));
      box.extend(Eigen::Vector2d(room.interior_m.max()));
    }
    min_m_ = box.min() - Eigen::Vector2d::Constant(0.5);
    width_ = static_cast<int>((box.max().x() + 0.5 - min_m_.x()) / kLattice_m);
    height_ = static_cast<int>((box.max().y() + 0.5 - min_m_.y()) / kLattice_m);
    for (int cell = 0; cell < width_ * height_; ++cell) {
      is_free_.push_back(map.computeClearance(at(cell)) > kRadius_m ? 1 : 0);
    }
    for (int x = -4; x <= 4; ++x) {
      for (int y = -4; y <= 4; ++y) {
        if (std::gcd(x, y) == 1 && std::abs(x) + std::abs(y) <= 5) steps_.push_back({x, y});
      }
    }
  }

  bool isFree(const Eigen::Vector3d& p_m) const {
    const int cell = find(p_m);
    return cell >= 0 && is_free_[static_cast<std::size_t>(cell)] != 0;
  }

  /// Lengths to all cells; infinite where no way leads.
  std::vector<double> computeLengths(const Eigen::Vector3d& from_m) const {
    std::vector<double> lengths_m(is_free_.size(), std::numeric_limits<double>::infinity());
    using Item = std::pair<double, int>;
    std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
    lengths_m[static_cast<std::size_t>(find(from_m))] = 0.0;
    queue.emplace(0.0, find(from_m));
    while (!queue.empty()) {
      const auto [length_m, cell] = queue.top();
      queue.pop();
      if (length_m > lengths_m[static_cast<std::size_t>(cell)]) continue;
      for (const auto& [dx, dy] : steps_) {
        const double next_m = length_m + kLattice_m * std::hypot(dx, dy);
        const int next = findNext(cell, dx, dy);
        if (next < 0 || next_m >= lengths_m[static_cast<std::size_t>(next)]) continue;
        lengths_m[static_cast<std::size_t>(next)] = next_m;
        queue.emplace(next_m, next);
      }
    }
    return lengths_m;
  }

  /// -1 outside.
  int find(const Eigen::Vector3d& p_m) const {
    const Eigen::Vector2d local = (p_m.head<2>() - min_m_) / kLattice_m;
    if (local.x() < 0.0 || local.y() < 0.0) return -1;
    const int x = static_cast<int>(local.x());
    const int y = static_cast<int>(local.y());
    return x < width_ && y < height_ ? x + width_ * y : -1;
  }

 private:
  static constexpr double kLattice_m = 0.05;

  Eigen::Vector2d at(int cell) const {
    return min_m_ + kLattice_m * Eigen::Vector2d(cell % width_ + 0.5, cell / width_ + 0.5);
  }

  /// The cell a step away; -1 if it, or what lies between, is not free.
  int findNext(int cell, int dx, int dy) const {
    const int x0 = cell % width_;
    const int y0 = cell / width_;
    const int samples = 2 * std::max(std::abs(dx), std::abs(dy));
    for (int i = 1; i <= samples; ++i) {
      const int x = x0 + static_cast<int>(std::lround(static_cast<double>(dx * i) / samples));
      const int y = y0 + static_cast<int>(std::lround(static_cast<double>(dy * i) / samples));
      if (x < 0 || y < 0 || x >= width_ || y >= height_) return -1;
      if (is_free_[static_cast<std::size_t>(x + width_ * y)] == 0) return -1;
    }
    return x0 + dx + width_ * (y0 + dy);
  }

  Eigen::Vector2d min_m_;
  int width_ = 0;
  int height_ = 0;
  std::vector<char> is_free_;
  std::vector<std::array<int, 2>> steps_;
};

/// Ways over the edges of a place graph alone.
class RawWays {
 public:
  explicit RawWays(const PlaceGraph& graph) : graph_(graph), next_(graph.places.size()) {
    for (std::size_t i = 0; i < graph.places.size(); ++i) index_of_[graph.places[i].id] = i;
    for (const PlaceEdge& edge : graph.edges) {
      const std::size_t a = index_of_.at(edge.a);
      const std::size_t b = index_of_.at(edge.b);
      const double length_m = (graph.places[a].position_m - graph.places[b].position_m).norm();
      next_[a].emplace_back(b, length_m);
      next_[b].emplace_back(a, length_m);
    }
  }

  /// From a position to its nearest place, over places, and on to the goal.
  double computeLength(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const {
    const std::size_t first = findNearest(from_m);
    const std::size_t last = findNearest(to_m);
    std::vector<double> lengths_m(next_.size(), std::numeric_limits<double>::infinity());
    using Item = std::pair<double, std::size_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
    lengths_m[first] = computeGap(first, from_m);
    queue.emplace(lengths_m[first], first);
    while (!queue.empty() && queue.top().second != last) {
      const auto [length_m, place] = queue.top();
      queue.pop();
      if (length_m > lengths_m[place]) continue;
      for (const auto& [next, step_m] : next_[place]) {
        if (length_m + step_m >= lengths_m[next]) continue;
        lengths_m[next] = length_m + step_m;
        queue.emplace(lengths_m[next], next);
      }
    }
    return lengths_m[last] + computeGap(last, to_m);
  }

  std::size_t countParts() const {
    std::vector<char> is_reached(next_.size(), 0);
    std::size_t num_parts = 0;
    for (std::size_t seed = 0; seed < next_.size(); ++seed) {
      if (is_reached[seed] != 0) continue;
      ++num_parts;
      std::vector<std::size_t> open{seed};
      while (!open.empty()) {
        const std::size_t place = open.back();
        open.pop_back();
        if (is_reached[place] != 0) continue;
        is_reached[place] = 1;
        for (const auto& [next, ignored] : next_[place]) open.push_back(next);
      }
    }
    return num_parts;
  }

 private:
  double computeGap(std::size_t place, const Eigen::Vector3d& p_m) const {
    return (graph_.places[place].position_m - p_m).head<2>().norm();
  }
  std::size_t findNearest(const Eigen::Vector3d& p_m) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < next_.size(); ++i) {
      if (computeGap(i, p_m) < computeGap(best, p_m)) best = i;
    }
    return best;
  }

  const PlaceGraph& graph_;
  std::map<PlaceId, std::size_t> index_of_;
  std::vector<std::vector<std::pair<std::size_t, double>>> next_;
};

double findQuantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(share * last))];
}

struct Result {
  std::size_t num_places = 0;
  std::size_t num_parts = 0;
  std::size_t num_inside = 0;  ///< places less than 0.1 m from something
  int num_pairs = 0;
  int num_without_way = 0;       ///< over places
  int num_without_path = 0;      ///< of the planner
  std::vector<double> errors_m;  ///< clearance less the true one
  std::vector<double> raw;       ///< length over the true shortest
  std::vector<double> planned;
  std::vector<double> updates_ms;
  test::PlaceHeap heap;
};

void comparePlaces(const Walked& walked, const simulation::FloorMap& map, Result& result) {
  for (const Place& place : walked.graph.places) {
    const double true_m = map.computeClearance(place.position_m.head<2>());
    result.num_inside += true_m < 0.1 ? 1 : 0;
    result.errors_m.push_back(place.clearance_m - true_m);
  }
}

void compareWays(const Arguments& arguments, const Walked& walked, const TrueWays& truth,
                 Result& result) {
  const RawWays raw(walked.graph);
  const planning::Planner planner(walked.graph, walked.plan, planning::PlannerConfig{});
  result.num_parts = raw.countParts();
  std::mt19937 random(3);
  const auto draw = [&] { return walked.cameras_m[random() % walked.cameras_m.size()]; };
  for (int i = 0; i < arguments.num_starts; ++i) {
    const Eigen::Vector3d start_m = draw();
    if (!truth.isFree(start_m)) continue;
    const auto lengths_m = truth.computeLengths(start_m);
    for (int k = 0; k < kGoalsPerStart; ++k) {
      const Eigen::Vector3d goal_m = draw();
      if (!truth.isFree(goal_m)) continue;
      const double true_m = lengths_m[static_cast<std::size_t>(truth.find(goal_m))];
      if (!std::isfinite(true_m) || true_m < kLeastDistance_m) continue;
      ++result.num_pairs;
      const double raw_m = raw.computeLength(start_m, goal_m);
      if (std::isfinite(raw_m)) result.raw.push_back(raw_m / true_m);
      result.num_without_way += std::isfinite(raw_m) ? 0 : 1;
      const auto planned = planner.plan({start_m, {goal_m, {}}, kRadius_m});
      if (planned.isFound()) result.planned.push_back(planned.path.length_m / true_m);
      result.num_without_path += planned.isFound() ? 0 : 1;
    }
  }
}

Result evaluate(const Arguments& arguments, int seed) {
  simulation::ApartmentConfig config;
  config.seed = seed;
  config.num_rooms = 5 + seed % 4;
  const simulation::Apartment apartment = simulation::buildApartment(config);
  const simulation::FloorMap map(apartment, arguments.max_step_m, kBody_m);
  const Walked walked = walkThrough(arguments, apartment);
  Result result;
  result.num_places = walked.graph.places.size();
  result.updates_ms = walked.updates_ms;
  result.heap = walked.heap;
  comparePlaces(walked, map, result);
  compareWays(arguments, walked, TrueWays(apartment, map), result);
  return result;
}

double toKilobytes(double bytes, std::size_t num_places) {
  return 1e-3 * bytes / static_cast<double>(num_places);
}

void printRow(const char* name, const Result& r) {
  std::printf(
      "| %s | %zu | %zu | %zu | %+.2f, %+.2f | %d, %d of %d | %.2f, %.2f | %.2f, %.2f | "
      "%.1f, %.1f | %.2f, %.2f |\n",
      name, r.num_places, r.num_parts, r.num_inside, findQuantile(r.errors_m, 0.5),
      findQuantile(r.errors_m, 0.95), r.num_without_way, r.num_without_path, r.num_pairs,
      findQuantile(r.raw, 0.5), findQuantile(r.raw, 1.0), findQuantile(r.planned, 0.5),
      findQuantile(r.planned, 1.0), findQuantile(r.updates_ms, 0.5),
      findQuantile(r.updates_ms, 0.95), toKilobytes(r.heap.graph(), r.num_places),
      toKilobytes(r.heap.cells, r.num_places));
  std::fflush(stdout);
}

void append(const std::vector<double>& from, std::vector<double>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

void add(const Result& one, Result& all) {
  all.num_places += one.num_places;
  all.num_parts = std::max(all.num_parts, one.num_parts);
  all.num_inside += one.num_inside;
  all.num_pairs += one.num_pairs;
  all.heap.nodes += one.heap.nodes;
  all.heap.links += one.heap.links;
  all.heap.cells += one.heap.cells;
  all.num_without_way += one.num_without_way;
  all.num_without_path += one.num_without_path;
  append(one.errors_m, all.errors_m);
  append(one.raw, all.raw);
  append(one.planned, all.planned);
  append(one.updates_ms, all.updates_ms);
}

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments a;
  options::options_description description(
      "Scores places and paths in generated apartments against the true obstacles.\n"
      "usage: evaluate_places [options]\noptions");
  description.add_options()("help,h", "print this")(
      "apartments", options::value(&a.apartments)->default_value(a.apartments), "how many")(
      "first-seed", options::value(&a.first_seed)->default_value(a.first_seed), "of them")(
      "starts", options::value(&a.num_starts)->default_value(a.num_starts),
      "positions of the camera from which ways to eight others are compared")(
      "rate", options::value(&a.rate_hz)->default_value(a.rate_hz), "frames per second")(
      "width", options::value(&a.width_px)->default_value(a.width_px), "of the images, px")(
      "max-step", options::value(&a.max_step_m)->default_value(a.max_step_m),
      "m; lower things are no true obstacles");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  return a;
}

void run(const Arguments& arguments) {
  std::printf(
      "| seed | places | parts | in obstacles | clearance less the true: median, 95 %% | "
      "no way, no path | over places / true shortest: median, worst | planner: median, "
      "worst | update, ms CPU: median, 95 %% | kB per place: graph, and choice of places |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  Result all;
  for (int i = 0; i < arguments.apartments; ++i) {
    const int seed = arguments.first_seed + i;
    const Result result = evaluate(arguments, seed);
    printRow(std::to_string(seed).c_str(), result);
    add(result, all);
  }
  printRow("all", all);
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("evaluate_places", argc, argv, parseArguments, run);
}
