// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/walk.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "task_scene_graph/config/config.h"

namespace tsg::simulation {
namespace {

using Path = std::vector<Eigen::Vector2d>;
using Way = std::vector<Eigen::Vector3d>;  ///< with the height of the ground

constexpr double kStep_s = 0.01;
constexpr double kLookAhead_m = 0.7;
constexpr double kTurnAcceleration_rad_per_s2 = 4.0;

double wrapAngle(double angle_rad) {
  return angle_rad - 2.0 * kPi * std::round(angle_rad / (2.0 * kPi));
}

/// Leaves out every point that a straight line can skip.
Path shorten(const Path& path, const FloorMap& map, double clearance_m) {
  Path result = {path.front()};
  for (std::size_t i = 0; i + 1 < path.size();) {
    std::size_t next = path.size() - 1;
    while (next > i + 1 && !map.isLineFree(path[i], path[next], clearance_m)) --next;
    result.push_back(path[next]);
    i = next;
  }
  return result;
}

/// Chaikin's corner cutting, a quarter of each edge but at most 0.4 m, where that stays free.
Path roundCorners(const Path& path, const FloorMap& map, double clearance_m) {
  Path result = {path.front()};
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const auto cut = [&](const Eigen::Vector2d& other) {
      const Eigen::Vector2d edge = other - path[i];
      return Eigen::Vector2d(path[i] + edge * std::min(0.25, 0.4 / edge.norm()));
    };
    const Eigen::Vector2d before = cut(path[i - 1]);
    const Eigen::Vector2d after = cut(path[i + 1]);
    if (map.isLineFree(before, after, clearance_m)) {
      result.push_back(before);
      result.push_back(after);
    } else {
      result.push_back(path[i]);
    }
  }
  result.push_back(path.back());
  return result;
}

/// Points every centimetre or so.
template <typename Points>
Points resample(const Points& path) {
  using Point = typename Points::value_type;
  Points result = {path.front()};
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Point edge = path[i] - path[i - 1];
    const int steps = std::max(1, static_cast<int>(std::ceil(edge.norm() / 0.01)));
    for (int s = 1; s <= steps; ++s) {
      result.push_back(path[i - 1] + edge * (static_cast<double>(s) / steps));
    }
  }
  return result;
}

Way lift(const Path& path, double z_m) {
  Way way;
  for (const Eigen::Vector2d& p : path) way.emplace_back(p.x(), p.y(), z_m);
  return way;
}

/// Follows legs in small time steps and writes a pose at each tick of the rate.
class Walker {
 public:
  Walker(const WalkConfig& config, const Way& start)
      : config_(config), position_m_(start.front()), yaw_rad_(headingAlong(start, 0)) {}

  void follow(const Way& path) {
    double travelled_m = 0.0;
    const double length_m = 0.01 * static_cast<double>(path.size() - 1);
    while (travelled_m < length_m - 1e-3 && !isOver()) {
      const auto index = static_cast<std::size_t>(travelled_m / 0.01);
      const double error_rad = wrapAngle(headingAlong(path, index) - yaw_rad_);
      turnBy(error_rad);
      const double facing = std::max(0.0, std::cos(error_rad));
      const double braking = std::sqrt(2.0 * config_.max_acceleration_m_per_s2 *
                                       std::max(1e-3, length_m - travelled_m));
      const double wanted = std::min(config_.max_speed_m_per_s * facing, braking);
      const double change = config_.max_acceleration_m_per_s2 * kStep_s;
      speed_m_per_s_ += std::clamp(wanted - speed_m_per_s_, -change, change);
      travelled_m = std::min(length_m, travelled_m + speed_m_per_s_ * kStep_s);
      position_m_ = path[std::min(path.size() - 1, static_cast<std::size_t>(travelled_m / 0.01))];
      const double share = travelled_m / 0.01 - std::floor(travelled_m / 0.01);
      const std::size_t next =
          std::min(path.size() - 1, static_cast<std::size_t>(travelled_m / 0.01) + 1);
      position_m_ += share * (path[next] - position_m_);
      tick();
    }
    speed_m_per_s_ = 0.0;
  }

  /// Turns on the spot until everything around has been seen and the heading is reached.
  void lookAround(double heading_rad) {
    double left_rad = chooseTurn(heading_rad - yaw_rad_);
    while (std::abs(left_rad) > 1e-3 && !isOver()) {
      const double before_rad = yaw_rad_;
      turnBy(left_rad);
      left_rad -= yaw_rad_ - before_rad;
      tick();
    }
  }

