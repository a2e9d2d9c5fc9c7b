// SPDX-License-Identifier: BSD-3-Clause
#include "mesh_display.h"

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <ros/message_traits.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>

#include <chrono>
#include <pluginlib/class_list_macros.hpp>

namespace tsg::rviz_plugin {
namespace {

/// Of one picture; what is left is drawn in the next.
constexpr std::chrono::milliseconds kDrawingTime{30};

QString messageType() {
  return QString::fromStdString(ros::message_traits::datatype<msg::MeshUpdate>());
}

}  // namespace

MeshDisplay::MeshDisplay() {
  topic_ = new rviz::RosTopicProperty("Topic", "", messageType(), "Changes of a background mesh.",
                                      this, SLOT(onTopicChanged()));
  color_by_ = new rviz::EnumProperty("Color By", "Camera", "What the colours mean.", this,
                                     SLOT(onStyleChanged()));
  color_by_->addOption("Camera", static_cast<int>(ColorBy::kCamera));
  color_by_->addOption("Shape", static_cast<int>(ColorBy::kShape));
  color_by_->addOption("Height", static_cast<int>(ColorBy::kHeight));
  alpha_ = new rviz::FloatProperty("Alpha", 1.0F, "0 is invisible, 1 opaque.", this,
                                   SLOT(onStyleChanged()));
  alpha_->setMin(0.0F);
  alpha_->setMax(1.0F);
  back_faces_ = new rviz::BoolProperty(
      "Back Faces", true,
      "Draw surfaces also from behind. Without, one looks into rooms through ceilings and walls.",
      this, SLOT(onStyleChanged()));
}

MeshDisplay::~MeshDisplay() {
  subscriber_.shutdown();
  chunks_.clear();  // before the material and the scene node that they use
}

void MeshDisplay::onInitialize() {
  material_ = std::make_unique<MeshMaterial>();
  onStyleChanged();
}

void MeshDisplay::setTopic(const QString& topic, const QString&) { topic_->setValue(topic); }

void MeshDisplay::onEnable() { subscribe(); }

void MeshDisplay::onDisable() {
  unsubscribe();
  clear();
}

void MeshDisplay::reset() {
  Display::reset();
  onTopicChanged();
}

void MeshDisplay::onTopicChanged() {
  unsubscribe();
  clear();
  if (isEnabled()) subscribe();
}

void MeshDisplay::onStyleChanged() {
  if (!material_) return;
  material_->setTransparent(alpha_->getFloat() < 0.9998F);
  material_->setBackFaces(back_faces_->getBool());
  for (const auto& [chunk, visual] : chunks_) dirty_.insert(chunk);
}

void MeshDisplay::subscribe() {
  must_resubscribe_ = false;
  if (topic_->getTopicStd().empty()) return;
  try {
    subscriber_ = update_nh_.subscribe(topic_->getTopicStd(), 1000, &MeshDisplay::onMessage, this);
    setStatus(rviz::StatusProperty::Warn, "Topic", "No message so far");
  } catch (const ros::Exception& e) {
    setStatus(rviz::StatusProperty::Error, "Topic", QString("Cannot subscribe: ") + e.what());
  }
}

void MeshDisplay::unsubscribe() { subscriber_.shutdown(); }

void MeshDisplay::clear() {
  reader_.reset();
  dirty_.clear();
  chunks_.clear();
  num_messages_ = 0;
}

void MeshDisplay::onMessage(const msg::MeshUpdateConstPtr& message) {
  ++num_messages_;
  try {
    takeIn(*message);
  } catch (const std::exception& e) {
    setStatus(rviz::StatusProperty::Error, "Topic", QString("Unusable message: ") + e.what());
  }
}

void MeshDisplay::takeIn(const msg::MeshUpdate& message) {
  using Status = ros_interface::MeshUpdateReader::Status;
  const auto result = reader_.apply(message);
  frame_ = message.header.frame_id;
  if (result.has_restarted) {
    for (const auto& [chunk, visual] : chunks_) dirty_.insert(chunk);
  }
  for (const auto& block : result.changed) dirty_.insert(mapping::computeMeshChunk(block));
  must_resubscribe_ = must_resubscribe_ || result.status == Status::kLost;
  if (result.status == Status::kApplied || reader_.hasWholeMesh()) {
    setStatus(rviz::StatusProperty::Ok, "Topic", QString("%1 messages").arg(num_messages_));
  } else {
    setStatus(rviz::StatusProperty::Warn, "Topic",
              "Waiting for the whole mesh (only the first display of a topic is sent it)");
  }
}

void MeshDisplay::update(float, float) {
  if (must_resubscribe_) {
    unsubscribe();
    subscribe();
  }
  placeInFixedFrame();
  drawDirtyChunks();
}

void MeshDisplay::placeInFixedFrame() {
  if (frame_.empty()) return;
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  if (!context_->getFrameManager()->getTransform(frame_, ros::Time(), position, orientation)) {
    std::string problem;
    context_->getFrameManager()->transformHasProblems(frame_, ros::Time(), problem);
    setStatusStd(rviz::StatusProperty::Error, "Transform", problem);
    return;
  }
  setStatus(rviz::StatusProperty::Ok, "Transform", "Ok");
  scene_node_->setPosition(position);
  scene_node_->setOrientation(orientation);
}

void MeshDisplay::drawDirtyChunks() {
  if (dirty_.empty()) return;
  const auto deadline = std::chrono::steady_clock::now() + kDrawingTime;
  while (!dirty_.empty() && std::chrono::steady_clock::now() < deadline) {
    drawChunk(*dirty_.begin());
    dirty_.erase(dirty_.begin());
  }
  showCounts();
  context_->queueRender();
}

void MeshDisplay::drawChunk(const Index& chunk) {
  std::vector<const Mesh*> meshes;
  const int side = mapping::kMeshChunkSide;
  for (int i = 0; i < side * side * side; ++i) {
    const Index block = chunk * side + Index(i % side, i / side % side, i / (side * side));
    const auto found = reader_.blocks().find(block);
    if (found != reader_.blocks().end()) meshes.push_back(found->second.get());
  }
  if (meshes.empty()) {
    chunks_.erase(chunk);
    return;
  }
  auto& visual = chunks_[chunk];
  if (!visual) visual = std::make_unique<MeshChunkVisual>(*scene_manager_, *scene_node_);
  const MeshStyle style{static_cast<ColorBy>(color_by_->getOptionInt()), alpha_->getFloat()};
  visual->draw(meshes, style, material_->name());
}

void MeshDisplay::showCounts() {
  std::size_t num_triangles = 0;
  for (const auto& [block, mesh] : reader_.blocks()) num_triangles += mesh->triangles.size();
  setStatus(rviz::StatusProperty::Ok, "Mesh",
            QString("%1 blocks, %2 triangles").arg(reader_.blocks().size()).arg(num_triangles));
}

}  // namespace tsg::rviz_plugin

PLUGINLIB_EXPORT_CLASS(tsg::rviz_plugin::MeshDisplay, rviz::Display)
