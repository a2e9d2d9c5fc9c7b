// SPDX-License-Identifier: BSD-3-Clause
#include "question_services.h"

#include <exception>
#include <stdexcept>
#include <utility>

#include "task_scene_graph/ros/question_conversions.h"
#include "task_scene_graph/scene_graph/questions.h"

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

}  // namespace

QuestionServices::QuestionServices(ros::NodeHandle& services, GraphAccess access,
                                   std::shared_ptr<language::WordEncoder> encoder)
    : access_(std::move(access)), encoder_(std::move(encoder)) {
  servers_.push_back(services.advertiseService("ask", &QuestionServices::serveAsk, this));
  servers_.push_back(services.advertiseService("explain", &QuestionServices::serveExplain, this));
}

Embedding QuestionServices::readQuestion(const msg::AskRequest& request) {
  if (request.words.empty() == request.embedding.empty()) {
    throw std::invalid_argument(request.words.empty()
                                    ? "neither words nor an embedding, expected one of them"
                                    : "words and an embedding, expected one of them");
  }
  if (!request.embedding.empty()) {
    return Eigen::Map<const Embedding>(request.embedding.data(),
                                       static_cast<Eigen::Index>(request.embedding.size()));
  }
  scene_graph::TaskList words;
  words.names = {request.words};
  words.validate("question");
  return encoder_->encode(words.names).row(0).transpose();
}

void QuestionServices::answer(const msg::AskRequest& request, msg::AskResponse& response) {
  const scene_graph::SceneGraphPtr graph = access_.graph();
  const Embedding question = readQuestion(request);
  if (graph == nullptr) throw std::runtime_error("there is no map yet");
  const std::uint32_t max_answers =
      request.max_answers == 0 ? kDefaultAnswers : request.max_answers;
  const scene_graph::Answers answers = scene_graph::answerQuestion(*graph, question, max_answers);
  response = ros_interface::toMessage(answers, *graph, request.with_thumbnails != 0);
  response.message = (request.words.empty() ? std::string() : "'" + request.words + "': ") +
                     scene_graph::describeAnswers(answers, *graph);
  response.success = 1;
}

bool QuestionServices::serveAsk(msg::AskRequest& request, msg::AskResponse& response) {
  try {
    answer(request, response);
  } catch (const std::exception& e) {
    response.message = std::string("not answered: ") + e.what();
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
