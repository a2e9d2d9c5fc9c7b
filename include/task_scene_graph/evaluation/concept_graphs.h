// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "task_scene_graph/config/visitor.h"
#include "task_scene_graph/core/frame.h"
#include "task_scene_graph/core/oriented_box.h"

namespace tsg::evaluation {

/// The values that the method's own description of its use gives.
struct ConceptGraphsConfig {
  int min_pixels = 25;
  double max_image_share = 0.5;
  double voxel_size_m = 0.025;
  double cluster_radius_m = 0.1;
  int cluster_min_points = 10;
  double min_similarity = 1.2;
  int denoise_interval = 20;
  int merge_interval = 20;
  double merge_overlap = 0.7;
  double merge_cosine = 0.8;
  int min_detections = 3;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("min_pixels", self.min_pixels, {1, 1000000}, "px", "smaller masks are no detections");
    v.field("max_image_share", self.max_image_share, {0.0, 1.0}, "",
            "masks that cover more of the image are none");
    v.field("voxel_size_m", self.voxel_size_m, {0.001, 1.0}, "m",
            "of the clouds; points nearer than this count as shared");
    v.field("cluster_radius_m", self.cluster_radius_m, {0.001, 10.0}, "m", "of DBSCAN");
    v.field("cluster_min_points", self.cluster_min_points, {1, 100000}, "", "of DBSCAN");
    v.field("min_similarity", self.min_similarity, {-1.0, 2.0}, "",
            "overlap plus cosine at which a detection belongs to an object");
    v.field("denoise_interval", self.denoise_interval, {0, 1000000}, "frames",
            "every so often each cloud keeps its largest cluster only; 0: at the end");
    v.field("merge_interval", self.merge_interval, {0, 1000000}, "frames",
            "every so often objects that overlap become one; 0: at the end");
    v.field("merge_overlap", self.merge_overlap, {0.0, 1.0}, "",
            "share of an object's points in the other, above which");
    v.field("merge_cosine", self.merge_cosine, {-1.0, 1.0}, "", "and cosine, above which");
    v.field("min_detections", self.min_detections, {1, 1000000}, "",
            "objects seen less often are left out at the end");
  }
};

struct ConceptObject {
  std::vector<Eigen::Vector3f> points_m;  ///< world frame
  OrientedBox box;
  Embedding embedding;  ///< mean of its detections', of unit length
  std::size_t num_detections = 0;
  Stamp first_seen;
  Stamp last_seen;
};

/// ConceptGraphs' mapping (Gu et al., ICRA 2024), the paper's baseline "CG": each detection joins
/// the object to which its points' overlap plus its embedding's cosine is largest; objects are
/// point clouds, cleaned and merged from time to time. deviation: no noise of 4 mm on the points;
/// upright boxes instead of Open3D's robust ones; detections have no class, so that the similarity
/// of class names is left out, and no confidence; masks do not overlap, so none is subtracted.
class ConceptGraphs {
 public:
  /// @throws config::ConfigError naming every field out of range.
  explicit ConceptGraphs(const ConceptGraphsConfig& config);

  /// O(detections * objects whose boxes meet * points).
  void add(const RgbdFrame& frame, const Segmentation& segmentation);

  /// Cleans up once more and returns what was seen often enough.
  std::vector<ConceptObject> finish();

  const std::vector<ConceptObject>& objects() const { return objects_; }

 private:
  std::vector<ConceptObject> findDetections(const RgbdFrame& frame,
                                            const Segmentation& segmentation) const;
  /// Index of the object that it belongs to among the first `count`; `count` if none.
  std::size_t findObject(const ConceptObject& detection, std::size_t count) const;
  void fuse(const ConceptObject& from, ConceptObject& to) const;
  void denoise(ConceptObject& object) const;
  void denoiseAll();
  void mergeOverlapping();

  ConceptGraphsConfig config_;
  std::vector<ConceptObject> objects_;
  int num_frames_ = 0;
};

}  // namespace tsg::evaluation
