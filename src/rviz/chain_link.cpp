// SPDX-License-Identifier: BSD-3-Clause
#include "chain_link.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/service.h>
#include <std_srvs/Trigger.h>
#include <task_scene_graph/GetObject.h>
#include <task_scene_graph/LoadMap.h>

#include <exception>
#include <utility>

namespace tsg::rviz_plugin {
namespace {

/// In the background: what a service answers is handed on, or why there is no answer.
template <typename Service>
void callService(const std::string& name, Service exchange, const BackgroundJobs::Deliver& deliver,
                 const std::function<void(const typename Service::Response&)>& use,
                 const std::function<void(const std::string&)>& on_error) {
  std::string problem;
  try {
    if (!ros::service::exists(name, false)) {
      problem = "no service " + name + ": is the chain running, and is its namespace right?";
    } else if (!ros::service::call(name, exchange)) {
      problem = "the call of " + name + " failed: the chain may have ended";
    }
  } catch (const std::exception& e) {
    problem = name + ": " + e.what();
  }
  if (!problem.empty()) {
    deliver([on_error, problem] { on_error(problem); });
    return;
  }
  deliver([use, response = exchange.response] { use(response); });
}

}  // namespace

ChainLink::ChainLink(Handlers handlers) : handlers_(std::move(handlers)), jobs_(this) {}

void ChainLink::follow(const std::string& chain) {
  if (chain == chain_ && topics_ != nullptr) return;
  chain_ = chain;
  topics_ = std::make_shared<Topics>();
  jobs_.run([topics = topics_, stage = stage(), handlers = handlers_, deliver = jobs_.deliver()] {
    try {
      subscribe(topics, stage, handlers, deliver);
      topics->spinner = std::make_unique<ros::AsyncSpinner>(1, &topics->queue);
      topics->spinner->start();
    } catch (const std::exception& e) {
      deliver([handlers, text = stage + ": " + e.what()] { handlers.on_error(text); });
    }
  });
}

void ChainLink::subscribe(const std::shared_ptr<Topics>& topics, const std::string& stage,
                          const Handlers& handlers, const BackgroundJobs::Deliver& deliver) {
  ros::NodeHandle handle;
  handle.setCallbackQueue(&topics->queue);
  topics->subscribers.push_back(handle.subscribe<msg::TasksInForce>(
      stage + "/tasks", 1, [handlers, deliver](const msg::TasksInForceConstPtr& message) {
        deliver([handlers, message] { handlers.on_tasks(*message); });
      }));
  topics->subscribers.push_back(handle.subscribe<msg::StageSettings>(
      stage + "/settings", 1, [handlers, deliver](const msg::StageSettingsConstPtr& message) {
        deliver([handlers, message] { handlers.on_settings(*message); });
      }));
  topics->subscribers.push_back(handle.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 20,
      [handlers, deliver](const diagnostic_msgs::DiagnosticArrayConstPtr& message) {
        deliver([handlers, message] { handlers.on_diagnostics(*message); });
      }));
}

template <typename Service>
void ChainLink::call(const std::string& name, const typename Service::Request& request,
                     std::function<void(const typename Service::Response&)> use) {
  Service exchange;
  exchange.request = request;
  jobs_.run([name = name[0] == '/' ? name : stage() + "/" + name, exchange,
             deliver = jobs_.deliver(), use = std::move(use), on_error = handlers_.on_error] {
    callService(name, exchange, deliver, use, on_error);
  });
}

void ChainLink::changeTasks(const msg::ChangeTasksRequest& request) {
  call<msg::ChangeTasks>("change_tasks", request, [this](const auto& response) {
    (response.success != 0 ? handlers_.on_note : handlers_.on_error)(response.message);
    if (response.success != 0) handlers_.on_tasks(response.in_force);
  });
}

void ChainLink::ask(const std::string& words) {
  msg::AskRequest request;
  request.words = words;
  call<msg::Ask>("ask", request, [this](const auto& response) {
    if (response.success == 0) return handlers_.on_error(response.message);
    handlers_.on_note(response.message);
    handlers_.on_answers(response);
  });
}

void ChainLink::explain(std::uint8_t what, std::uint64_t id) {
  msg::ExplainRequest request;
  request.what = what;
  request.a = id;
  call<msg::Explain>("explain", request,
                     [this](const auto& response) { handlers_.on_explanation(response.message); });
}

void ChainLink::showPicture(std::uint8_t what, std::uint64_t id) {
  msg::GetObjectRequest request;
  request.what = what;
  request.id = id;
  call<msg::GetObject>("get_object", request, [this](const auto& response) {
    handlers_.on_picture(response.success != 0 ? response.thumbnail : sensor_msgs::Image());
  });
}

void ChainLink::loadMap(const std::string& folder, bool with_tasks) {
  msg::LoadMapRequest request;
  request.folder = folder;
  request.with_tasks = with_tasks ? 1 : 0;
  handlers_.on_note("loading '" + folder + "' ...");
  call<msg::LoadMap>("load_map", request, [this](const auto& response) {
    if (response.success == 0) return handlers_.on_error("load_map failed: " + response.message);
    std::string text = "load_map: done\n" + response.message;
    for (const auto& note : response.notes) text += "\n" + note;
    handlers_.on_note(text);
  });
}

void ChainLink::setParameter(const std::string& name, double value) {
  dynamic_reconfigure::ReconfigureRequest request;
  request.config.doubles.emplace_back();
  request.config.doubles.back().name = name;
  request.config.doubles.back().value = value;
  call<dynamic_reconfigure::Reconfigure>("set_parameters", request, [](const auto&) {});
}

void ChainLink::trigger(const std::string& service) {
  call<std_srvs::Trigger>(service, {}, [this, service](const auto& response) {
    const std::string text = service + ": " + (response.success != 0 ? "done" : "failed") +
                             (response.message.empty() ? "" : "\n" + response.message);
    (response.success != 0 ? handlers_.on_note : handlers_.on_error)(text);
  });
}

}  // namespace tsg::rviz_plugin
