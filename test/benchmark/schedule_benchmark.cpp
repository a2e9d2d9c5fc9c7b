// SPDX-License-Identifier: BSD-3-Clause
// The segmenter on a walk through a generated apartment, with and without schedule/mode reuse, both
// on the same frames in turn: CPU time, wall time, crops, and what the saving costs (recall of
// true things, and how many of them and of the walk's objects are named right by the text encoder).
#include <boost/program_options.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>

#include "segment_score.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/scene_graph/tasks.h"
#include "task_scene_graph/segmentation/segmenter.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::segmentation {
namespace {

constexpr int kMinArea_px = 400;
constexpr double kMinIou = 0.5;

struct Options {
  std::string models;
  std::string config;
  std::string texts;
  int seed = 1;
  double seconds = 20.0;
  double rate_hz = 10.0;
  int threads = 1;
};

/// Time that passed, on the clock and on the processor (of all threads of this process).
struct Duration {
  double wall_ms = 0.0;
  double cpu_ms = 0.0;
};

template <typename Action>
Duration measure(Action&& action) {
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  action();
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - wall;
  return {elapsed.count(), 1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC};
}

/// Names and one row each; a thing is named right if its own phrase's row is the nearest.
struct Texts {
  std::vector<std::string> names;
  EmbeddingMatrix rows;

  int findNearest(const Embedding& embedding) const {
    Eigen::Index best = 0;
    (rows * embedding).maxCoeff(&best);
    return static_cast<int>(best);
  }
};

Texts makeTexts(const ModelSet& models, const simulation::Apartment& apartment,
                const std::string& file) {
  if (!file.empty()) {
    scene_graph::TaskList list = scene_graph::loadTasks(file);
    return {list.names, list.embeddings};
  }
  Texts texts;
  if (models.text_encoder.empty()) return texts;
  for (const auto& instance : apartment.instances) texts.names.push_back(instance.phrase);
  std::sort(texts.names.begin(), texts.names.end());
  texts.names.erase(std::unique(texts.names.begin(), texts.names.end()), texts.names.end());
  texts.rows = language::TextEncoder(models, EngineConfig{}).encode(texts.names);
  return texts;
}

/// One way to segment, and how it did so far.
class Contestant {
 public:
  Contestant(std::string name, const ModelSet& models, const SegmenterConfig& config)
      : name_(std::move(name)), segmenter_(models, config) {}

  /// @return what was found, for comparisons.
  const Segmentation& step(const ColorImage& color) {
    const Duration duration = measure([&] { last_ = segmenter_.segment(color); });
    total_.wall_ms += duration.wall_ms;
    total_.cpu_ms += duration.cpu_ms;
    return last_;
  }

  void score(const simulation::Apartment& apartment, const cv::Mat& truth, const Texts& texts) {
    for (const auto& match : test::matchThings(truth, last_.labels, kMinArea_px, kMinIou)) {
      ++things_;
      if (!match.segment) continue;
      ++found_;
      const Embedding embedding =
          last_.embeddings.row(static_cast<Eigen::Index>(*match.segment)).transpose();
      named_ += isNamed(apartment, texts, match.thing, embedding);
      Embedding& sum = objects_[match.thing];
      sum = sum.size() == 0 ? embedding : Embedding(sum + embedding);
    }
  }

  void print(const simulation::Apartment& apartment, const Texts& texts) const {
    const auto& counters = segmenter_.counters();
    const double frames = static_cast<double>(counters.images);
    int named_objects = 0;
    for (const auto& [thing, sum] : objects_) {
      named_objects += isNamed(apartment, texts, thing, sum);
    }
    std::printf(
        "%-8s %8.1f %8.1f %8.1f   %.4f (%d of %d)   %.4f   %.4f (of %zu)   %.2f carried, %llu "
        "dropped\n",
        name_.c_str(), total_.cpu_ms / frames, total_.wall_ms / frames,
        static_cast<double>(counters.crops_embedded) / frames, ratio(found_, things_), found_,
        things_, ratio(named_, found_), ratio(named_objects, static_cast<int>(objects_.size())),
        objects_.size(), static_cast<double>(counters.images_carried) / frames,
        static_cast<unsigned long long>(counters.segments_dropped));
  }

  const Duration& total() const { return total_; }

 private:
  static double ratio(int part, int whole) { return whole == 0 ? 0.0 : double(part) / whole; }

  static bool isNamed(const simulation::Apartment& apartment, const Texts& texts, int thing,
                      const Embedding& embedding) {
    if (texts.names.empty()) return false;
    const auto& name = texts.names[static_cast<std::size_t>(texts.findNearest(embedding))];
    return name == apartment.instances[static_cast<std::size_t>(thing - 1)].phrase;
  }

