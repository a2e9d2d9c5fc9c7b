// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

/// Configuration structs list each of their fields once, in a static `visit`:
///
///     struct TrackerConfig {
///       double window_s = 5.0;
///       Association association = Association::kGreedy;
///
///       template <typename Self, typename Visitor>
///       static void visit(Self& self, Visitor& v) {
///         v.field("window_s", self.window_s, {0.0, 60.0}, "s", "a track unseen for this long
///         ends"); v.choice("association", self.association, {{"greedy", Association::kGreedy}},
///         "how ..."); v.group("frames", self.frames);  // a nested config struct
///       }
///     };
///
/// The visitors of config.h load, check, print and document any such struct. Field types: bool,
/// int, double, std::string, std::filesystem::path (read as expandPath() does, relative to the
/// folder of what gives it), NumbersOrPath, std::vector<std::string>, std::vector<double>. Ranges
/// are inclusive and only checked for numbers. Of several names of one choice the first is what is
/// printed; `-` in a choice is read as `_`.
namespace tsg::config {

struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// Numbers apart by blanks, commas or brackets, or else the path of a file that holds them, read as
/// std::filesystem::path is.
struct NumbersOrPath {
  std::string text;

  bool isEmpty() const { return text.empty(); }
};

template <typename Enum>
using Choices = std::vector<std::pair<std::string, Enum>>;

}  // namespace tsg::config
