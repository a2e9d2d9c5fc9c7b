// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/floor_map.h"

namespace tsg::simulation {

struct WalkConfig {
  double rate_hz = 10.0;
  double duration_s = 0.0;
  double max_speed_m_per_s = 1.0;
  double max_acceleration_m_per_s2 = 1.2;
  double max_turn_rad_per_s = 1.1;
  double body_radius_m = 0.28;
  double camera_height_m = 1.4;
  double pitch_down_rad = 0.3;
  int stops_per_room = 1;
  int laps = 1;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("rate_hz", self.rate_hz, {0.1, 100.0}, "Hz", "poses per second");
    v.field("duration_s", self.duration_s, {0.0, 86400.0}, "s",
            "the walk ends after this long; 0 = when all rooms have been seen");
    v.field("max_speed_m_per_s", self.max_speed_m_per_s, {0.05, 3.0}, "m/s", "walking speed");
    v.field("max_acceleration_m_per_s2", self.max_acceleration_m_per_s2, {0.1, 10.0}, "m/s^2",
            "change of speed");
    v.field("max_turn_rad_per_s", self.max_turn_rad_per_s, {0.05, 3.0}, "rad/s", "turn rate");
    v.field("body_radius_m", self.body_radius_m, {0.05, 0.4}, "m",
            "distance kept from everything, half a doorway at most");
    v.field("camera_height_m", self.camera_height_m, {0.3, 2.0}, "m", "above the floor");
    v.field("pitch_down_rad", self.pitch_down_rad, {-1.0, 1.0}, "rad", "view below the horizon");
    v.field("stops_per_room", self.stops_per_room, {1.0, 4.0}, "",
            "points of each room at which the camera turns all round");
    v.field("laps", self.laps, {1.0, 10.0}, "",
            "how often the rooms are seen; between two laps the walk goes back to its start");
  }
};

/// A camera pose on the walk; the stamp counts from the start of the walk.
struct WalkPose {
  Stamp stamp;
  Pose T_world_camera = Pose::Identity();
};

/// Points to look around from, per room (entry i = room i + 1), reachable with the clearance from
/// the corridor: in each room one well inside it and, if there are to be more, others far from it
/// and from each other; both ends of the corridor, the western first; none where there is no such
/// point, and in rooms of other floors.
std::vector<std::vector<Eigen::Vector2d>> findViewpoints(const Apartment& apartment,
                                                         const FloorMap& map, double clearance_m,
                                                         int floor = 0, int stops_per_room = 1);

/// A walk from one end of the corridor through every room to the other end: A* between the rooms'
/// viewpoints, shortened and rounded, then followed with bounded speed, acceleration and turn rate;
/// at each room's viewpoint the camera turns all round. Where there are more floors, the stairs
/// lead from the corridor's east end to the next. Further laps begin with the way back to the
/// start, and go as the first. Optical frames, world z up.
/// @throws std::invalid_argument for more than one lap where there are stairs.
/// @throws config::ConfigError; std::runtime_error if a room cannot be reached with the body
/// radius.
std::vector<WalkPose> planWalk(const Apartment& apartment, const WalkConfig& config);

/// Optical frame of a camera that looks along `yaw_rad` (about world z, from x) and down by
/// `pitch_down_rad`, without roll.
Pose makeCameraPose(const Eigen::Vector3d& position_m, double yaw_rad, double pitch_down_rad);

}  // namespace tsg::simulation
