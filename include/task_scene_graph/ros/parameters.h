// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>
#include <yaml-cpp/yaml.h>

#include <string>

#include "task_scene_graph/config/config.h"

namespace tsg::ros_interface {

/// A ROS parameter as YAML; numbers keep every digit. @throws std::invalid_argument for types that
/// YAML configurations do not have (dates, binary data).
YAML::Node toYaml(XmlRpc::XmlRpcValue value);

/// Everything in the node handle's namespace as one map; an empty map if there is nothing.
YAML::Node readParameters(const ::ros::NodeHandle& private_handle);

/// Reads a nodelet's private parameters into its configuration struct. @throws config::ConfigError
/// with all violations, each naming the parameter: unknown names (with the nearest known one),
/// wrong types, values out of range.
template <typename Config>
Config loadParameters(const ::ros::NodeHandle& private_handle, Config defaults = {}) {
  return config::load(readParameters(private_handle),
                      "parameters of " + private_handle.getNamespace(), std::move(defaults));
}

}  // namespace tsg::ros_interface
