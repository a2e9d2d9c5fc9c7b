// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "task_scene_graph/config/visitor.h"

namespace tsg::ros_interface {

/// tf2 knows no leading slash; tf 1, some drivers and some people write one.
inline std::string stripLeadingSlash(const std::string& frame) {
  const std::size_t begin = frame.find_first_not_of('/');
  return begin == std::string::npos ? "" : frame.substr(begin);
}

/// Visitor that takes leading slashes off every string of a configuration whose name ends in
/// "_frame" (config/visitor.h).
class FrameNameCleaner {
 public:
  template <typename T>
  void field(const char* name, T& value, config::Range, const char*, const char*) {
    if constexpr (std::is_same_v<T, std::string>) {
      if (isFrame(name)) value = stripLeadingSlash(value);
    }
  }
  template <typename Enum>
  void choice(const char*, Enum&, const config::Choices<Enum>&, const char*) {}
  template <typename Config>
  void group(const char*, Config& config) {
    Config::visit(config, *this);
  }

 private:
  static bool isFrame(std::string_view name) {
    constexpr std::string_view kEnding = "_frame";
    return name.size() > kEnding.size() && name.substr(name.size() - kEnding.size()) == kEnding;
  }
};

}  // namespace tsg::ros_interface