  static double headingAlong(const Way& path, std::size_t index) {
    const std::size_t ahead =
        std::min(path.size() - 1, index + static_cast<std::size_t>(kLookAhead_m / 0.01));
    const std::size_t from = ahead - index < 10 ? (ahead < 10 ? 0 : ahead - 10) : index;
    const Eigen::Vector3d d = path[ahead] - path[from];
    return std::atan2(d.y(), d.x());
  }

  std::vector<WalkPose> takePoses() { return std::move(poses_); }

 private:
  /// The smallest turn to either side that ends at the heading and is long enough: together with
  /// the field of view it covers nearly the full circle.
  static double chooseTurn(double difference_rad) {
    constexpr double kEnough_rad = 1.3 * kPi;
    const double left_rad = difference_rad - 2.0 * kPi * std::floor(difference_rad / (2.0 * kPi));
    double best_rad = left_rad + 2.0 * kPi;
    for (const double turn_rad : {left_rad, left_rad - 2.0 * kPi, left_rad - 4.0 * kPi}) {
      const bool enough = std::abs(turn_rad) >= kEnough_rad;
      if (enough && std::abs(turn_rad) < std::abs(best_rad)) best_rad = turn_rad;
    }
    return best_rad;
  }

  bool isOver() const {
    return config_.duration_s > 0.0 && static_cast<double>(steps_) * kStep_s > config_.duration_s;
  }

  void turnBy(double error_rad) {
    const double limit = config_.max_turn_rad_per_s;
    const double braking = std::sqrt(2.0 * kTurnAcceleration_rad_per_s2 * std::abs(error_rad));
    double wanted =
        std::clamp(error_rad / kStep_s, -std::min(limit, braking), std::min(limit, braking));
    const double change = kTurnAcceleration_rad_per_s2 * kStep_s;
    turn_rad_per_s_ += std::clamp(wanted - turn_rad_per_s_, -change, change);
    yaw_rad_ += turn_rad_per_s_ * kStep_s;
  }

  void tick() {
    const double due_s = static_cast<double>(poses_.size()) / config_.rate_hz;
    if (static_cast<double>(steps_) * kStep_s >= due_s - 1e-9) {
      const Eigen::Vector3d position = position_m_ + Eigen::Vector3d(0, 0, config_.camera_height_m);
      poses_.push_back(
          {Stamp::fromSeconds(due_s), makeCameraPose(position, yaw_rad_, config_.pitch_down_rad)});
    }
    ++steps_;
  }

  WalkConfig config_;
  Eigen::Vector3d position_m_;
  double yaw_rad_;
  double speed_m_per_s_ = 0.0;
  double turn_rad_per_s_ = 0.0;
  std::int64_t steps_ = 0;
  std::vector<WalkPose> poses_;
};

struct Stop {
  Eigen::Vector2d point_m;
  bool look_around = false;
};

/// The floor's rooms in the order of their doors, eastwards or westwards.
std::vector<int> orderRooms(const Apartment& apartment, int floor, bool eastwards) {
  std::vector<std::pair<double, int>> order;
  for (const Doorway& door : apartment.doorways) {
    const Room& from = apartment.rooms[static_cast<std::size_t>(door.room_a - 1)];
    const Room& to = apartment.rooms[static_cast<std::size_t>(door.room_b - 1)];
    if (from.kind != RoomKind::kCorridor || to.kind == RoomKind::kStaircase) continue;
    if (from.floor == floor) order.emplace_back(door.center_m.x(), door.room_b);
  }
  std::sort(order.begin(), order.end());
  if (!eastwards) std::reverse(order.begin(), order.end());
  std::vector<int> rooms;
  for (const auto& entry : order) rooms.push_back(entry.second);
  return rooms;
}

std::size_t findCorridor(const Apartment& apartment, int floor) {
  for (std::size_t i = 0; i < apartment.rooms.size(); ++i) {
    const Room& room = apartment.rooms[i];
    if (room.floor == floor && room.kind == RoomKind::kCorridor) return i;
  }
  throw std::runtime_error("walk: floor " + std::to_string(floor) + " has no corridor");
}

