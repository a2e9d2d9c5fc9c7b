// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace tsg::ros_interface {

/// Which of the problems that a stage meets again and again are said once more. Each kind of
/// problem (its key) at once, then at most once in 10 s; one that stays as it is, word for word,
/// after 10, 20, 40, ... s, at most every 320 s. A problem that was away for 20 s is new.
class LogThrottle {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// @returns how many of the key were left unsaid since it was said last; nothing if this one is
  /// not to be said either. O(log keys).
  std::optional<std::uint64_t> admit(const std::string& key, const std::string& text, Time now) {
    const auto [found, is_first] = entries_.try_emplace(key);
    Entry& entry = found->second;
    const bool is_new = is_first || now - entry.last_met > 2 * kInterval;
    const bool is_same = !is_new && entry.text == text;
    entry.last_met = now;
    if (!is_new && now - entry.last_said < (is_same ? entry.interval : kInterval)) {
      ++entry.unsaid;
      return std::nullopt;
    }
    const std::uint64_t unsaid = entry.unsaid;
    entry.interval = is_same ? std::min(2 * entry.interval, kMaxInterval) : kInterval;
    entry.last_said = now;
    entry.text = text;
    entry.unsaid = 0;
    return unsaid;
  }

 private:
  static constexpr std::chrono::seconds kInterval{10};
  static constexpr std::chrono::seconds kMaxInterval{320};

  struct Entry {
    Time last_said;
    Time last_met;
    std::chrono::seconds interval = kInterval;
    std::string text;
    std::uint64_t unsaid = 0;
  };
  std::map<std::string, Entry> entries_;
};

}  // namespace tsg::ros_interface
