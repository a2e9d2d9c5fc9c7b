// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <task_scene_graph/GetMesh.h>
#include <task_scene_graph/GetObject.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graph_access.h"
#include "task_scene_graph/language/word_encoder.h"
#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/scene_graph/questions.h"

namespace tsg::nodelets {

/// Questions to the map and the camera: services `~ask`, `~explain`, `~get_object`,
/// `~get_mesh` and `~grasp_pixel`; and the topic `~question_markers`, latched: the scores of the
/// last question, made once somebody takes them.
class QuestionServices {
 public:
  /// @param services  whose callbacks run in a thread of their own, one at a time
  QuestionServices(ros::NodeHandle& services, GraphAccess access,
                   std::shared_ptr<language::WordEncoder> encoder);

 private:
  bool serveAsk(msg::AskRequest& request, msg::AskResponse& response);
  bool serveExplain(msg::ExplainRequest& request, msg::ExplainResponse& response);
  bool serveGetObject(msg::GetObject::Request& request, msg::GetObject::Response& response);
  bool serveGetMesh(msg::GetMesh::Request& request, msg::GetMesh::Response& response);
  bool serveGraspPixel(msg::GraspPixelRequest& request, msg::GraspPixelResponse& response);
  /// The embedding of words, an embedding or a picture; exactly one of them is there.
  template <typename Request>
  Embedding readQuestion(const Request& request);
  Embedding embedImage(const sensor_msgs::Image& image) const;
  void answer(const msg::AskRequest& request, msg::AskResponse& response);
  void publishMarkers();
  void findGraspPixel(const msg::GraspPixelRequest& request, msg::GraspPixelResponse& response);

  GraphAccess access_;
  std::shared_ptr<language::WordEncoder> encoder_;
  /// The last question, as long as its markers are not published.
  struct Asked {
    scene_graph::SceneGraphPtr graph;
    scene_graph::QuestionScores scores;
    std::string words;
  };
  std::optional<Asked> asked_;  ///< of the services' thread, as all callbacks
  ros::Publisher markers_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace tsg::nodelets