  std::string name_;
  Segmenter segmenter_;
  Segmentation last_;
  Duration total_;
  int things_ = 0;
  int found_ = 0;
  int named_ = 0;
  std::map<int, Embedding> objects_;  ///< sum over the walk, by thing
};

/// How near the embeddings of the same segments are, and whether they mean the same text.
class Agreement {
 public:
  void add(const Segmentation& a, const Segmentation& b, const Texts& texts) {
    if (cv::norm(a.labels, b.labels, cv::NORM_INF) != 0.0) return;
    for (Eigen::Index i = 0; i < a.embeddings.rows(); ++i) {
      const Embedding one = a.embeddings.row(i).transpose();
      const Embedding other = b.embeddings.row(i).transpose();
      ++segments_;
      cosines_ += static_cast<double>(one.dot(other));
      if (!texts.names.empty()) same_ += texts.findNearest(one) == texts.findNearest(other);
    }
  }

  void print() const {
    if (segments_ == 0) return;
    std::printf("same segments: %d, mean cosine %.4f, nearest text the same for %.4f\n", segments_,
                cosines_ / segments_, double(same_) / segments_);
  }

 private:
  int segments_ = 0;
  int same_ = 0;
  double cosines_ = 0.0;
};

SegmenterConfig makeConfig(const Options& options, ScheduleMode mode) {
  SegmenterConfig config;
  if (!options.config.empty()) {
    config = config::load<SegmenterConfig>(config::loadYamlFile(options.config), options.config);
  }
  config.engine.num_threads = options.threads;
  cv::setNumThreads(options.threads);
  config.schedule.mode = mode;
  return config;
}

void walk(const Options& options) {
  const ModelSet models = loadModelSet(options.models);
  const simulation::Apartment apartment = simulation::buildApartment({options.seed, 6});
  const Texts texts = makeTexts(models, apartment, options.texts);
  simulation::WalkConfig walk;
  walk.rate_hz = options.rate_hz;
  walk.duration_s = options.seconds;
  Contestant exact("exact", models, makeConfig(options, ScheduleMode::kExact));
  Contestant reuse("reuse", models, makeConfig(options, ScheduleMode::kReuse));
  const simulation::Renderer renderer(apartment, 2);
  const CameraModel camera = simulation::makeDefaultCamera(640, 480);
  Agreement agreement;
  for (const auto& pose : simulation::planWalk(apartment, walk)) {
    const auto view = renderer.render(camera, pose.T_world_camera);
    const ColorImage color{pose.stamp, view.color, ColorOrder::kRgb, nullptr};
    agreement.add(exact.step(color), reuse.step(color), texts);
    exact.score(apartment, view.labels, texts);
    reuse.score(apartment, view.labels, texts);
  }
  std::printf("mode     CPU ms/f  wall ms/f  crops/f   recall   named   objects named\n");
  exact.print(apartment, texts);
  reuse.print(apartment, texts);
  std::printf("reuse is %.2f times as fast in CPU time, %.2f times on the clock\n",
              exact.total().cpu_ms / reuse.total().cpu_ms,
              exact.total().wall_ms / reuse.total().wall_ms);
  agreement.print();
}

}  // namespace
}  // namespace tsg::segmentation

int main(int argc, char** argv) {
  namespace po = boost::program_options;
  tsg::segmentation::Options options;
  po::options_description description("usage: schedule_benchmark --models M.yaml [options]");
  auto add = description.add_options();
  add("help", "print this");
  add("models", po::value(&options.models)->required(), "model set");
  add("config", po::value(&options.config), "parameters of the segmenter, as segment_images takes");
  add("texts", po::value(&options.texts), "names with embeddings, for sets without a text encoder");
  add("seed", po::value(&options.seed), "of the apartment (1)");
  add("seconds", po::value(&options.seconds), "length of the walk (20), 0: through all rooms");
  add("rate_hz", po::value(&options.rate_hz), "frames per second of the walk (10)");
  add("threads", po::value(&options.threads), "of the networks and of OpenCV (1)");
  try {
    po::variables_map given;
    po::store(po::parse_command_line(argc, argv, description), given);
    if (given.count("help") > 0) {
      std::cout << description;
      return 0;
    }
    po::notify(given);
    tsg::segmentation::walk(options);
  } catch (const std::exception& e) {
    std::cerr << "schedule_benchmark: " << e.what() << "\n";
    return 1;
  }
  return 0;
}
