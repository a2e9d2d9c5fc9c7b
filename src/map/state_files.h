// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "task_scene_graph/map/map.h"

/// What a map goes on from, bit by bit, in files for this package alone (below `state/`).
namespace tsg::map {

/// All throw std::runtime_error naming the path.
void writeTasksState(const std::filesystem::path& folder, const Map& map);
void writePrimitives(const std::filesystem::path& folder, const Map& map);
void writePlaces(const std::filesystem::path& folder, const Map& map);
void writeClusters(const std::filesystem::path& folder, const Map& map);
void writeMeshBlocks(const std::filesystem::path& folder, const Map& map);
void writeTrajectoryState(const std::filesystem::path& folder, const Map& map);
void writePlaceMemory(const std::filesystem::path& folder, const Map& map);

/// Each puts into a map what the file holds, and checks it.
/// @throws std::runtime_error naming the file and what is wrong with it.
void readTasksState(const std::filesystem::path& file, Map& map);
void readPrimitives(const std::filesystem::path& file, Map& map);
void readPlaces(const std::filesystem::path& file, Map& map);
void readClusters(const std::filesystem::path& file, Map& map);
void readMeshBlocks(const std::filesystem::path& file, Map& map);
void readTrajectoryState(const std::filesystem::path& file, Map& map);
void readPlaceMemory(const std::filesystem::path& file, Map& map);

constexpr const char* kTasksFile = "state/tasks.bin";
constexpr const char* kPrimitivesFile = "state/primitives.bin";
constexpr const char* kPlacesFile = "state/places.bin";
constexpr const char* kClustersFile = "state/clusters.bin";
constexpr const char* kMeshBlocksFile = "state/mesh_blocks.bin";
constexpr const char* kTrajectoryFile = "state/trajectory.bin";
constexpr const char* kPlaceMemoryFile = "state/free_space.bin";

}  // namespace tsg::map
