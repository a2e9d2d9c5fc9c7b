// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "task_scene_graph/mapping/depth_buffer.h"
#include "task_scene_graph/mapping/object_reconstructor.h"
#include "task_scene_graph/mapping/tsdf_volume.h"
#include "tsdf_kernel.h"

namespace tsg::mapping {

/// Rectangle of the pixels with this label; empty if there is none.
cv::Rect findLabel(const cv::Mat& labels, std::uint16_t segment);

/// One frame in which an object was seen, cut down to the object's surroundings. Shares the images.
struct ObjectView {
  /// @throws std::invalid_argument if the label image has another size or type than expected.
  ObjectView(const RgbdFrame& frame_in, const cv::Mat& labels_in, std::uint16_t segment_in);

  /// Depth where the pixel has the object's label, 0 elsewhere.
  DepthImage computeMaskedDepth() const;

  /// Cuts the images down to what the box, grown by `margin_m`, projects to.
  void cropTo(const Aabb& box, double margin_m);

  RgbdFrame frame;
  cv::Mat labels;
  std::uint16_t segment;

 private:
  void crop(const cv::Rect& rect);
};

/// Box of the 3D points of the object's pixels, world frame. Views with fewer than min_pixels valid
/// readings on the object are removed; the box is empty if none is left.
Aabb computeExtent(const ObjectConfig& config, std::vector<ObjectView>& views);

/// TSDF of one object with a count of labels per voxel.
class ObjectVolume {
 public:
  ObjectVolume(const ObjectConfig& config, double voxel_size_m);

  double truncation() const { return config_.truncation_voxels * tsdf_.voxelSize(); }
  const TsdfVolume& tsdf() const { return tsdf_; }

  /// Makes the blocks that the truncation band of the object's pixels meets.
  void allocate(const ObjectView& view);
  /// Integrates all pixels of the view into the blocks there are.
  void integrate(const ObjectView& view);
  /// Turns voxels that are not the object's into free space.
  void removeBackground();

 private:
  struct LabelCounts {
    std::array<std::uint16_t, kBlockVoxels> object{};
    std::array<std::uint16_t, kBlockVoxels> other{};
  };

  void assignDepth(const DepthImage& depth, int tile_px);
  void countLabels(const ObjectView& view, const SliceView& slice, const SliceUpdate& update,
                   std::size_t first_voxel, LabelCounts& counts) const;

  ObjectConfig config_;
  TsdfVolume tsdf_;
  std::vector<TsdfBlock*> blocks_;
  std::vector<LabelCounts> counts_;  ///< one per block
  DepthBuffer depth_;
};

}  // namespace tsg::mapping
