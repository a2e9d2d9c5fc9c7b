// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/parameters.h"

#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace tsg::ros_interface {
namespace {

std::string formatExactly(double value) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10) << value;
  return text.str();
}

}  // namespace

YAML::Node toYaml(XmlRpc::XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return YAML::Node(static_cast<bool>(value));
    case XmlRpc::XmlRpcValue::TypeInt:
      return YAML::Node(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return YAML::Node(formatExactly(static_cast<double>(value)));
    case XmlRpc::XmlRpcValue::TypeString:
      return YAML::Node(static_cast<std::string>(value));
    case XmlRpc::XmlRpcValue::TypeArray: {
      YAML::Node sequence(YAML::NodeType::Sequence);
      for (int i = 0; i < value.size(); ++i) sequence.push_back(toYaml(value[i]));
      return sequence;
    }
    case XmlRpc::XmlRpcValue::TypeStruct: {
      YAML::Node map(YAML::NodeType::Map);
      for (auto& [name, entry] : value) map[name] = toYaml(entry);
      return map;
    }
    default:
      throw std::invalid_argument("parameter type " + std::to_string(value.getType()) +
                                  " is none of bool, int, double, string, list, map");
  }
}

YAML::Node readParameters(const ::ros::NodeHandle& private_handle) {
  XmlRpc::XmlRpcValue value;
  if (!private_handle.getParam(private_handle.getNamespace(), value)) {
    return YAML::Node(YAML::NodeType::Map);
  }
  return toYaml(value);
}

}  // namespace tsg::ros_interface
