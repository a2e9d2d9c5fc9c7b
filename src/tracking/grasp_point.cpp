// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/tracking/grasp_point.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tsg::tracking {
namespace {

constexpr int kDepthRadius_px = 2;

void checkQuestion(const Embedding& question, Eigen::Index size) {
  if (question.size() != size) {
    throw std::invalid_argument("the question has an embedding of " +
                                std::to_string(question.size()) + " numbers, expected " +
                                std::to_string(size) + " as those of the segments have");
  }
  if (!question.allFinite() || question.isZero(0.0F)) {
    throw std::invalid_argument(
        "the question's embedding has no direction, expected finite numbers, not all 0");
  }
}

/// Sets segment, score and margin.
GraspPoint findBestSegment(const EmbeddingMatrix& embeddings, const Embedding& question) {
  std::vector<std::pair<double, int>> ranked;  // minus the score: equal ones by label
  for (Eigen::Index s = 0; s < embeddings.rows(); ++s) {
    if (embeddings.row(s).isZero(0.0F)) continue;  // not embedded in this image
    ranked.emplace_back(-computeCosine(embeddings.row(s).transpose(), question),
                        static_cast<int>(s) + 1);
  }
  if (ranked.empty()) {
    throw std::runtime_error("none of the " + std::to_string(embeddings.rows()) +
                             " segments of the newest image has an embedding");
  }
  std::partial_sort(ranked.begin(),
                    ranked.begin() + std::min<std::ptrdiff_t>(2, ranked.end() - ranked.begin()),
                    ranked.end());
  GraspPoint best;
  best.segment = static_cast<std::uint16_t>(ranked[0].second);
  best.score = -ranked[0].first;
  if (ranked.size() > 1) best.margin = ranked[1].first - ranked[0].first;
  return best;
}

std::vector<cv::Point> listPixels(const cv::Mat& labels, std::uint16_t segment) {
  std::vector<cv::Point> pixels;
  for (int v = 0; v < labels.rows; ++v) {
    const auto* row = labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < labels.cols; ++u) {
      if (row[u] == segment) pixels.emplace_back(u, v);
    }
  }
  return pixels;
}

/// That of `pixels` nearest to their centroid; the first of equal ones.
cv::Point findCentralPixel(const std::vector<cv::Point>& pixels) {
  cv::Point2d sum(0.0, 0.0);
  for (const auto& p : pixels) sum += cv::Point2d(p);
  const cv::Point2d centroid = sum / static_cast<double>(pixels.size());
  const auto distance = [&](const cv::Point& p) {
    const cv::Point2d d = cv::Point2d(p) - centroid;
    return d.dot(d);
  };
  return *std::min_element(pixels.begin(), pixels.end(),
                           [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
}

/// Median over the segment's pixels round `center`; 0 if none has a depth.
double computeDepth_m(const DepthImage& depth, const cv::Mat& labels, std::uint16_t segment,
                      const cv::Point& center) {
  std::vector<float> depths_m;
  const cv::Rect window = cv::Rect(center.x - kDepthRadius_px, center.y - kDepthRadius_px,
                                   2 * kDepthRadius_px + 1, 2 * kDepthRadius_px + 1) &
                          cv::Rect({0, 0}, labels.size());
  for (int v = window.y; v < window.y + window.height; ++v) {
    for (int u = window.x; u < window.x + window.width; ++u) {
      if (labels.ptr<std::uint16_t>(v)[u] != segment) continue;
      const float depth_m = depth.at(u, v);
      if (depth_m > 0.0F) depths_m.push_back(depth_m);
    }
  }
  if (depths_m.empty()) return 0.0;
  const auto middle = depths_m.begin() + static_cast<std::ptrdiff_t>(depths_m.size() / 2);
  std::nth_element(depths_m.begin(), middle, depths_m.end());
  return static_cast<double>(*middle);
}

std::string explainMissingDepth(const DepthImage& depth, const std::vector<cv::Point>& pixels,
                                const GraspPoint& grasp) {
  const auto count = std::count_if(pixels.begin(), pixels.end(),
                                   [&](const auto& p) { return depth.at(p.x, p.y) > 0.0F; });
  return "no depth at pixel (" + std::to_string(grasp.u_px) + ", " + std::to_string(grasp.v_px) +
         ") nor beside it, the middle of the segment that fits best (label " +
         std::to_string(grasp.segment) + "): " + std::to_string(count) + " of its " +
         std::to_string(pixels.size()) + " pixels have one; look from elsewhere";
}

}  // namespace

GraspPoint findGraspPoint(const RgbdFrame& frame, const Segmentation& segmentation,
                          const Embedding& question) {
  if (segmentation.embeddings.rows() == 0) {
    throw std::runtime_error("the newest image has no segments");
  }
  checkQuestion(question, segmentation.embeddings.cols());
  GraspPoint grasp = findBestSegment(segmentation.embeddings, question);
  const std::vector<cv::Point> pixels = listPixels(segmentation.labels, grasp.segment);
  if (pixels.empty()) {
    throw std::runtime_error("the segment that fits best (label " + std::to_string(grasp.segment) +
                             ") has no pixels in the registered image");
  }
  const cv::Point center = findCentralPixel(pixels);
  grasp.num_pixels = static_cast<std::uint32_t>(pixels.size());
  grasp.u_px = center.x;
  grasp.v_px = center.y;
  const double depth_m = computeDepth_m(frame.depth, segmentation.labels, grasp.segment, center);
  if (depth_m <= 0.0) throw std::runtime_error(explainMissingDepth(frame.depth, pixels, grasp));
  grasp.p_camera = frame.camera.unproject(center.x, center.y, depth_m);
  grasp.p_world = frame.T_world_camera * grasp.p_camera;
  return grasp;
}

}  // namespace tsg::tracking
