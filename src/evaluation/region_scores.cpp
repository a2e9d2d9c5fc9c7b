// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/region_scores.h"

#include <algorithm>

#include "task_scene_graph/core/find_by_id.h"

namespace tsg::evaluation {
namespace {

const Place* findPlace(const PlaceGraph& graph, PlaceId id) {
  const auto found = findById(graph.places, id, [](const Place& place) { return place.id; });
  return found != graph.places.end() ? &*found : nullptr;
}

bool isFreeSpaceOf(const Place& place, const Eigen::Vector3d& sample_m, PlaceShape shape) {
  const Eigen::Vector3d offset_m = sample_m - place.position_m;
  const double distance_m =
      shape == PlaceShape::kSphere ? offset_m.norm() : offset_m.head<2>().norm();
  return distance_m <= place.clearance_m;
}

double divide(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

double computeMean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return divide(sum, static_cast<double>(values.size()));
}

}  // namespace

std::vector<int> findRoomOfSamples(const SamplePoints& samples_m,
                                   const std::vector<TrueRoom>& rooms) {
  std::vector<int> room_of_samples;
  room_of_samples.reserve(samples_m.size());
  for (const Eigen::Vector3d& sample_m : samples_m) {
    const auto holds = [&](const TrueRoom& room) {
      return std::any_of(room.boxes.begin(), room.boxes.end(),
                         [&](const OrientedBox& box) { return box.contains(sample_m, 0.0); });
    };
    const auto found = std::find_if(rooms.begin(), rooms.end(), holds);
    room_of_samples.push_back(found == rooms.end() ? kOutside
                                                   : static_cast<int>(found - rooms.begin()));
  }
  return room_of_samples;
}

std::vector<SampleSet> collectRegionSamples(const SamplePoints& samples_m, const PlaceGraph& graph,
                                            const std::vector<std::vector<PlaceId>>& regions,
                                            PlaceShape shape) {
  std::vector<SampleSet> collected;
  for (const auto& region : regions) {
    std::vector<const Place*> places;
    for (const PlaceId id : region) {
      if (const Place* place = findPlace(graph, id)) places.push_back(place);
    }
    collected.emplace_back();
    for (std::size_t i = 0; i < samples_m.size(); ++i) {
      const bool is_inside = std::any_of(places.begin(), places.end(), [&](const Place* place) {
        return isFreeSpaceOf(*place, samples_m[i], shape);
      });
      if (is_inside) collected.back().push_back(i);
    }
  }
  return collected;
}

RegionOverlaps computeOverlaps(const std::vector<int>& room_of_samples, std::size_t num_rooms,
                               const std::vector<SampleSet>& regions, bool only_labeled) {
  RegionOverlaps overlaps;
  const auto num_regions = static_cast<Eigen::Index>(regions.size());
  overlaps.room_sizes.setZero(static_cast<Eigen::Index>(num_rooms));
  overlaps.region_sizes.setZero(num_regions);
  overlaps.overlaps.setZero(static_cast<Eigen::Index>(num_rooms), num_regions);
  for (const int room : room_of_samples) {
    if (room != kOutside) overlaps.room_sizes[room] += 1.0;
  }
  for (Eigen::Index j = 0; j < num_regions; ++j) {
    for (const std::size_t sample : regions[static_cast<std::size_t>(j)]) {
      const int room = room_of_samples.at(sample);
      if (room != kOutside) overlaps.overlaps(room, j) += 1.0;
      if (room != kOutside || !only_labeled) overlaps.region_sizes[j] += 1.0;
    }
  }
  return overlaps;
}

RegionScores computeRegionScores(const RegionOverlaps& overlaps) {
  RegionScores scores;
  const Eigen::MatrixXd& shared = overlaps.overlaps;
  const bool is_empty = shared.size() == 0;
  double shared_by_rooms = 0.0;
  double shared_by_regions = 0.0;
  for (Eigen::Index i = 0; i < shared.rows(); ++i) {
    const double most = is_empty ? 0.0 : shared.row(i).maxCoeff();
    scores.room_recalls.push_back(divide(most, overlaps.room_sizes[i]));
    shared_by_rooms += most;
  }
  for (Eigen::Index j = 0; j < shared.cols(); ++j) {
    const double most = is_empty ? 0.0 : shared.col(j).maxCoeff();
    scores.region_precisions.push_back(divide(most, overlaps.region_sizes[j]));
    shared_by_regions += most;
  }
  scores.recall = computeMean(scores.room_recalls);
  scores.precision = computeMean(scores.region_precisions);
  scores.f1 = divide(2.0 * scores.precision * scores.recall, scores.precision + scores.recall);
  scores.total_recall = divide(shared_by_rooms, overlaps.room_sizes.sum());
  scores.total_precision = divide(shared_by_regions, overlaps.region_sizes.sum());
  return scores;
}

}  // namespace tsg::evaluation
