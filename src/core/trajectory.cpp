// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/trajectory.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "task_scene_graph/core/files.h"

namespace tsg {
namespace {

constexpr std::size_t kNumValues = 8;  // stamp tx ty tz qx qy qz qw
constexpr std::size_t kNumKittiValues = 12;
constexpr long double kLargestStamp_s = 4294967295.0L;  // what a ROS 1 message can hold
constexpr double kMinQuaternionNorm = 1e-3;

[[noreturn]] void failAtLine(const std::string& path, int line, const std::string& text) {
  throw std::runtime_error("trajectory '" + path + "', line " + std::to_string(line) + ": " + text +
                           "; expected lines 'stamp tx ty tz qx qy qz qw' (seconds, metres)");
}

std::vector<std::string> splitWords(std::string line) {
  for (char& c : line) {
    if (c == ',') c = ' ';
  }
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

long double parseNumber(const std::string& word, const std::string& path, int line) {
  char* end = nullptr;
  const long double value = std::strtold(word.c_str(), &end);
  if (end != word.c_str() + word.size()) failAtLine(path, line, "'" + word + "' is not a number");
  return value;
}

Stamp parseStamp(const std::string& word, const std::string& path, int line) {
  const long double seconds = parseNumber(word, path, line);
  if (seconds > kLargestStamp_s) {
    failAtLine(path, line, "stamp " + word + " is too large; it looks like nanoseconds");
  }
  if (!(seconds >= 0.0L)) failAtLine(path, line, "stamp " + word + " is not a time since 0");
  return {static_cast<std::int64_t>(std::llround(seconds * 1e9L))};
}

/// Nothing if a value is not finite.
std::optional<Pose> parsePose(const std::vector<std::string>& words, const std::string& path,
                              int line) {
  std::array<double, kNumValues - 1> v{};
  bool is_finite = true;
  for (std::size_t i = 0; i < v.size(); ++i) {
    v[i] = static_cast<double>(parseNumber(words[i + 1], path, line));
    is_finite = is_finite && std::isfinite(v[i]);
  }
  if (!is_finite) return std::nullopt;
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (rotation.norm() < kMinQuaternionNorm) failAtLine(path, line, "the quaternion has no length");
  Pose pose = Pose::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

void writePose(std::ostream& stream, Stamp stamp, const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  stream << stamp.ns / kNanosecondsPerSecond << '.' << std::setw(9) << std::setfill('0')
         << stamp.ns % kNanosecondsPerSecond << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << ' '
         << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
}

void requireWords(const std::vector<std::string>& words, const std::string& path, int line) {
  if (words.size() == kNumValues) return;
  failAtLine(
      path, line,
      std::to_string(words.size()) + " values" +
          (words.size() == kNumKittiValues ? ", which looks like KITTI's poses without stamps"
                                           : ""));
}

}  // namespace

void Trajectory::add(Stamp stamp, const Pose& pose) { poses_[stamp.ns] = pose; }

std::optional<Pose> Trajectory::interpolate(Stamp stamp, double max_gap_s) const {
  const auto after = poses_.lower_bound(stamp.ns);
  if (after == poses_.end()) return std::nullopt;
  if (after->first == stamp.ns) return after->second;
  if (after == poses_.begin() || gapAt(stamp) > max_gap_s) return std::nullopt;
  const auto before = std::prev(after);
  const double share =
      secondsBetween({before->first}, stamp) / secondsBetween({before->first}, {after->first});
  const Eigen::Quaterniond from(before->second.linear());
  const Eigen::Quaterniond to(after->second.linear());
  Pose pose = Pose::Identity();
  pose.linear() = from.slerp(share, to).toRotationMatrix();
  pose.translation() =
      (1.0 - share) * before->second.translation() + share * after->second.translation();
  return pose;
}

double Trajectory::gapAt(Stamp stamp) const {
  const auto after = poses_.lower_bound(stamp.ns);
  const bool is_between =
      after != poses_.end() && after->first != stamp.ns && after != poses_.begin();
  return is_between ? secondsBetween({std::prev(after)->first}, {after->first}) : 0.0;
}

void Trajectory::forgetBefore(Stamp stamp) {
  const auto first_kept = poses_.lower_bound(stamp.ns);
  if (first_kept == poses_.begin()) return;
  poses_.erase(poses_.begin(), std::prev(first_kept));
}

Trajectory loadTumTrajectory(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("trajectory '" + path + "' cannot be opened");
  Trajectory trajectory;
  std::string text;
  for (int line = 1; std::getline(file, text); ++line) {
    const auto words = splitWords(text.substr(0, text.find('#')));
    if (words.empty()) continue;
    requireWords(words, path, line);
    const Stamp stamp = parseStamp(words[0], path, line);
    if (const auto pose = parsePose(words, path, line)) trajectory.add(stamp, *pose);
  }
  if (trajectory.isEmpty()) {
    throw std::runtime_error("trajectory '" + path + "' holds no pose");
  }
  return trajectory;
}

void writeTumTrajectory(const std::string& path, const Trajectory& trajectory,
                        const std::string& what) {
  writeFileAtomically(path, [&](std::ostream& stream) {
    stream << "# " << what << ": stamp_s tx_m ty_m tz_m qx qy qz qw\n"
           << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (const auto& [ns, pose] : trajectory.poses()) writePose(stream, {ns}, pose);
  });
}

}  // namespace tsg
