// SPDX-License-Identifier: BSD-3-Clause
#include "question_services.h"

#include <ros/service.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <exception>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/core/find_by_id.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/object_conversions.h"
#include "task_scene_graph/ros/question_conversions.h"
#include "task_scene_graph/ros/question_markers.h"

namespace tsg::nodelets {
namespace {

constexpr std::uint32_t kDefaultAnswers = 5;

std::string explain(scene_graph::SceneGraphBuilder& builder, const msg::ExplainRequest& request) {
  switch (request.what) {
    case msg::ExplainRequest::OBJECT:
      return builder.explainObject({request.a});
    case msg::ExplainRequest::PRIMITIVES:
      return builder.explainPrimitives({request.a}, {request.b});
    case msg::ExplainRequest::PRIMITIVE:
      return builder.explainPrimitive({request.a});
    case msg::ExplainRequest::REGION:
      return builder.explainRegion({request.a});
    case msg::ExplainRequest::PLACES:
      return builder.explainPlaces({request.a}, {request.b});
    default:
      throw std::invalid_argument(
          "what " + std::to_string(request.what) +
          ", expected OBJECT (0), PRIMITIVES (1), PRIMITIVE (2), REGION (3) or PLACES (4)");
  }
}

/// Calls a service of a stage before this one. @throws std::runtime_error saying what is wrong.
template <typename Service>
typename Service::Response callUpstream(const GraphAccess& access, const std::string& name,
                                        const typename Service::Request& request,
                                        const std::string& need) {
  const auto services = access.upstream_services(name);
  if (services.empty()) {
    throw std::runtime_error(need + ": none of the stages before this one serves '" + name + "'");
  }
  Service call;
  call.request = request;
  if (!ros::service::call(services.front(), call)) {
    throw std::runtime_error("the call of " + services.front() + " failed");
  }
  if (call.response.success == 0) {
    throw std::runtime_error(services.front() + ": " + call.response.message);
  }
  return call.response;
}

/// The object that the primitive of a track is part of; 0: none, or not yet.
std::uint64_t findObjectOfTrack(const scene_graph::SceneGraph& graph, std::uint64_t track) {
  for (const auto& primitive : graph.primitives) {
    if (track == 0 || primitive->track.value != track) continue;
    for (const auto& object : graph.objects) {
      const auto& members = object.primitives;
      if (std::binary_search(members.begin(), members.end(), primitive->id)) return object.id.value;
    }
  }
  return 0;
}

std::string describeGrasp(const msg::GraspPixelResponse& grasp) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(3);
  text << "pixel (" << grasp.u << ", " << grasp.v << "), point (" << grasp.point.x << ", "
       << grasp.point.y << ", " << grasp.point.z << ") m, score " << grasp.score
       << (grasp.is_found != 0 ? "" : ", below alpha ");
  if (grasp.is_found == 0) text << grasp.alpha << ": it is hardly what is asked for";
  return text.str();
}

/// A primitive, or all of an object. @throws std::invalid_argument if it is not there.
std::vector<ObjectPrimitivePtr> findPrimitives(const scene_graph::SceneGraph& graph,
                                               const std::vector<PrimitiveId>& ids) {
  std::vector<ObjectPrimitivePtr> found;
  for (const PrimitiveId id : ids) {
    const auto primitive = findById(graph.primitives, id, [](const auto& p) { return p->id; });
    if (primitive == graph.primitives.end()) {
      throw std::invalid_argument("no primitive " + std::to_string(id.value) + " is in the map");
    }
    found.push_back(*primitive);
  }
  return found;
}

/// That of the primitive seen largest; null if none has one.
const ObjectPrimitive* findLargestPicture(const std::vector<ObjectPrimitivePtr>& primitives) {
  const ObjectPrimitive* largest = nullptr;
  for (const auto& primitive : primitives) {
    if (primitive->thumbnail.image.empty()) continue;
    const bool is_larger =
        largest == nullptr || primitive->views.best_pixels > largest->views.best_pixels;
    if (is_larger) largest = primitive.get();
  }
  return largest;
}

void describeObject(const scene_graph::SceneGraph& graph, ObjectId id,
                    msg::GetObject::Response& response) {
  const auto object = findById(graph.objects, id, [](const auto& o) { return o.id; });
  if (object == graph.objects.end()) {
    throw std::invalid_argument("no object " + std::to_string(id.value) + " is in the map");
  }
  response.task = object->task;
  response.box = ros_interface::toBoundingBox(object->oriented_box);
  for (const PrimitiveId primitive : object->primitives) {
    response.primitives.push_back(primitive.value);
  }
}

}  // namespace

