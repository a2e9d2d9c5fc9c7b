// SPDX-License-Identifier: BSD-3-Clause
#include "json_fields.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace tsg::scene_graph {

using nlohmann::json;

void fail(const std::string& what) { throw std::runtime_error(what); }

void failOn(const char* name, const json& value, const char* expected) {
  constexpr std::size_t kLongest = 80;
  std::string text = value.dump();
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  fail("has '" + std::string(name) + "' = " + text + ", expected " + expected);
}

const json& getField(const json& object, const char* name) {
  const auto place = object.find(name);
  if (place == object.end()) fail("has no '" + std::string(name) + "'");
  return *place;
}

Eigen::Vector3d readVector(const json& object, const char* name) {
  const json& value = getField(object, name);
  const bool is_vector =
      value.is_array() && value.size() == 3 &&
      std::all_of(value.begin(), value.end(), [](const json& x) { return x.is_number(); });
  if (!is_vector) failOn(name, value, "3 numbers");
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

json toJson(const Eigen::Vector3d& v) { return json::array({v.x(), v.y(), v.z()}); }

}  // namespace tsg::scene_graph
