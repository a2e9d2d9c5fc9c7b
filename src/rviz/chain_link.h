// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <QObject>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "background_jobs.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::rviz_plugin {

/// The chain that a panel shows and steers. Nothing here blocks: calls run in a thread of their
/// own, and what comes back is handed to the GUI's thread. Of the GUI's thread.
class ChainLink : public QObject {
 public:
  struct Handlers {
    std::function<void(const msg::TasksInForce&)> on_tasks;
    std::function<void(const msg::StageSettings&)> on_settings;  ///< of the scene graph stage
    std::function<void(const diagnostic_msgs::DiagnosticArray&)> on_diagnostics;
    std::function<void(const msg::AskResponse&)> on_answers;
    std::function<void(const std::string&)> on_explanation;
    std::function<void(const sensor_msgs::Image&)> on_picture;  ///< empty: there is none
    std::function<void(const std::string&)> on_note;            ///< what was done
    std::function<void(const std::string&)> on_error;  ///< what went wrong, and what was expected
  };

  explicit ChainLink(Handlers handlers);

  /// Listens to the chain in a namespace, "/task_scene_graph".
  void follow(const std::string& chain);
  const std::string& chain() const { return chain_; }

  void changeTasks(const msg::ChangeTasksRequest& request);
  void ask(const std::string& words);
  /// @param what  msg::ExplainRequest::OBJECT, ...
  void explain(std::uint8_t what, std::uint64_t id);
  /// Asks for the picture of an object or a primitive.
  void showPicture(std::uint8_t what, std::uint64_t id);
  /// Of dynamic_reconfigure.
  void setParameter(const std::string& name, double value);
  /// Calls one of the stage's services that take nothing: save_map, pause, resume, reset.
  void trigger(const std::string& service);
  void loadMap(const std::string& folder, bool with_tasks);

 private:
  /// Subscriptions and what calls them, ended with their last owner. The thread that subscribes may
  /// be the last: without a master it waits.
  struct Topics {
    ros::CallbackQueue queue;
    std::vector<ros::Subscriber> subscribers;
    std::unique_ptr<ros::AsyncSpinner> spinner;  ///< set once all is subscribed
  };

  static void subscribe(const std::shared_ptr<Topics>& topics, const std::string& stage,
                        const Handlers& handlers, const BackgroundJobs::Deliver& deliver);
  /// Calls a service of the stage; `use` gets the response in the GUI's thread.
  template <typename Service>
  void call(const std::string& name, const typename Service::Request& request,
            std::function<void(const typename Service::Response&)> use);
  std::string stage() const { return chain_ + "/scene_graph"; }

  Handlers handlers_;
  std::string chain_;
  std::shared_ptr<Topics> topics_;
  BackgroundJobs jobs_;
};

}  // namespace tsg::rviz_plugin
