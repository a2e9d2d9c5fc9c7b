// SPDX-License-Identifier: BSD-3-Clause
#include <cv_bridge/cv_bridge.h>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"

namespace tsg::ros_interface {
namespace {

EmbeddingMatrix toRows(const msg::Segmentation& message, const std::string& topic) {
  const std::size_t num_segments = message.confidences.size();
  const std::size_t size = message.embedding_size;
  if (message.embeddings.size() != num_segments * size) {
    throw InputError("segmentation on " + topic + " has " +
                     std::to_string(message.embeddings.size()) + " embedding values, expected " +
                     std::to_string(num_segments) + " segments x " + std::to_string(size));
  }
  const auto rows = static_cast<Eigen::Index>(num_segments);
  const auto columns = static_cast<Eigen::Index>(size);
  return Eigen::Map<const EmbeddingMatrix>(message.embeddings.data(), rows, columns);
}

}  // namespace

std::vector<float> toFloats(const Embedding& embedding) {
  return {embedding.data(), embedding.data() + embedding.size()};
}

Embedding toEmbedding(const std::vector<float>& values) {
  return Eigen::Map<const Embedding>(values.data(), static_cast<Eigen::Index>(values.size()));
}

SegmentationPtr fromMessage(const msg::SegmentationConstPtr& message, const std::string& topic) {
  auto segmentation = std::make_shared<Segmentation>();
  try {
    const auto labels = cv_bridge::toCvShare(message->labels, message);
    segmentation->labels = labels->image;
    segmentation->owner = {labels.get(), [labels](const void*) {}};
  } catch (const std::exception& e) {
    throw InputError("label image on " + topic + " cannot be read: " + e.what());
  }
  segmentation->stamp = toStamp(message->header.stamp);
  segmentation->embeddings = toRows(*message, topic);
  segmentation->confidences = message->confidences;
  segmentation->image_embedding = toEmbedding(message->image_embedding);
  try {
    segmentation->validate();
  } catch (const std::invalid_argument& e) {
    throw InputError("segmentation on " + topic + ": " + e.what());
  }
  return segmentation;
}

msg::SegmentationPtr toMessage(const Segmentation& segmentation, const std::string& frame) {
  auto message = boost::make_shared<msg::Segmentation>();
  message->header.stamp = toRosTime(segmentation.stamp);
  message->header.frame_id = frame;
  cv_bridge::CvImage(message->header, "16UC1", segmentation.labels).toImageMsg(message->labels);
  const EmbeddingMatrix& rows = segmentation.embeddings;
  message->embedding_size = static_cast<std::uint32_t>(rows.cols());
  message->embeddings.assign(rows.data(), rows.data() + rows.size());
  message->confidences = segmentation.confidences;
  message->image_embedding = toFloats(segmentation.image_embedding);
  return message;
}

}  // namespace tsg::ros_interface
