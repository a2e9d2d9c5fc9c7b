// SPDX-License-Identifier: BSD-3-Clause
// Tracking on a recorded walk with known instances whose segments are dropped, split and merged at
// random (seeded). The table that is printed is the result; the expectations are what must hold for
// it to mean anything.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "sequence.h"
#include "support.h"
#include "task_scene_graph/tracking/tracker.h"

namespace tsg::tracking {
namespace {

constexpr int kEmbeddingSize = 64;

/// A stand-in for an image encoder: one direction per class of thing, a part common to all
/// pictures (two classes have a cosine of about 0.64), and noise per view.
class SeededEncoder {
 public:
  SeededEncoder(const std::filesystem::path& instances_json, unsigned seed) : random_(seed) {
    const Embedding common = 0.8F * makeDirection();
    std::map<std::string, Embedding> classes;
    for (const auto& entry : nlohmann::json::parse(std::ifstream(instances_json))) {
      const std::string name = entry.at("text_class");
      if (classes.count(name) == 0) classes[name] = common + 0.6F * makeDirection();
      instances_[entry.at("id").get<int>()] = classes.at(name);
    }
  }

  Embedding encode(int instance) { return instances_.at(instance) + 0.25F * makeDirection(); }

 private:
  Embedding makeDirection() {
    std::normal_distribution<float> normal;
    Embedding direction(kEmbeddingSize);
    for (int i = 0; i < kEmbeddingSize; ++i) direction(i) = normal(random_);
    return direction.normalized();
  }

  std::mt19937 random_;
  std::map<int, Embedding> instances_;
};

struct Faults {
  double dropped = 0.0;  ///< probability that a segment is missing
  double split = 0.0;    ///< that it falls in two
  double merged = 0.0;   ///< that it swallows another one of the same frame
};

/// A frame's true instances as segments, with faults; `instances[s]` is the larger part's instance.
struct FaultySegmentation {
  Segmentation segmentation;
  std::vector<int> instances;
};

class FaultMaker {
 public:
  FaultMaker(const Faults& faults, SeededEncoder encoder, unsigned seed)
      : faults_(faults), encoder_(std::move(encoder)), random_(seed) {}

  FaultySegmentation make(Stamp stamp, const cv::Mat& instances) {
    FaultySegmentation result;
    result.segmentation.stamp = stamp;
    result.segmentation.labels = cv::Mat::zeros(instances.size(), CV_16UC1);
    std::vector<int> visible = findVisible(instances);
    std::set<int> swallowed;
    for (std::size_t i = 0; i < visible.size(); ++i) {
      if (swallowed.count(visible[i]) > 0 || happens(faults_.dropped)) continue;
      cv::Mat mask = instances == visible[i];
      if (happens(faults_.merged) && i + 1 < visible.size()) {
        swallowed.insert(visible[i + 1]);
        mask |= instances == visible[i + 1];
      }
      if (happens(faults_.split))
        addSplit(mask, visible[i], result);
      else
        addSegment(mask, visible[i], result);
    }
    return result;
  }

 private:
  static std::vector<int> findVisible(const cv::Mat& instances) {
    std::map<int, int> pixels;
    for (auto it = instances.begin<std::uint16_t>(); it != instances.end<std::uint16_t>(); ++it) {
      ++pixels[*it];
    }
    std::vector<int> visible;
    for (const auto& [instance, count] : pixels) {
      if (instance != 0 && count >= 400) visible.push_back(instance);
    }
    return visible;
  }

  bool happens(double probability) { return std::bernoulli_distribution(probability)(random_); }

  void addSplit(const cv::Mat& mask, int instance, FaultySegmentation& result) {
    cv::Mat left = mask.clone();
    std::uniform_int_distribution<int> cut(mask.cols / 4, 3 * mask.cols / 4);
    left.colRange(cut(random_), mask.cols).setTo(0);
    addSegment(left, instance, result);
    addSegment(mask & ~left, instance, result);
  }

  void addSegment(const cv::Mat& mask, int instance, FaultySegmentation& result) {
    if (cv::countNonZero(mask) == 0) return;
    Segmentation& segmentation = result.segmentation;
    const auto s = segmentation.embeddings.rows();
    segmentation.labels.setTo(static_cast<double>(s + 1), mask);
    segmentation.embeddings.conservativeResize(s + 1, kEmbeddingSize);
    segmentation.embeddings.row(s) = encoder_.encode(instance).transpose();
    segmentation.confidences.push_back(1.0F);
    result.instances.push_back(instance);
  }