/// One end of the corridor, the rooms, an end of the corridor: the eastern one where stairs go up.
std::vector<Stop> orderStops(const Apartment& apartment, const FloorMap& map, double clearance_m,
                             int floor, int stops_per_room) {
  const auto viewpoints = findViewpoints(apartment, map, clearance_m, floor, stops_per_room);
  const auto& ends = viewpoints[findCorridor(apartment, floor)];
  if (ends.empty()) throw std::runtime_error("walk: corridor is blocked, expected a way");
  const bool eastwards = floor == 0;
  const bool ends_east = floor + 1 < apartment.countFloors() || eastwards;
  std::vector<Stop> stops = {{eastwards ? ends.front() : ends.back(), false}};
  for (const int room : orderRooms(apartment, floor, eastwards)) {
    const auto& points = viewpoints[static_cast<std::size_t>(room - 1)];
    if (points.empty()) {
      throw std::runtime_error("walk: room " + std::to_string(room) + " (" +
                               apartment.rooms[static_cast<std::size_t>(room - 1)].phrase +
                               ") is blocked, expected a way into it");
    }
    for (const Eigen::Vector2d& point_m : points) stops.push_back({point_m, true});
  }
  stops.push_back({ends_east ? ends.back() : ends.front(), false});
  return stops;
}

struct Leg {
  Way way;
  bool look_around = false;  ///< before it
};

/// The stops once more for each further lap: from the last of one to the first of the next.
std::vector<Stop> repeat(const std::vector<Stop>& stops, int laps) {
  std::vector<Stop> all;
  for (int lap = 0; lap < laps; ++lap) all.insert(all.end(), stops.begin(), stops.end());
  return all;
}

std::vector<Leg> planFloor(const Apartment& apartment, const WalkConfig& config, int floor) {
  const double z_m = apartment.rooms[findCorridor(apartment, floor)].floor_z_m;
  const FloorMap map(apartment, z_m + 0.05, z_m + 1.75);
  const double clearance_m = config.body_radius_m + map.cellSize();
  const std::vector<Stop> stops =
      repeat(orderStops(apartment, map, clearance_m, floor, config.stops_per_room), config.laps);
  std::vector<Leg> legs;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    Path path = map.findPath(stops[i].point_m, stops[i + 1].point_m, clearance_m);
    if (path.empty()) throw std::runtime_error("walk: no way between two rooms, expected one");
    path = shorten(path, map, clearance_m);
    for (int pass = 0; pass < 3; ++pass) path = roundCorners(path, map, clearance_m);
    legs.push_back({lift(resample(path), z_m), stops[i].look_around});
  }
  return legs;
}

}  // namespace

Pose makeCameraPose(const Eigen::Vector3d& position_m, double yaw_rad, double pitch_down_rad) {
  const Eigen::Vector3d forward(std::cos(yaw_rad) * std::cos(pitch_down_rad),
                                std::sin(yaw_rad) * std::cos(pitch_down_rad),
                                -std::sin(pitch_down_rad));
  const Eigen::Vector3d right(std::sin(yaw_rad), -std::cos(yaw_rad), 0.0);
  Pose T = Pose::Identity();
  T.linear().col(0) = right;
  T.linear().col(1) = forward.cross(right);
  T.linear().col(2) = forward;
  T.translation() = position_m;
  return T;
}

std::vector<WalkPose> planWalk(const Apartment& apartment, const WalkConfig& config) {
  config::validate(config, "walk");
  if (config.laps > 1 && apartment.countFloors() > 1) {
    throw std::invalid_argument("walk: " + std::to_string(config.laps) + " laps over " +
                                std::to_string(apartment.countFloors()) +
                                " floors, expected one lap where there are stairs");
  }
  std::vector<Leg> legs;
  for (int floor = 0; floor < apartment.countFloors(); ++floor) {
    std::vector<Leg> on_floor = planFloor(apartment, config, floor);
    if (!legs.empty()) {
      Way stairs = apartment.stairs[static_cast<std::size_t>(floor - 1)];
      stairs.insert(stairs.begin(), legs.back().way.back());
      stairs.push_back(on_floor.front().way.front());
      legs.push_back({resample(stairs), false});
    }
    legs.insert(legs.end(), on_floor.begin(), on_floor.end());
  }
  Walker walker(config, legs.front().way);
  for (const Leg& leg : legs) {
    if (leg.look_around) walker.lookAround(Walker::headingAlong(leg.way, 0));
    walker.follow(leg.way);
  }
  return walker.takePoses();
}

}  // namespace tsg::simulation
