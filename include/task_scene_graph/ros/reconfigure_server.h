// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "task_scene_graph/ros/state_publisher.h"

namespace tsg::ros_interface {

/// Serves dynamic_reconfigure's clients (dynparam, rqt_reconfigure) without its memory. The stock
/// server writes every value to the parameter server and starts from what it finds there, so that
/// yesterday's slider is today's setting; this one starts from what it is given and writes nothing.
/// @tparam Config  class generated from a .cfg file
template <typename Config>
class ReconfigureServer {
 public:
  struct Callbacks {
    /// Puts a configuration in force; throws to refuse it, and the old one stays.
    std::function<void(const Config&)> accept;
    std::function<void(const std::string&)> warn;  ///< a value was clamped or refused
  };

  /// @param handle  `set_parameters` and both topics are advertised in it
  ReconfigureServer(::ros::NodeHandle handle, const Config& initial, Callbacks callbacks)
      : config_(initial), callbacks_(std::move(callbacks)) {
    descriptions_ =
        handle.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
    updates_ = {handle, "parameter_updates"};
    service_ = handle.advertiseService("set_parameters", &ReconfigureServer::serve, this);
    auto description = Config::__getDescriptionMessage__();
    config_.__toMessage__(description.dflt);
    descriptions_.publish(description);
    updates_.publish(toMessage(config_));
  }

 private:
  static dynamic_reconfigure::Config toMessage(const Config& config) {
    dynamic_reconfigure::Config message;
    config.__toMessage__(message);
    return message;
  }

  bool serve(dynamic_reconfigure::Reconfigure::Request& request,
             dynamic_reconfigure::Reconfigure::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      const Config wanted = read(request.config);
      callbacks_.accept(wanted);
      config_ = wanted;
    } catch (const std::exception& e) {
      callbacks_.warn(std::string("dynamic_reconfigure: refused, nothing is changed: ") + e.what());
    }
    response.config = toMessage(config_);
    updates_.publish(response.config);
    return true;
  }

  Config read(dynamic_reconfigure::Config& message) const {
    Config wanted = config_;
    if (!wanted.__fromMessage__(message)) {
      throw std::invalid_argument("it names a parameter that cannot be changed while running");
    }
    const dynamic_reconfigure::Config before = toMessage(wanted);
    wanted.__clamp__();
    const dynamic_reconfigure::Config after = toMessage(wanted);
    warnOfClamped(before.doubles, after.doubles);
    warnOfClamped(before.ints, after.ints);
    return wanted;
  }

  template <typename Parameters>
  void warnOfClamped(const Parameters& before, const Parameters& after) const {
    for (std::size_t i = 0; i < before.size(); ++i) {
      const bool is_kept =
          !(before[i].value > after[i].value) && !(before[i].value < after[i].value);
      if (is_kept) continue;
      callbacks_.warn("dynamic_reconfigure: " + before[i].name + " = " +
                      std::to_string(before[i].value) + " is out of range, " +
                      std::to_string(after[i].value) + " is taken");
    }
  }

  std::mutex mutex_;  ///< guards config_
  Config config_;
  const Callbacks callbacks_;
  ::ros::Publisher descriptions_;
  StatePublisher<dynamic_reconfigure::Config> updates_;
  ::ros::ServiceServer service_;
};

}  // namespace tsg::ros_interface