  Faults faults_;
  SeededEncoder encoder_;
  std::mt19937 random_;
};

/// Scores a tracker against the true instances while it runs.
class Score {
 public:
  void add(const TrackedFrame& result, const std::vector<int>& instances) {
    std::map<int, TrackId> now;  // the first track of each instance in this frame
    for (std::size_t s = 0; s < instances.size(); ++s) {
      const TrackId track = result.segment_tracks[s];
      if (!track.isValid()) continue;
      ++votes_[track.value][instances[s]];
      ++frames_[instances[s]];
      now.emplace(instances[s], track);
    }
    for (const auto& [instance, track] : now) {
      const auto last = last_track_.find(instance);
      if (last != last_track_.end() && last->second != track) ++switches;
      last_track_[instance] = track;
    }
    for (const Track& track : result.finished) finished_.insert(track.id.value);
  }

  int switches = 0;  ///< the instance's track differs from that of its last sighting
  double tracks_per_instance = 0.0;  ///< finished tracks per instance that has any
  double purity = 0.0;     ///< share of finished observations that show their track's main instance
  int fragmentations = 0;  ///< finished tracks beyond the first of their main instance
  int missed = 0;          ///< instances in >= 5 frames without a finished track of their own
  int num_tracks = 0;
  int num_instances = 0;

  void close() {
    std::map<int, int> tracks_of;
    double main_votes = 0.0;
    double all_votes = 0.0;
    for (const std::uint64_t track : finished_) {
      const auto& votes = votes_.at(track);
      const auto main = std::max_element(votes.begin(), votes.end(),
                                         [](auto& a, auto& b) { return a.second < b.second; });
      ++tracks_of[main->first];
      main_votes += main->second;
      for (const auto& [instance, count] : votes) all_votes += count;
    }
    num_tracks = static_cast<int>(finished_.size());
    purity = main_votes / all_votes;
    fragmentations = num_tracks - static_cast<int>(tracks_of.size());
    tracks_per_instance = num_tracks / static_cast<double>(tracks_of.size());
    for (const auto& [instance, frames] : frames_) {
      num_instances += frames >= 5 ? 1 : 0;
      missed += frames >= 5 && tracks_of.count(instance) == 0 ? 1 : 0;
    }
  }

 private:
  std::map<std::uint64_t, std::map<int, int>> votes_;
  std::map<int, int> frames_;
  std::map<int, TrackId> last_track_;
  std::set<std::uint64_t> finished_;
};

struct TrackingRun {
  const char* name;
  Preset preset;
  Faults faults;
  Score score;
};

void print(const TrackingRun& run) {
  std::printf(
      "%-18s tracks %4d, per instance %5.2f, fragmentations %4d, switches %4d, purity %.4f, missed "
      "%d of %d\n",
      run.name, run.score.num_tracks, run.score.tracks_per_instance, run.score.fragmentations,
      run.score.switches, run.score.purity, run.score.missed, run.score.num_instances);
}

TrackerConfig configOf(const TrackingRun& run) {
  TrackerConfig config;
  config.preset = run.preset;
  return config;
}

TEST(RecordedTracking, FindsTheInstancesOfAHouseDespiteFaultySegments) {
  TSG_REQUIRE_SHARED(folder, "data/house_a");
  const Faults faults{0.1, 0.1, 0.05};
  std::vector<TrackingRun> runs{{"clio", Preset::kClio, {}, {}},
                                {"khronos", Preset::kKhronos, {}, {}},
                                {"clio, faults", Preset::kClio, faults, {}},
                                {"khronos, faults", Preset::kKhronos, faults, {}}};
  std::vector<Tracker> trackers;
  std::vector<FaultMaker> makers;
  for (const TrackingRun& run : runs) {
    trackers.emplace_back(configOf(run));
    makers.emplace_back(run.faults, SeededEncoder(folder / "instances.json", 1), 2);
  }
  for (int i = 0; i < 400; i += 2) {  // 5 Hz, as segmenters run
    RgbdFrame frame = tsg::test::loadSequenceFrame(folder, i);
    frame.stamp = Stamp::fromSeconds(0.1 * i);
    const cv::Mat instances = tsg::test::loadSequenceLabels(folder, i);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const auto segments = makers[r].make(frame.stamp, instances);
      runs[r].score.add(trackers[r].update(frame, segments.segmentation), segments.instances);
    }
  }
  for (std::size_t r = 0; r < runs.size(); ++r) {
    runs[r].score.add(trackers[r].finish(), {});
    runs[r].score.close();
    print(runs[r]);
    EXPECT_EQ(trackers[r].counters().invalid_frames, 0U);
  }
  EXPECT_GE(runs[1].score.num_instances, 40);
  EXPECT_GT(runs[1].score.purity, 0.999);
  EXPECT_LE(runs[1].score.missed, 2);
  EXPECT_GT(runs[3].score.purity, 0.97);
  EXPECT_LE(runs[3].score.missed, 5);
  EXPECT_LE(runs[1].score.switches, runs[0].score.switches);
  EXPECT_LT(runs[3].score.switches, runs[2].score.switches);
}

}  // namespace
}  // namespace tsg::tracking
