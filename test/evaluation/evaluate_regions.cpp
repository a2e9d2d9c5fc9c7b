// SPDX-License-Identifier: BSD-3-Clause
// Regions against the true rooms, for generated apartments and for rendered houses: what each way
// to see, to cluster and to name places is worth (docs/places.md has the table).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "numpy_file.h"
#include "sequence.h"
#include "task_scene_graph/evaluation/region_scores.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"
#include "task_scene_graph/places/place_extractor.h"
#include "task_scene_graph/scene_graph/region_layer.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/ground_truth.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/segment_simulator.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"
#include "tools/command_line.h"

namespace options = boost::program_options;
namespace fs = std::filesystem;
using namespace tsg;
using places::ViewWeighting;

namespace {

struct Arguments {
  std::vector<std::string> houses;
  int apartments = 10;
  int first_seed = 1;
  double rate_hz = 4.0;
  int width_px = 320;
  places::PlacesConfig places;
};

/// Image embeddings of all frames, and place tasks of the same space.
struct Features {
  std::string name;
  std::vector<Embedding> frames;
  scene_graph::TaskList tasks;
};

/// A house as the robot saw it.
struct House {
  std::string name;
  std::vector<RgbdFrame> views;  ///< without colour
  std::vector<Features> features;
  std::vector<evaluation::TrueRoom> rooms;
  mapping::TsdfVolume volume{0.1};
  std::vector<mapping::GridIndex> blocks;  ///< of the volume, each once
  evaluation::SamplePoints samples_m;      ///< see findFloorSamples()
  std::vector<int> room_of_samples;
};

OrientedBox makeRoomBox(double x0, double y0, double x1, double y1) {
  return toOrientedBox(makeAabb(Eigen::Vector3d(x0, y0, -1.0), Eigen::Vector3d(x1, y1, 10.0)));
}

/// Observed floor: the columns of the carved volume that are free from 0.2 to 1.1 m.
evaluation::SamplePoints findFloorSamples(const mapping::TsdfVolume& volume) {
  const auto isFree = [&](const mapping::GridIndex& voxel) {
    const mapping::TsdfVoxel* found = volume.findVoxel(voxel);
    return found != nullptr && found->weight >= 1e-6F && found->distance_m >= 0.0F;
  };
  evaluation::SamplePoints samples_m;
  for (const mapping::GridIndex& block : volume.sortedBlockIndices()) {
    if (block.z() != 0) continue;
    for (int i = 0; i < 64; ++i) {
      const mapping::GridIndex voxel(8 * block.x() + i % 8, 8 * block.y() + i / 8, 4);
      bool is_free = true;
      for (const int z : {2, 3, 4, 6, 8, 10}) {
        is_free = is_free && isFree({voxel.x(), voxel.y(), z});
      }
      if (is_free) samples_m.push_back(volume.computeVoxelCenter(voxel));
    }
  }
  return samples_m;
}

mapping::IntegratorConfig makeCarvingConfig() {
  mapping::IntegratorConfig config;
  config.voxel_size_m = 0.1;
  config.truncation_m = 0.3;
  config.carve_free_space = true;
  config.with_color = false;
  return config;
}

/// Rooms of which less than this was seen do not count.
constexpr std::size_t kMinRoomSamples = 100;  // 1 m^2

void finish(House& house) {
  mapping::TsdfIntegrator integrator(makeCarvingConfig());
  std::set<std::array<int, 3>> blocks;
  for (const RgbdFrame& view : house.views) {
    for (const auto& block : integrator.integrate(view, house.volume).changed_blocks) {
      if (blocks.insert({block.z(), block.y(), block.x()}).second) house.blocks.push_back(block);
    }
  }
  house.samples_m = findFloorSamples(house.volume);
  const auto all = evaluation::findRoomOfSamples(house.samples_m, house.rooms);
  std::vector<evaluation::TrueRoom> seen;
  for (std::size_t i = 0; i < house.rooms.size(); ++i) {
    const auto count = std::count(all.begin(), all.end(), static_cast<int>(i));
    if (static_cast<std::size_t>(count) >= kMinRoomSamples) seen.push_back(house.rooms[i]);
  }
  house.rooms = seen;
  house.room_of_samples = evaluation::findRoomOfSamples(house.samples_m, house.rooms);
}

/// Stand-ins for a real network's image embeddings: each room has a direction of its own; an image
/// is the rooms' directions by their share of its pixels, a common part (text and image vectors lie
/// in cones of their own: cosines of 0.24 for other rooms, 0.284 for its own) and noise that
/// changes slowly along the walk (`noise`: standard deviation of a cosine).
Features makeFeatures(const std::vector<std::vector<double>>& shares,
                      const std::vector<std::string>& names, double noise, unsigned seed,
                      double rate_hz) {
  constexpr double kOther = 0.24;
  constexpr double kOwn = 0.284;
  constexpr double kCommon = 0.956;  // squared cosine of a task and the axis of all tasks
  const double own = (kOwn - kOther) / std::sqrt(1.0 - kCommon);
  const auto num_rooms = static_cast<Eigen::Index>(names.size());
  Features features;
  char name[32];
  std::snprintf(name, sizeof(name), "made, noise %.3f", noise);
  features.name = name;
  features.tasks.names = names;
  features.tasks.embeddings.setZero(num_rooms, num_rooms + 2);
  features.tasks.embeddings.col(0).setConstant(static_cast<float>(std::sqrt(kCommon)));
  for (Eigen::Index i = 0; i < num_rooms; ++i) {
    features.tasks.embeddings(i, i + 2) = static_cast<float>(std::sqrt(1.0 - kCommon));
  }
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const double memory = std::pow(0.86, 10.0 / rate_hz);  // of the noise, from frame to frame
  Eigen::VectorXd drift = Eigen::VectorXd::Zero(num_rooms);
  for (const auto& share : shares) {
    Embedding frame = Embedding::Zero(num_rooms + 2);
    frame[0] = static_cast<float>(kOther / std::sqrt(kCommon));
    frame[1] = static_cast<float>(std::sqrt(1.0 - kOther * kOther - own * own));
    for (Eigen::Index i = 0; i < num_rooms; ++i) {
      const bool is_first = features.frames.empty();
      drift[i] = (is_first ? 0.0 : memory * drift[i]) +
                 (is_first ? 1.0 : std::sqrt(1.0 - memory * memory)) * normal(random);
      frame[i + 2] = static_cast<float>(own * share[static_cast<std::size_t>(i)] +
                                        noise / std::sqrt(1.0 - kCommon) * drift[i]);
    }
    features.frames.push_back(frame);
  }
  return features;
}

using Shares = std::vector<std::vector<double>>;

RgbdFrame makeView(const CameraModel& camera, const simulation::WalkPose& pose, cv::Mat depth) {
  RgbdFrame view;
  view.stamp = Stamp{pose.stamp.ns + 1000000000};
  view.camera = camera;
  view.T_world_camera = pose.T_world_camera;
  view.color.image = cv::Mat::zeros(depth.size(), CV_8UC3);
  view.depth.image = std::move(depth);
  return view;
}

/// Walks through the apartment; image embeddings are those of recordings, which have ten frames per
/// second. Returns the share of each room in each view.
Shares renderWalk(const Arguments& arguments, const simulation::Apartment& apartment, House& house,
                  std::vector<Embedding>& embeddings) {
  using namespace simulation;
  WalkConfig walk;
  walk.rate_hz = arguments.rate_hz;
  const CameraModel camera = makeDefaultCamera(arguments.width_px, arguments.width_px * 3 / 4);
  const Renderer renderer(apartment, 2);
  const SegmentSimulator segments(apartment, SegmentConfig{});
  Shares shares;
  for (const WalkPose& pose : planWalk(apartment, walk)) {
    const RenderedView rendered = renderer.render(camera, pose.T_world_camera);
    const auto frame = static_cast<std::int64_t>(house.views.size());
    const auto seed = static_cast<std::uint64_t>(apartment.config.seed);
    house.views.push_back(makeView(
        camera, pose,
        simulateDepthSensor(rendered.depth_m, camera, DepthNoiseConfig{}, seed, frame, 2)));
    const auto recorded =
        static_cast<std::int64_t>(static_cast<double>(frame) * 10.0 / arguments.rate_hz);
    embeddings.push_back(
        segments.segment(rendered, house.views.back().stamp, recorded).image_embedding);
    shares.emplace_back();
    for (std::size_t i = 1; i < rendered.room_pixels.size(); ++i) {
      shares.back().push_back(static_cast<double>(rendered.room_pixels[i]) /
                              static_cast<double>(rendered.labels.total()));
    }
  }
  return shares;
}

House makeApartment(const Arguments& arguments, int seed) {
  simulation::ApartmentConfig config;
  config.seed = seed;
  config.num_rooms = 5 + seed % 4;
  const simulation::Apartment apartment = simulation::buildApartment(config);
  House house;
  house.name = "apartment " + std::to_string(seed);
  Features recorded{"recorded", {}, {}};
  const Shares shares = renderWalk(arguments, apartment, house, recorded.frames);
  const simulation::EmbeddingSpace space;
  recorded.tasks.embeddings.resize(static_cast<Eigen::Index>(apartment.rooms.size()),
                                   simulation::EmbeddingSpace::kSize);
  for (const simulation::Room& room : apartment.rooms) {
    recorded.tasks.embeddings.row(static_cast<Eigen::Index>(recorded.tasks.names.size())) =
        space.encodeText(room.phrase).transpose();
    recorded.tasks.names.push_back(room.phrase);
    const simulation::Rect& r = room.interior_m;
    house.rooms.push_back(
        {room.phrase, {makeRoomBox(r.min().x(), r.min().y(), r.max().x(), r.max().y())}});
  }
  for (const double noise : {0.003, 0.015, 0.03}) {
    house.features.push_back(makeFeatures(shares, recorded.tasks.names, noise,
                                          static_cast<unsigned>(seed), arguments.rate_hz));
  }
  house.features.insert(house.features.begin(), std::move(recorded));
  finish(house);
  return house;
}

/// Rows of a two-dimensional array of floats.
std::vector<Embedding> toRows(const test::NumpyArray& array) {
  if (array.type != "<f4") throw std::runtime_error("embeddings of type " + array.type);
  const std::size_t size = array.shape.at(1);
  std::vector<Embedding> rows(array.shape.at(0), Embedding(static_cast<Eigen::Index>(size)));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::memcpy(rows[i].data(), array.bytes.data() + i * size * sizeof(float),
                size * sizeof(float));
  }
  return rows;
}

