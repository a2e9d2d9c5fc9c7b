// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <OgreMaterial.h>

#include <string>
#include <vector>

#include "task_scene_graph/core/mesh.h"

namespace Ogre {
class ManualObject;
class SceneManager;
class SceneNode;
}  // namespace Ogre

namespace tsg::rviz_plugin {

enum class ColorBy { kCamera, kShape, kHeight };

struct MeshStyle {
  ColorBy color_by = ColorBy::kCamera;
  float alpha = 1.0F;
};

/// The material of all chunks of one display: unlit, with the colours of the vertices.
class MeshMaterial {
 public:
  MeshMaterial();
  ~MeshMaterial();
  MeshMaterial(const MeshMaterial&) = delete;
  MeshMaterial& operator=(const MeshMaterial&) = delete;

  void setTransparent(bool is_transparent);
  void setBackFaces(bool are_shown);
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  Ogre::MaterialPtr material_;
};

/// Some blocks of the mesh as one thing to draw.
class MeshChunkVisual {
 public:
  MeshChunkVisual(Ogre::SceneManager& manager, Ogre::SceneNode& parent);
  ~MeshChunkVisual();
  MeshChunkVisual(const MeshChunkVisual&) = delete;
  MeshChunkVisual& operator=(const MeshChunkVisual&) = delete;

  /// Replaces what was drawn. O(vertices + triangles).
  void draw(const std::vector<const Mesh*>& meshes, const MeshStyle& style,
            const std::string& material);

 private:
  Ogre::SceneManager& manager_;
  Ogre::SceneNode* node_;
  Ogre::ManualObject* object_;
};

}  // namespace tsg::rviz_plugin
