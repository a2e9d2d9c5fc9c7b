// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/subscriber.h>
#include <rviz/display.h>

#include <map>
#include <memory>
#include <set>

#include "mesh_chunk_visual.h"
#include "task_scene_graph/ros/mesh_update_conversions.h"

namespace rviz {
class BoolProperty;
class EnumProperty;
class FloatProperty;
class RosTopicProperty;
}  // namespace rviz

namespace tsg::rviz_plugin {

/// The background mesh in rviz, from MeshUpdate messages: only chunks that changed are built again.
/// Where a message was lost it subscribes anew, and is sent the whole mesh. Disabled, it keeps
/// nothing.
class MeshDisplay : public rviz::Display {
  Q_OBJECT
 public:
  MeshDisplay();
  ~MeshDisplay() override;

  void update(float wall_dt, float ros_dt) override;
  void reset() override;
  void setTopic(const QString& topic, const QString& datatype) override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void onTopicChanged();
  void onStyleChanged();

 private:
  using Index = mapping::GridIndex;
  using Order = ros_interface::BlockOrder;

  void subscribe();
  void unsubscribe();
  void clear();
  void onMessage(const msg::MeshUpdateConstPtr& message);
  void takeIn(const msg::MeshUpdate& message);
  void placeInFixedFrame();
  void drawDirtyChunks();
  void drawChunk(const Index& chunk);
  void showCounts();

  rviz::RosTopicProperty* topic_;
  rviz::EnumProperty* color_by_;
  rviz::FloatProperty* alpha_;
  rviz::BoolProperty* back_faces_;

  ros::Subscriber subscriber_;
  bool must_resubscribe_ = false;
  std::string frame_;
  std::size_t num_messages_ = 0;
  ros_interface::MeshUpdateReader reader_;
  std::unique_ptr<MeshMaterial> material_;
  std::map<Index, std::unique_ptr<MeshChunkVisual>, Order> chunks_;
  std::set<Index, Order> dirty_;  ///< chunks that are not drawn as they are now
};

}  // namespace tsg::rviz_plugin
