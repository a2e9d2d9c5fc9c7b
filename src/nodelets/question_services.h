// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "graph_access.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/ros/messages.h"

namespace tsg::nodelets {

/// Questions to the map: services `~ask` and `~explain`.
class QuestionServices {
 public:
  /// @param services  whose callbacks run in a thread of their own, one at a time
  QuestionServices(ros::NodeHandle& services, GraphAccess access,
                   std::shared_ptr<language::WordEncoder> encoder);

 private:
  bool serveAsk(msg::AskRequest& request, msg::AskResponse& response);
  bool serveExplain(msg::ExplainRequest& request, msg::ExplainResponse& response);
  Embedding readQuestion(const msg::AskRequest& request);
  void answer(const msg::AskRequest& request, msg::AskResponse& response);

  GraphAccess access_;
  std::shared_ptr<language::WordEncoder> encoder_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace tsg::nodelets
