// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace tsg::ros_interface {

/// Numbers of tasks by name, from 1 in the order in which they first came into force. A task that
/// goes and comes back has its number again, so ids and colours last. Not thread-safe.
class TaskNumbers {
 public:
  /// A name that was never there gets the next number.
  std::uint64_t find(const std::string& name) {
    const auto [entry, is_new] = numbers_.try_emplace(name, next_);
    if (is_new) ++next_;
    return entry->second;
  }

  /// The number goes over to the new name, which had none of its own or loses it.
  void rename(const std::string& name, const std::string& new_name) {
    const std::uint64_t number = find(name);
    numbers_.erase(name);
    numbers_[new_name] = number;
  }

 private:
  std::map<std::string, std::uint64_t> numbers_;
  std::uint64_t next_ = 1;
};

}  // namespace tsg::ros_interface
