// SPDX-License-Identifier: BSD-3-Clause
// Clustering a scene graph file as cluster_scene_graph does: reading, clustering, writing. Beside
// it, of the way it was done before (the whole file as a tree of JSON values), reading and writing
// alone; and the search for the nearest place beside looking at all places.
// Files as the Python package writes them: boxes of 1 m, each overlapping about 12 others, in
// patches that serve the same tasks, embeddings of 768 numbers with 17 digits, meshes of 12
// vertices, a place for every third primitive; 25 tasks. $TSG_LARGE_GRAPH names a file to keep the
// last one in, and its tasks beside it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "peak_memory.h"
#include "support.h"
#include "task_scene_graph/bottleneck/clustering.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/core/point_index.h"
#include "task_scene_graph/scene_graph/scene_graph_file.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace {

using namespace tsg;
using nlohmann::json;
using scene_graph::SceneGraphFile;

constexpr int kDimension = 768;
constexpr int kNumTasks = 25;
constexpr double kPatch_m = 3.0;

std::uint64_t makeId(char letter, int index) {
  return (static_cast<std::uint64_t>(letter) << 56) | static_cast<std::uint64_t>(index);
}

class LargeGraph {
 public:
  explicit LargeGraph(int num_primitives)
      : count_(num_primitives), side_m_(std::cbrt(num_primitives * 8.0 / 12.0)) {
    for (int t = 0; t < kNumTasks; ++t) tasks_.names.push_back("task " + std::to_string(t));
    tasks_.embeddings.resize(kNumTasks, kDimension);
    for (int t = 0; t < kNumTasks; ++t) tasks_.embeddings.row(t) = makeNoise().transpose();
  }
  const scene_graph::TaskList& tasks() const { return tasks_; }

  void write(const std::string& path) {
    std::ofstream out(path);
    json head = {
        {"SPARK_DSG_header",
         {{"project_name", "main"}, {"version", {{"major", 1}, {"minor", 1}, {"patch", 3}}}}},
        {"directed", false},
        {"multigraph", false}};
    for (const auto& [name, layer] : {std::pair("SEGMENTS", 1), {"OBJECTS", 2}, {"PLACES", 3}}) {
      head["layer_names"][name] = {{"layer", layer}, {"partition", 0}};
      head["layer_keys"].push_back(head["layer_names"][name]);
    }
    std::string text = head.dump();
    text.back() = ',';
    out << text << "\"edges\":[],\"nodes\":[";
    for (int i = 0; i < count_; ++i) out << (i == 0 ? "" : ",") << makeSegment(i);
    for (int i = 0; i < count_ / 3; ++i) out << ',' << makePlace(i);
    out << "]}\n";
  }

  Eigen::Vector3d drawPoint() {
    std::uniform_real_distribution<double> draw(0.0, side_m_);
    return {draw(random_), draw(random_), draw(random_)};
  }

 private:
  Embedding makeNoise() {
    Embedding noise(kDimension);
    for (Eigen::Index i = 0; i < noise.size(); ++i) {
      noise[i] = static_cast<float>(random_() % 65536) - 32767.5F;
    }
    return noise / noise.norm();
  }

  /// Half of the patches serve no task.
  Embedding makeEmbedding(const Eigen::Vector3d& corner_m) {
    Embedding x = makeNoise();
    const auto cell = (corner_m / kPatch_m).array().floor().cast<std::int64_t>();
    const auto hash =
        static_cast<std::uint64_t>(cell[0] * 73856093 ^ cell[1] * 19349663 ^ cell[2] * 83492791);
    std::mt19937 patch(static_cast<std::uint32_t>(hash ^ (hash >> 29)));
    if (patch() % 2 == 0) return x;
    std::uniform_real_distribution<float> share(0.15F, 0.45F);
    x += share(random_) * tasks_.embeddings.row(patch() % kNumTasks).transpose();
    x += share(random_) * tasks_.embeddings.row(random_() % kNumTasks).transpose();
    return x;
  }

  std::string makeSegment(int index) {
    const Eigen::Vector3d corner_m = drawPoint();
    const Eigen::Vector3d p = corner_m + Eigen::Vector3d::Constant(0.5);
    const Embedding x = makeEmbedding(corner_m);
    const json identity = {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
    json points = json::array();
    json colors = json::array();
    for (int i = 0; i < 12; ++i) {
      points.push_back({0.04 * i - 0.25, 0.1 * (i % 3), 0.0625 * (i % 4)});
      colors.push_back({{"r", 10 * i}, {"g", 20}, {"b", 30}, {"a", 255}});
    }
    const json attributes = {{"type", "KhronosObjectAttributes"},
                             {"position", {p.x(), p.y(), p.z()}},
                             {"last_update_time_ns", 1600000000000000000 + index},
                             {"is_active", false},
                             {"name", ""},
                             {"color", {{"r", 255}, {"g", 0}, {"b", 0}, {"a", 255}}},
                             {"bounding_box",
                              {{"type", "AABB"},
                               {"dimensions", {1.0, 1.0, 1.0}},
                               {"world_P_center", {p.x(), p.y(), p.z()}},
                               {"world_R_center", identity}}},
                             {"semantic_label", 4294967295U},
                             {"semantic_feature",
                              {{"rows", kDimension},
                               {"cols", 1},
                               {"data", std::vector<double>(x.data(), x.data() + x.size())}}},
                             {"mesh_connections", json::array()},
                             {"first_observed_ns", {1600000000000000000 + index}},
                             {"last_observed_ns", {1600000001000000000 + index}},
                             {"mesh",
                              {{"has_colors", true},
                               {"has_timestamps", false},
                               {"has_labels", false},
                               {"has_first_seen_stamps", false},
                               {"points", points},
                               {"colors", colors},
                               {"faces", {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}}}}},
                             {"metadata", json::object()}};
    return json{
        {"id", makeId('s', index)}, {"layer", 1}, {"partition", 0}, {"attributes", attributes}}
        .dump();
  }