House readHouse(const fs::path& folder) {
  House house;
  house.name = folder.filename().string();
  const auto arrays = test::readNpz(folder / "image_embeddings.npz");
  Features given{"recorded", toRows(arrays.at("frame_embeddings")), {}};
  const auto rows = toRows(arrays.at("room_embeddings"));
  const auto json = nlohmann::json::parse(std::ifstream(folder / "rooms.json"));
  given.tasks.embeddings.resize(static_cast<Eigen::Index>(rows.size()), rows.front().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    given.tasks.embeddings.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
    given.tasks.names.push_back(json.at(i).at("name"));
  }
  for (const auto& room : json) {
    house.rooms.push_back({room.at("name"), {}});
    for (const auto& r : room.at("rects")) {
      house.rooms.back().boxes.push_back(makeRoomBox(r.at(0), r.at(1), r.at(2), r.at(3)));
    }
  }
  for (std::size_t i = 0; i < given.frames.size(); ++i) {
    RgbdFrame view = test::loadSequenceFrame(folder, static_cast<int>(i));
    view.color.image = cv::Mat::zeros(view.depth.image.size(), CV_8UC3);
    house.views.push_back(view);
  }
  house.features.push_back(std::move(given));
  finish(house);
  return house;
}

struct Variant {
  std::string name;
  ViewWeighting weighting = ViewWeighting::kInverseSquare;
  scene_graph::SceneGraphConfig config;
};

