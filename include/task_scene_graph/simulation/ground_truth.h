// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/embedding_space.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {

/// A task in plain words and the instances that it is about.
struct TaskTruth {
  std::string name;
  EmbeddingSpace::Mixture phrases;       ///< what its embedding is made of
  std::vector<std::uint16_t> instances;  ///< ascending; empty if the apartment has none
  std::vector<std::size_t> groups = {};  ///< each one thing: indices into Apartment::groups
};

/// How finely tasks divide a world.
enum class TaskGrain {
  kFine,   ///< a thing of a group by itself: "get the green book"
  kCoarse  ///< a group as a whole: "move the stacks of books"
};

/// Object tasks: the same list for every apartment, so some have no instance in it.
std::vector<TaskTruth> makeObjectTasks(const Apartment& apartment);
/// One of two lists over the same world; both have the same tasks for furniture besides. A group's
/// phrases are those of all its members.
std::vector<TaskTruth> makeGroupTasks(const Apartment& apartment, TaskGrain grain);
/// Place tasks: the phrases of the apartment's rooms, each once; no instances.
std::vector<TaskTruth> makePlaceTasks(const Apartment& apartment);

/// `tasks: [{name, embedding}]`. @throws std::runtime_error if the file cannot be written.
void writeTaskEmbeddings(const std::filesystem::path& path, const std::vector<TaskTruth>& tasks);
/// A list of the tasks' names, for a text encoder. @throws as `writeTaskEmbeddings`.
void writeTaskNames(const std::filesystem::path& path, const std::vector<TaskTruth>& tasks);

/// Writes into a folder, made if absent:
///   instances.json  id, phrase, color, room, box_min_m, box_max_m, center_m, extents_m, rotation
///   rooms.json      id, name, rectangle_m [x0, y0, x1, y1], height_m, instances; doorways
///   tasks.yaml      Clio's format: task -> oriented boxes {center, extents, rotation {w, x, y, z}}
///   poses.txt       one line per pose: seconds, then tx ty tz qx qy qz qw of T_world_camera
/// Lengths in metres, world frame. @throws std::runtime_error if a file cannot be written.
void writeGroundTruth(const std::filesystem::path& folder, const Apartment& apartment,
                      const std::vector<TaskTruth>& tasks, const std::vector<WalkPose>& walk);
/// The boxes alone, as in tasks.yaml. @throws as `writeGroundTruth`.
void writeTaskTruth(const std::filesystem::path& path, const Apartment& apartment,
                    const std::vector<TaskTruth>& tasks);

}  // namespace tsg::simulation