  std::string makePlace(int index) {
    const Eigen::Vector3d p = drawPoint();
    return json{
        {"id", makeId('p', index)},
        {"layer", 3},
        {"partition", 0},
        {"attributes", {{"type", "PlaceNodeAttributes"}, {"position", {p.x(), p.y(), p.z()}}}}}
        .dump();
  }

  int count_;
  double side_m_;
  std::mt19937 random_{7};
  scene_graph::TaskList tasks_;
};

/// A file of so many primitives, kept until another number is asked for.
class GraphFile {
 public:
  const std::string& path(int num_primitives) {
    if (count_ == num_primitives) return path_;
    const char* kept = std::getenv("TSG_LARGE_GRAPH");
    path_ = kept != nullptr ? kept : (folder_.path() / "graph.json").string();
    LargeGraph graph(num_primitives);
    graph.write(path_);
    tasks_ = graph.tasks();
    if (kept != nullptr) scene_graph::writeTasks(path_ + ".tasks.yaml", tasks_);
    count_ = num_primitives;
    return path_;
  }
  const scene_graph::TaskList& tasks() const { return tasks_; }
  std::string output() const { return (folder_.path() / "out.json").string(); }

 private:
  test::TemporaryFolder folder_;
  int count_ = 0;
  std::string path_;
  scene_graph::TaskList tasks_;
};

GraphFile& theFile() {
  static GraphFile file;
  return file;
}

class Stopwatch {
 public:
  /// Seconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

std::vector<bottleneck::Cluster> cluster(const SceneGraphFile& file) {
  bottleneck::IncrementalClustering clustering({}, bottleneck::Adjacency::kBoxOverlap);
  clustering.setTasks(theFile().tasks().embeddings);
  for (const auto& primitive : file.primitives()) {
    clustering.insert(primitive.id, primitive.embedding, primitive.box);
  }
  return clustering.clusters();
}

void clusterFile(benchmark::State& state) {
  const std::string path = theFile().path(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const test::PeakMemory memory;
    Stopwatch watch;
    SceneGraphFile file(path, kDimension);
    state.counters["read_s"] = watch.lap();
    const auto clusters = cluster(file);
    state.counters["cluster_s"] = watch.lap();
    file.replaceObjects(clusters, theFile().tasks().names);
    state.counters["objects_s"] = watch.lap();
    writeFileAtomically(theFile().output(), [&](std::ostream& out) { file.write(out); });
    state.counters["write_s"] = watch.lap();
    state.counters["objects"] = static_cast<double>(clusters.size());
    state.counters["peak_MB"] = memory.peak_MB();
  }
  state.counters["file_MB"] = static_cast<double>(std::filesystem::file_size(path)) / 1e6;
}
BENCHMARK(clusterFile)
    ->Arg(2000)
    ->Arg(20000)
    ->Arg(100000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void readAndWriteAsTree(benchmark::State& state) {
  const std::string path = theFile().path(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const test::PeakMemory memory;
    Stopwatch watch;
    std::ifstream in(path);
    const json graph = json::parse(in);
    state.counters["read_s"] = watch.lap();
    writeFileAtomically(theFile().output(), [&](std::ostream& out) { out << graph; });
    state.counters["write_s"] = watch.lap();
    state.counters["peak_MB"] = memory.peak_MB();
  }
}
BENCHMARK(readAndWriteAsTree)->Arg(2000)->Arg(20000)->Iterations(1)->Unit(benchmark::kMillisecond);

std::vector<Eigen::Vector3d> drawPoints(int count) {
  LargeGraph graph(count);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(graph.drawPoint());
  return points;
}

void nearestPlaceByIndex(benchmark::State& state) {
  const auto places = drawPoints(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const PointIndex index(places);
    for (const auto& query : places) benchmark::DoNotOptimize(index.findNearest(query * 0.999));
  }
}
BENCHMARK(nearestPlaceByIndex)->Arg(7000)->Iterations(1)->Unit(benchmark::kMillisecond);

void nearestPlaceByLookingAtAll(benchmark::State& state) {
  const auto places = drawPoints(static_cast<int>(state.range(0)));
  const auto findNearest = [&](const Eigen::Vector3d& query) {
    return std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
      return (a - query).squaredNorm() < (b - query).squaredNorm();
    });
  };
  for (auto _ : state) {
    for (const auto& query : places) benchmark::DoNotOptimize(findNearest(query * 0.999));
  }
}
BENCHMARK(nearestPlaceByLookingAtAll)->Arg(7000)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
