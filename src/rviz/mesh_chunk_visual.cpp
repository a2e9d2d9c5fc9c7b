// SPDX-License-Identifier: BSD-3-Clause
#include "mesh_chunk_visual.h"

#include <OgreManualObject.h>
#include <OgreMaterialManager.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTechnique.h>

#include <Eigen/Geometry>

#include "task_scene_graph/ros/occupancy_conversions.h"

namespace tsg::rviz_plugin {
namespace {

const std::string& resourceGroup() {
  return Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME;
}

/// One normal per vertex, weighted by the areas of its triangles; not of unit length.
std::vector<Eigen::Vector3f> computeNormals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f& corner = mesh.vertices[t[0]];
    const Eigen::Vector3f normal =
        (mesh.vertices[t[1]] - corner).cross(mesh.vertices[t[2]] - corner);
    for (const auto index : t) normals[index] += normal;
  }
  return normals;
}

/// Light grey, darker the more the surface turns away from a lamp above.
Ogre::ColourValue colorOfNormal(const Eigen::Vector3f& normal) {
  static const Eigen::Vector3f lamp = Eigen::Vector3f(0.35F, 0.2F, 0.9F).normalized();
  const float length = normal.norm();
  const float facing = length > 0.0F ? normal.dot(lamp) / length : 0.0F;
  const float grey = 0.55F + 0.35F * facing;
  return Ogre::ColourValue(grey, grey, grey);
}

Ogre::ColourValue toColour(const std_msgs::ColorRGBA& color) {
  return Ogre::ColourValue(color.r, color.g, color.b);
}

void addVertices(const Mesh& mesh, const MeshStyle& style, Ogre::ManualObject& object) {
  std::vector<Eigen::Vector3f> normals;
  if (style.color_by == ColorBy::kShape) normals = computeNormals(mesh);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f& vertex = mesh.vertices[i];
    object.position(vertex.x(), vertex.y(), vertex.z());
    const auto& rgb = mesh.colors[i];
    Ogre::ColourValue color(static_cast<float>(rgb[0]) / 255.0F,
                            static_cast<float>(rgb[1]) / 255.0F,
                            static_cast<float>(rgb[2]) / 255.0F);
    if (style.color_by == ColorBy::kShape) color = colorOfNormal(normals[i]);
    if (style.color_by == ColorBy::kHeight) {
      color = toColour(ros_interface::computeHeightColor(static_cast<double>(vertex.z())));
    }
    color.a = style.alpha;
    object.colour(color);
  }
}

}  // namespace

MeshMaterial::MeshMaterial() {
  static int count = 0;
  name_ = "task_scene_graph_mesh_" + std::to_string(count++);
  material_ = Ogre::MaterialManager::getSingleton().create(name_, resourceGroup());
  material_->setReceiveShadows(false);
  material_->setLightingEnabled(false);
  setBackFaces(false);
  setTransparent(false);
}

MeshMaterial::~MeshMaterial() {
  Ogre::MaterialManager::getSingleton().remove(material_->getHandle());
}

void MeshMaterial::setTransparent(bool is_transparent) {
  material_->setSceneBlending(is_transparent ? Ogre::SBT_TRANSPARENT_ALPHA : Ogre::SBT_REPLACE);
  material_->setDepthWriteEnabled(!is_transparent);
}

void MeshMaterial::setBackFaces(bool are_shown) {
  material_->setCullingMode(are_shown ? Ogre::CULL_NONE : Ogre::CULL_CLOCKWISE);
}

MeshChunkVisual::MeshChunkVisual(Ogre::SceneManager& manager, Ogre::SceneNode& parent)
    : manager_(manager),
      node_(parent.createChildSceneNode()),
      object_(manager.createManualObject()) {
  node_->attachObject(object_);
}

MeshChunkVisual::~MeshChunkVisual() {
  manager_.destroyManualObject(object_);
  manager_.destroySceneNode(node_);
}

void MeshChunkVisual::draw(const std::vector<const Mesh*>& meshes, const MeshStyle& style,
                           const std::string& material) {
  object_->clear();
  std::size_t num_vertices = 0;
  std::size_t num_triangles = 0;
  for (const Mesh* mesh : meshes) {
    num_vertices += mesh->vertices.size();
    num_triangles += mesh->triangles.size();
  }
  if (num_triangles == 0) return;
  object_->estimateVertexCount(num_vertices);
  object_->estimateIndexCount(3 * num_triangles);
  object_->begin(material, Ogre::RenderOperation::OT_TRIANGLE_LIST, resourceGroup());
  std::uint32_t offset = 0;
  for (const Mesh* mesh : meshes) {
    addVertices(*mesh, style, *object_);
    for (const auto& t : mesh->triangles) {
      object_->triangle(t[0] + offset, t[1] + offset, t[2] + offset);
    }
    offset += static_cast<std::uint32_t>(mesh->vertices.size());
  }
  object_->end();
}

}  // namespace tsg::rviz_plugin
