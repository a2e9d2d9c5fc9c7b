// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/parameters.h"

#include <ros/names.h>

#include <stdexcept>

#include "task_scene_graph/config/config_file.h"
#include "task_scene_graph/core/files.h"

namespace tsg::ros_interface {
namespace {

constexpr const char* kConfigFile = "config_file";
constexpr const char* kDefaultConfigFile = "default_config_file";
constexpr const char* kLaunchFolder = "launch_folder";
constexpr const char* kServer = "parameter server";

YAML::Node makeTyped(const std::string& text, const char* tag) {
  YAML::Node node(text);
  node.SetTag(tag);
  return node;
}

YAML::Node convert(XmlRpc::XmlRpcValue& value, const std::string& name) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return makeTyped(static_cast<bool>(value) ? "true" : "false", config::kBoolTag);
    case XmlRpc::XmlRpcValue::TypeInt:
      return makeTyped(std::to_string(static_cast<int>(value)), config::kIntTag);
    case XmlRpc::XmlRpcValue::TypeDouble:
      return makeTyped(config::formatExactly(static_cast<double>(value)), config::kFloatTag);
    case XmlRpc::XmlRpcValue::TypeString:
      return YAML::Node(static_cast<std::string>(value));
    case XmlRpc::XmlRpcValue::TypeArray: {
      YAML::Node sequence(YAML::NodeType::Sequence);
      for (int i = 0; i < value.size(); ++i) sequence.push_back(convert(value[i], name));
      return sequence;
    }
    case XmlRpc::XmlRpcValue::TypeStruct: {
      YAML::Node map(YAML::NodeType::Map);
      for (auto& [key, entry] : value) {
        map[key] = convert(entry, name.empty() ? key : name + "/" + key);
      }
      return map;
    }
    default:
      throw std::invalid_argument("parameter '" + name +
                                  "' is none of bool, int, double, string, list, map");
  }
}

/// The namespace that the stages of a chain share.
::ros::NodeHandle findParent(const ::ros::NodeHandle& private_handle) {
  return ::ros::NodeHandle(::ros::names::parentNamespace(private_handle.getNamespace()));
}

/// A parameter of the nodelet, else of the namespace that the stages share; "" if neither is set.
std::string findText(const ::ros::NodeHandle& private_handle, const std::string& name) {
  for (const auto& handle : {private_handle, findParent(private_handle)}) {
    XmlRpc::XmlRpcValue value;
    if (!handle.getParam(name, value)) continue;
    if (value.getType() == XmlRpc::XmlRpcValue::TypeString) return value;
    throw config::ConfigError("parameter '" + handle.resolveName(name) + "' is '" +
                              config::formatNode(toYaml(value)) + "', expected the path of a file");
  }
  return "";
}

/// roslaunch's own folder, which is not that of the programs that it starts; "" if not known.
std::string findLaunchFolder(const ::ros::NodeHandle& private_handle) {
  std::string folder = findText(private_handle, kLaunchFolder);
  folder.erase(folder.find_last_not_of(" \n\r\t") + 1);
  return folder;
}

/// A map on the parameter server; an empty one if there is none.
YAML::Node readMap(const ::ros::NodeHandle& handle, const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!handle.getParam(name, value)) return YAML::Node(YAML::NodeType::Map);
  return toYaml(value);
}

std::vector<config::Source> readServer(const ::ros::NodeHandle& private_handle,
                                       const std::vector<std::string>& names) {
  const std::string folder = findLaunchFolder(private_handle);
  config::Source common{kServer, YAML::Node(YAML::NodeType::Map), folder};
  common.parameters["input"] = readMap(findParent(private_handle), "input");
  config::Source own{kServer, readMap(private_handle, private_handle.getNamespace()), folder};
  for (const char* name : {kConfigFile, kDefaultConfigFile, kLaunchFolder}) {
    own.parameters.remove(name);
  }
  return {config::pickShared(common, names), own};
}

}  // namespace

YAML::Node toYaml(XmlRpc::XmlRpcValue value) { return convert(value, ""); }

StageSources readSources(const ::ros::NodeHandle& private_handle, const std::string& stage,
                         const std::vector<std::string>& names) {
  const std::string folder = findLaunchFolder(private_handle);
  const auto readFile = [&](const char* parameter) {
    const auto path = expandPath(findText(private_handle, parameter), folder);
    return config::splitConfig(config::readConfigFile(path), stage, names);
  };
  StageSources sources{readFile(kDefaultConfigFile), readFile(kConfigFile)};
  for (auto& source : sources.packaged) source.name = "packaged default";
  for (auto& source : readServer(private_handle, names)) {
    sources.given.push_back(std::move(source));
  }
  return sources;
}

}  // namespace tsg::ros_interface