QuestionServices::QuestionServices(ros::NodeHandle& services, GraphAccess access,
                                   std::shared_ptr<language::WordEncoder> encoder)
    : access_(std::move(access)),
      encoder_(std::move(encoder)),
      markers_(services.advertise<visualization_msgs::MarkerArray>(
          "question_markers", 1,
          [this](const ros::SingleSubscriberPublisher&) { publishMarkers(); },
          ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true)) {
  servers_.push_back(services.advertiseService("ask", &QuestionServices::serveAsk, this));
  servers_.push_back(services.advertiseService("explain", &QuestionServices::serveExplain, this));
  servers_.push_back(
      services.advertiseService("get_object", &QuestionServices::serveGetObject, this));
  servers_.push_back(services.advertiseService("get_mesh", &QuestionServices::serveGetMesh, this));
  servers_.push_back(
      services.advertiseService("grasp_pixel", &QuestionServices::serveGraspPixel, this));
}

template <typename Request>
Embedding QuestionServices::readQuestion(const Request& request) {
  const bool has_image = !request.image.data.empty() || !request.image.encoding.empty();
  const int given =
      (request.words.empty() ? 0 : 1) + (request.embedding.empty() ? 0 : 1) + (has_image ? 1 : 0);
  if (given != 1) {
    throw std::invalid_argument("the question has " + std::to_string(given) +
                                " of words, an embedding and an image, expected one of them");
  }
  if (has_image) return embedImage(request.image);
  if (!request.embedding.empty()) {
    return Eigen::Map<const Embedding>(request.embedding.data(),
                                       static_cast<Eigen::Index>(request.embedding.size()));
  }
  scene_graph::TaskList words;
  words.names = {request.words};
  words.validate("question");
  return encoder_->encode(words.names).row(0).transpose();
}

Embedding QuestionServices::embedImage(const sensor_msgs::Image& image) const {
  msg::EmbedImageRequest request;
  request.image = image;
  return ros_interface::toEmbedding(
      callUpstream<msg::EmbedImage>(access_, "embed_image", request,
                                    "a picture needs the image encoder of the segmenter")
          .embedding);
}

void QuestionServices::answer(const msg::AskRequest& request, msg::AskResponse& response) {
  const scene_graph::SceneGraphPtr graph = access_.graph();
  const Embedding question = readQuestion(request);
  if (graph == nullptr) throw std::runtime_error("there is no map yet");
  const std::uint32_t max_answers =
      request.max_answers == 0 ? kDefaultAnswers : request.max_answers;
  scene_graph::QuestionScores scores = scene_graph::scoreQuestion(*graph, question);
  const scene_graph::Answers answers = scene_graph::answerQuestion(*graph, scores, max_answers);
  response = ros_interface::toMessage(answers, *graph, request.with_thumbnails != 0);
  response.message = (request.words.empty() ? std::string() : "'" + request.words + "': ") +
                     scene_graph::describeAnswers(answers, *graph);
  response.success = 1;
  asked_ = Asked{graph, std::move(scores), request.words};
  if (markers_.getNumSubscribers() > 0) publishMarkers();
}

void QuestionServices::publishMarkers() {
  if (!asked_) return;
  markers_.publish(
      ros_interface::makeQuestionMarkers(*asked_->graph, asked_->scores, asked_->words));
  asked_.reset();
}

