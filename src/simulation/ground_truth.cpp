// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/ground_truth.h"

#include <iomanip>
#include <nlohmann/json.hpp>

#include "task_scene_graph/core/files.h"

namespace tsg::simulation {
namespace {

using Json = nlohmann::json;

Json toJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

struct OrientedBox {
  Eigen::Vector3d center_m;
  Eigen::Vector3d extents_m;
  Eigen::Quaterniond rotation;
};

/// The box along the axes of the thing's own frame.
OrientedBox computeOrientedBox(const Pose& T_world_thing, const Aabb& local_box) {
  return {T_world_thing * local_box.center(), local_box.sizes(),
          Eigen::Quaterniond(T_world_thing.linear())};
}

OrientedBox computeOrientedBox(const Instance& instance) {
  return computeOrientedBox(instance.T_world_instance, instance.local_box);
}

Json describeInstance(const Instance& instance) {
  const OrientedBox box = computeOrientedBox(instance);
  const Eigen::Quaterniond& q = box.rotation;
  return {{"id", instance.id},
          {"phrase", instance.phrase},
          {"color", instance.color_name},
          {"room", instance.room},
          {"box_min_m", toJson(instance.box.min())},
          {"box_max_m", toJson(instance.box.max())},
          {"center_m", toJson(box.center_m)},
          {"extents_m", toJson(box.extents_m)},
          {"rotation", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}}};
}

Json describeInstances(const Apartment& apartment) {
  Json list = Json::array();
  for (const Instance& instance : apartment.instances) list.push_back(describeInstance(instance));
  return list;
}

Json describeRooms(const Apartment& apartment) {
  Json rooms = Json::array();
  for (const Room& room : apartment.rooms) {
    Json instances = Json::array();
    for (const Instance& instance : apartment.instances) {
      if (instance.room == room.id) instances.push_back(instance.id);
    }
    const Rect& r = room.interior_m;
    rooms.push_back({{"id", room.id},
                     {"name", room.phrase},
                     {"rectangle_m", {r.min().x(), r.min().y(), r.max().x(), r.max().y()}},
                     {"floor_z_m", room.floor_z_m},
                     {"height_m", room.height_m},
                     {"instances", instances}});
  }
  Json doorways = Json::array();
  for (const Doorway& door : apartment.doorways) {
    doorways.push_back({{"rooms", {door.room_a, door.room_b}},
                        {"center_m", {door.center_m.x(), door.center_m.y()}},
                        {"width_m", door.width_m}});
  }
  return {{"rooms", rooms}, {"doorways", doorways}};
}

void writeJson(const std::filesystem::path& path, const Json& json) {
  writeFileAtomically(path, [&](std::ostream& out) { out << json.dump(1) << "\n"; });
}

void writeBox(std::ostream& out, const OrientedBox& box) {
  const Eigen::Vector3d& c = box.center_m;
  const Eigen::Vector3d& e = box.extents_m;
  const Eigen::Quaterniond& q = box.rotation;
  out << "  - center: [" << c.x() << ", " << c.y() << ", " << c.z() << "]\n    extents: [" << e.x()
      << ", " << e.y() << ", " << e.z() << "]\n    rotation: {w: " << q.w() << ", x: " << q.x()
      << ", y: " << q.y() << ", z: " << q.z() << "}\n";
}

void writeBoxes(std::ostream& out, const Apartment& apartment, const TaskTruth& task) {
  const bool is_empty = task.instances.empty() && task.groups.empty();
  out << "\"" << task.name << "\":" << (is_empty ? " []\n" : "\n");
  for (const std::uint16_t id : task.instances) {
    writeBox(out, computeOrientedBox(apartment.instances[id - 1U]));
  }
  for (const std::size_t index : task.groups) {
    const Group& group = apartment.groups[index];
    writeBox(out, computeOrientedBox(group.T_world_group, group.local_box));
  }
}

void writePoses(std::ostream& out, const std::vector<WalkPose>& walk) {
  out << std::setprecision(12);
  for (const WalkPose& pose : walk) {
    const Eigen::Vector3d t = pose.T_world_camera.translation();
    const Eigen::Quaterniond q(pose.T_world_camera.linear());
    out << pose.stamp.seconds() << " " << t.x() << " " << t.y() << " " << t.z() << " " << q.x()
        << " " << q.y() << " " << q.z() << " " << q.w() << "\n";
  }
}

}  // namespace

void writeGroundTruth(const std::filesystem::path& folder, const Apartment& apartment,
                      const std::vector<TaskTruth>& tasks, const std::vector<WalkPose>& walk) {
  writeJson(folder / "instances.json", describeInstances(apartment));
  writeJson(folder / "rooms.json", describeRooms(apartment));
  writeTaskTruth(folder / "tasks.yaml", apartment, tasks);
  writeFileAtomically(folder / "poses.txt", [&](std::ostream& out) { writePoses(out, walk); });
}

void writeTaskTruth(const std::filesystem::path& path, const Apartment& apartment,
                    const std::vector<TaskTruth>& tasks) {
  writeFileAtomically(path, [&](std::ostream& out) {
    out << std::setprecision(9);
    for (const TaskTruth& task : tasks) writeBoxes(out, apartment, task);
  });
}

}  // namespace tsg::simulation
