// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "task_scene_graph/core/oriented_box.h"
#include "task_scene_graph/core/primitives.h"

/// How well what was found agrees with what is there.
namespace tsg::evaluation {

/// A room of the truth: all that lies in one of its boxes.
struct TrueRoom {
  std::string name;
  std::vector<OrientedBox> boxes;
};

/// Free space as samples of equal volume: centres of voxels, or of cells of a floor.
using SamplePoints = std::vector<Eigen::Vector3d>;
/// Samples by index, ascending, each once.
using SampleSet = std::vector<std::size_t>;

constexpr int kOutside = -1;  ///< of all rooms

/// How far the free space of a place reaches around it.
enum class PlaceShape {
  kSphere,  ///< the clearance in all directions: Hydra's metric, for places in a volume
  kColumn   ///< horizontally: for places whose clearance is horizontal (places::FreeSpaceKind)
};

/// Sizes in samples.
struct RegionOverlaps {
  Eigen::MatrixXd overlaps;  ///< rooms x regions: samples that both have
  Eigen::VectorXd room_sizes;
  Eigen::VectorXd region_sizes;
};

/// Shares in [0, 1].
struct RegionScores {
  double precision = 0.0;        ///< mean over the regions
  double recall = 0.0;           ///< mean over the rooms
  double f1 = 0.0;               ///< harmonic mean of both, 0 if both are 0
  double total_precision = 0.0;  ///< sum over the regions before division
  double total_recall = 0.0;     ///< sum over the rooms before division
  std::vector<double> region_precisions;
  std::vector<double> room_recalls;
};

/// Index of the room that owns each sample, the first that holds it; kOutside if none does.
/// O(samples * boxes).
std::vector<int> findRoomOfSamples(const SamplePoints& samples_m,
                                   const std::vector<TrueRoom>& rooms);

/// The samples of each region: those whose distance to one of its places is at most that place's
/// clearance. Regions may share samples.
/// @param regions  places of each region; ids that are not in the graph are passed over
/// deviation: Hydra steps by whole voxels from minus the radius and floors each offset, so that its
/// spheres are not symmetric; here centres within the radius count. O(samples * places).
std::vector<SampleSet> collectRegionSamples(const SamplePoints& samples_m, const PlaceGraph& graph,
                                            const std::vector<std::vector<PlaceId>>& regions,
                                            PlaceShape shape);

/// @param only_labeled  leaves samples outside of all rooms out of the regions, as Hydra's tool
/// does
RegionOverlaps computeOverlaps(const std::vector<int>& room_of_samples, std::size_t num_rooms,
                               const std::vector<SampleSet>& regions, bool only_labeled);

/// Hydra's room metric: recall_i = max_j |i and j| / |i|, precision_j = max_i |i and j| / |j|, 0
/// for a room or region without samples. The assignment is not one to one. Without regions or rooms
/// all scores are 0. [Clio24, Sec. V-C] takes precision, recall and F1 of each trial and then their
/// mean. O(rooms * regions).
RegionScores computeRegionScores(const RegionOverlaps& overlaps);

}  // namespace tsg::evaluation