bool QuestionServices::serveAsk(msg::AskRequest& request, msg::AskResponse& response) {
  try {
    answer(request, response);
  } catch (const std::exception& e) {
    response.message = std::string("not answered: ") + e.what();
  }
  return true;
}

void QuestionServices::findGraspPixel(const msg::GraspPixelRequest& request,
                                      msg::GraspPixelResponse& response) {
  msg::GraspPixelRequest by_embedding;
  by_embedding.max_age_s = request.max_age_s;
  by_embedding.embedding = ros_interface::toFloats(readQuestion(request));
  response = callUpstream<msg::GraspPixel>(access_, "grasp_pixel", by_embedding,
                                           "what the camera sees now is known to the tracker");
  if (const scene_graph::SceneGraphPtr graph = access_.graph()) {
    response.alpha = static_cast<float>(graph->config.object_alpha);
    response.object = findObjectOfTrack(*graph, response.track);
  }
  response.is_found = response.score >= response.alpha ? 1 : 0;
  response.message = (request.words.empty() ? std::string() : "'" + request.words + "': ") +
                     describeGrasp(response);
}

bool QuestionServices::serveGraspPixel(msg::GraspPixelRequest& request,
                                       msg::GraspPixelResponse& response) {
  try {
    findGraspPixel(request, response);
  } catch (const std::exception& e) {
    response = msg::GraspPixelResponse();
    response.message = std::string("no grasp pixel: ") + e.what();
  }
  return true;
}

bool QuestionServices::serveGetObject(msg::GetObject::Request& request,
                                      msg::GetObject::Response& response) {
  try {
    const scene_graph::SceneGraphPtr graph = access_.graph();
    if (graph == nullptr) throw std::runtime_error("there is no map yet");
    const bool is_object = request.what == msg::GetObject::Request::OBJECT;
    if (is_object) describeObject(*graph, {request.id}, response);
    if (!is_object) response.primitives = {request.id};
    std::vector<PrimitiveId> ids;
    for (const std::uint64_t id : response.primitives) ids.push_back({id});
    const std::vector<ObjectPrimitivePtr> primitives = findPrimitives(*graph, ids);
    if (!is_object) response.box = ros_interface::toBoundingBox(primitives.front()->oriented_box);
    response.points = ros_interface::toPointCloud(primitives, graph->world_frame);
    response.points.header.stamp = ros_interface::toRosTime(graph->stamp);
    if (const ObjectPrimitive* largest = findLargestPicture(primitives)) {
      response.thumbnail = ros_interface::toThumbnailMessage(largest->thumbnail);
    }
    response.success = 1;
  } catch (const std::exception& e) {
    response = msg::GetObject::Response();
    response.message = std::string("no object: ") + e.what();
  }
  return true;
}

bool QuestionServices::serveGetMesh(msg::GetMesh::Request&, msg::GetMesh::Response& response) {
  try {
    const scene_graph::SceneGraphPtr graph = access_.graph();
    if (graph == nullptr) throw std::runtime_error("there is no map yet");
    const auto object_of_primitive = scene_graph::computeObjectOfPrimitives(*graph);
    if (access_.mesh_points) {
      response.points = access_.mesh_points(object_of_primitive);
    } else {
      msg::GetMesh::Request labelled;
      for (const auto& [primitive, object] : object_of_primitive) {
        labelled.primitives.push_back(primitive.value);
        labelled.objects.push_back(object);
      }
      response =
          callUpstream<msg::GetMesh>(access_, "get_mesh", labelled, "mesh_fusion has the mesh");
    }
    response.success = 1;
  } catch (const std::exception& e) {
    response = msg::GetMesh::Response();
    response.message = std::string("no mesh: ") + e.what();
  }
  return true;
}

bool QuestionServices::serveExplain(msg::ExplainRequest& request, msg::ExplainResponse& response) {
  try {
    access_.run([&](scene_graph::SceneGraphBuilder& builder) {
      response.message = explain(builder, request);
    });
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("not explained: ") + e.what();
  }
  return true;
}

}  // namespace tsg::nodelets