std::vector<Variant> listVariants() {
  scene_graph::SceneGraphConfig paper;
  paper.place_alpha = 0.0;
  paper.place_top_k = 2;
  paper.place_normaliser = bottleneck::Normaliser::kPaper;
  paper.place_smoothing_per_m = 0.0;
  paper.min_region_places = 1;
  scene_graph::SceneGraphConfig one_task = paper;
  one_task.place_top_k = 1;
  one_task.place_normaliser = bottleneck::Normaliser::kSizeInvariant;
  scene_graph::SceneGraphConfig smooth = one_task;
  smooth.place_smoothing_per_m = scene_graph::SceneGraphConfig{}.place_smoothing_per_m;
  scene_graph::SceneGraphConfig geometric;
  geometric.region_method = scene_graph::RegionMethod::kGeometric;
  scene_graph::SceneGraphConfig small_rooms = geometric;
  small_rooms.rooms.min_component_size = 2;
  small_rooms.rooms.min_room_size = 2;
  return {{"paper (average)", ViewWeighting::kAverage, paper},
          {"paper (closest)", ViewWeighting::kClosest, paper},
          {"paper (inverse square)", ViewWeighting::kInverseSquare, paper},
          {"best task alone (average)", ViewWeighting::kAverage, one_task},
          {"best task alone (closest)", ViewWeighting::kClosest, one_task},
          {"best task alone (inverse square)", ViewWeighting::kInverseSquare, one_task},
          {"... smoothed", ViewWeighting::kInverseSquare, smooth},
          {"... none of 1 or 2 places: default", ViewWeighting::kInverseSquare, {}},
          {"default (average)", ViewWeighting::kAverage, {}},
          {"default (closest)", ViewWeighting::kClosest, {}},
          {"geometric", ViewWeighting::kInverseSquare, geometric},
          {"geometric, rooms from 2 places", ViewWeighting::kInverseSquare, small_rooms}};
}

