// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/mesh.h"
#include "task_scene_graph/core/primitives.h"
#include "task_scene_graph/ros/messages.h"

/// Core types <-> messages. `toMessage` of the result of `fromMessage` gives the message back, and
/// the other way round. All functions are pure and linear in the size of their input.
namespace tsg::ros_interface {

std::vector<float> toFloats(const Embedding& embedding);
Embedding toEmbedding(const std::vector<float>& values);

/// The label image borrows the message's pixels. @throws InputError naming `topic` if labels are
/// not 16UC1, array lengths do not fit or a label has no row.
SegmentationPtr fromMessage(const msg::SegmentationConstPtr& message, const std::string& topic);
/// One copy of the label image. `frame`: the camera's optical frame.
msg::SegmentationPtr toMessage(const Segmentation& segmentation, const std::string& frame);

TrackedFrame fromMessage(const msg::Tracks& message);
msg::TracksPtr toMessage(const TrackedFrame& tracked, const std::string& frame);

/// @throws InputError if array lengths do not fit or a triangle names a vertex that is not there.
Mesh fromMessage(const msg::Mesh& message);
msg::Mesh toMessage(const Mesh& mesh);

/// @throws InputError for a broken mesh.
ObjectPrimitivePtr fromMessage(const msg::ObjectPrimitive& message);
/// All of a message. @throws InputError naming `topic` and the primitive that is broken: its mesh,
/// thumbnail, a box's rotation, or a box that is not finite or reaches beyond 1e9 m.
std::vector<ObjectPrimitivePtr> fromMessage(const msg::ObjectPrimitives& message,
                                            const std::string& topic);
msg::ObjectPrimitive toMessage(const ObjectPrimitive& primitive);
msg::ObjectPrimitivesPtr toMessage(const std::vector<ObjectPrimitivePtr>& primitives, Stamp stamp,
                                   const std::string& world_frame);

/// rgb8; an empty message for an empty image.
sensor_msgs::Image toThumbnailMessage(const ColorImage& thumbnail);

msg::Place toMessage(const Place& place);
msg::PlaceEdge toMessage(const PlaceEdge& edge);
/// @param former  a graph of before, places ascending by id: embeddings that have not changed since
/// are shared with it
PlaceGraphPtr fromMessage(const msg::PlaceGraph& message, const PlaceGraph& former = {});
/// The same, checked. @throws InputError naming `topic` and the place whose position or clearance
/// is not finite, or beyond 1e9 m.
PlaceGraphPtr fromMessage(const msg::PlaceGraph& message, const std::string& topic,
                          const PlaceGraph& former = {});
msg::PlaceGraphPtr toMessage(const PlaceGraph& graph, const std::string& world_frame);

}  // namespace tsg::ros_interface
