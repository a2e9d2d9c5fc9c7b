// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

namespace tsg::bottleneck {

/// A JSON file as read.
struct JsonFile {
  nlohmann::json content;
  std::size_t num_odd_numbers = 0;  ///< NaN, Infinity, 1e999: not JSON, null in `content`
};

/// Reads a JSON file; numbers that Python's json module writes and JSON has not become null.
/// @throws std::runtime_error saying what the file is instead: absent, packed, a web page, cut off,
/// nested deeper than 256 levels (readers of JSON recurse), no JSON. The path is not in it.
JsonFile readJsonFile(const std::string& path);

}  // namespace tsg::bottleneck