PlaceGraph computePlaces(const House& house, const Features& features, ViewWeighting weighting,
                         places::PlacesConfig config) {
  config.view_weighting = weighting;
  places::PlaceExtractor extractor(config);
  extractor.update(house.volume, house.blocks, house.views.back().stamp);
  for (std::size_t i = 0; i < house.views.size(); ++i) {
    extractor.addView(house.views[i], features.frames[i]);
  }
  return extractor.graph();
}

struct Score {
  evaluation::RegionScores scores;
  double regions_per_room = 0.0;
};

Score computeScore(const House& house, const PlaceGraph& graph,
                   const std::vector<std::vector<PlaceId>>& regions) {
  const auto samples = evaluation::collectRegionSamples(house.samples_m, graph, regions,
                                                        evaluation::PlaceShape::kColumn);
  const auto overlaps =
      evaluation::computeOverlaps(house.room_of_samples, house.rooms.size(), samples, false);
  return {evaluation::computeRegionScores(overlaps),
          static_cast<double>(regions.size()) / static_cast<double>(house.rooms.size())};
}

std::vector<std::vector<PlaceId>> computeRegions(const PlaceGraph& graph, const Features& features,
                                                 const scene_graph::SceneGraphConfig& config) {
  scene_graph::RegionLayer layer(config);
  layer.setTasks(features.tasks);
  layer.setPlaces(std::make_shared<PlaceGraph>(graph));
  std::vector<std::vector<PlaceId>> regions;
  for (const auto& cluster : layer.computeClusters()) regions.push_back(cluster.places);
  return regions;
}

/// Each place in its true room: what these places allow at best.
std::vector<std::vector<PlaceId>> listTrueRooms(const House& house, const PlaceGraph& graph) {
  evaluation::SamplePoints at_m;
  for (const Place& place : graph.places) at_m.push_back(place.position_m);
  const auto room_of_places = evaluation::findRoomOfSamples(at_m, house.rooms);
  std::map<int, std::vector<PlaceId>> places_of;
  for (std::size_t i = 0; i < at_m.size(); ++i) {
    places_of[room_of_places[i]].push_back(graph.places[i].id);
  }
  places_of.erase(evaluation::kOutside);
  std::vector<std::vector<PlaceId>> regions;
  for (const auto& [room, places] : places_of) regions.push_back(places);
  return regions;
}

/// By features, then by variant: the scores of all houses.
using Table = std::map<std::string, std::vector<std::pair<std::string, std::vector<Score>>>>;

void evaluate(const Arguments& arguments, const House& house, Table& table) {
  for (const Features& features : house.features) {
    auto& rows = table[features.name];
    std::map<ViewWeighting, PlaceGraph> graphs;
    const auto add = [&](std::size_t row, const std::string& name, const Score& score) {
      if (rows.size() <= row) rows.resize(row + 1);
      rows[row].first = name;
      rows[row].second.push_back(score);
    };
    std::size_t row = 0;
    for (const Variant& variant : listVariants()) {
      if (graphs.count(variant.weighting) == 0) {
        graphs[variant.weighting] =
            computePlaces(house, features, variant.weighting, arguments.places);
      }
      const PlaceGraph& graph = graphs[variant.weighting];
      const auto regions = computeRegions(graph, features, variant.config);
      add(row++, variant.name, computeScore(house, graph, regions));
    }
    const PlaceGraph& graph = graphs.begin()->second;
    const Score best = computeScore(house, graph, listTrueRooms(house, graph));
    add(row, "bound: each place in its true room", best);
    const auto& own = rows[7].second.back();
    std::printf("%-14s %-18s %3zu places, %zu rooms: default F1 %.3f, x%.2f; bound %.3f\n",
                house.name.c_str(), features.name.c_str(), graph.places.size(), house.rooms.size(),
                own.scores.f1, own.regions_per_room, best.scores.f1);
    std::fflush(stdout);
  }
}

std::string describe(const std::vector<Score>& scores, double (*pick)(const Score&)) {
  double mean = 0.0;
  for (const Score& score : scores) mean += pick(score) / static_cast<double>(scores.size());
  double squares = 0.0;
  for (const Score& score : scores) squares += std::pow(pick(score) - mean, 2);
  const double deviation =
      scores.size() > 1 ? std::sqrt(squares / static_cast<double>(scores.size() - 1)) : 0.0;
  char text[32];
  std::snprintf(text, sizeof(text), "%.3f ± %.3f", mean, deviation);
  return text;
}

void print(const Table& table) {
  for (const auto& [features, rows] : table) {
    std::cout << "\n"
              << features << ", " << rows.front().second.size() << " houses\n\n"
              << "| regions | regions / rooms | precision | recall | F1 | total precision | "
                 "total recall |\n|---|---|---|---|---|---|---|\n";
    for (const auto& [name, scores] : rows) {
      std::cout << "| " << name << " | "
                << describe(scores, [](const Score& s) { return s.regions_per_room; }) << " | "
                << describe(scores, [](const Score& s) { return s.scores.precision; }) << " | "
                << describe(scores, [](const Score& s) { return s.scores.recall; }) << " | "
                << describe(scores, [](const Score& s) { return s.scores.f1; }) << " | "
                << describe(scores, [](const Score& s) { return s.scores.total_precision; })
                << " | " << describe(scores, [](const Score& s) { return s.scores.total_recall; })
                << " |\n";
    }
  }
}

std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments a;
  options::options_description description(
      "Scores regions against the true rooms (floor cells that were seen; Hydra's room metric).\n"
      "usage: evaluate_regions [options]\noptions");
  description.add_options()("help,h", "print this")(
      "house", options::value(&a.houses)->composing(),
      "a rendered house: frames as in 7-Scenes, rooms.json, image_embeddings.npz; may be repeated")(
      "apartments", options::value(&a.apartments)->default_value(a.apartments), "how many")(
      "first-seed", options::value(&a.first_seed)->default_value(a.first_seed), "of them")(
      "rate", options::value(&a.rate_hz)->default_value(a.rate_hz), "frames per second")(
      "width", options::value(&a.width_px)->default_value(a.width_px), "of the images, px")(
      "cell-size", options::value(&a.places.cell_size_m)->default_value(a.places.cell_size_m),
      "m; of places")(
      "merge-distance",
      options::value(&a.places.merge_distance_m)->default_value(a.places.merge_distance_m),
      "m; of places")(
      "fill-distance",
      options::value(&a.places.fill_distance_m)->default_value(a.places.fill_distance_m),
      "m; of places");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  return a;
}

void run(const Arguments& arguments) {
  Table table;
  for (const std::string& folder : arguments.houses) {
    evaluate(arguments, readHouse(folder), table);
  }
  for (int i = 0; i < arguments.apartments; ++i) {
    evaluate(arguments, makeApartment(arguments, arguments.first_seed + i), table);
  }
  print(table);
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("evaluate_regions", argc, argv, parseArguments, run);
}
