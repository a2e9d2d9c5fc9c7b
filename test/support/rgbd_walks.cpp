// SPDX-License-Identifier: BSD-3-Clause
#include "rgbd_walks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sequence.h"
#include "synthetic_scene.h"
#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/depth_noise.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/variation.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::test {
namespace {

std::vector<Solid> makeBoxRoom() {
  return {makePlane({0, 0, 0}, {0, 0, 1}, {120, 120, 110}),
          makePlane({0, 0, 2.5}, {0, 0, -1}, {230, 230, 230}),
          makePlane({3, 0, 0}, {-1, 0, 0}, {200, 190, 170}),
          makePlane({-3, 0, 0}, {1, 0, 0}, {170, 190, 200}),
          makePlane({0, 3, 0}, {0, -1, 0}, {190, 170, 150}),
          makePlane({0, -3, 0}, {0, 1, 0}, {180, 200, 170})};
}

Pose computeBoxRoomPose(BoxRoomMotion motion, int i) {
  switch (motion) {
    case BoxRoomMotion::kForward:
      return lookAt({-1.6 + 0.02 * i, 0.1, 1.3}, {3.0, 0.1, 1.2});
    case BoxRoomMotion::kTurning:
      return lookAt({0.0, 0.0, 1.3}, {std::cos(0.02 * i), std::sin(0.02 * i), 1.2});
    case BoxRoomMotion::kSideways:
      return lookAt({-1.5, -0.4 + 0.02 * i, 1.3}, {3.0, -0.4 + 0.02 * i, 1.2});
    case BoxRoomMotion::kMixed:
      return lookAt({-1.5 + 0.01 * i, -0.4 + 0.01 * i, 1.3},
                    {3.0 * std::cos(0.01 * i), 3.0 * std::sin(0.01 * i), 1.0});
    case BoxRoomMotion::kCircle:
      return lookAt({0.5 * std::cos(0.05 * i), 0.5 * std::sin(0.05 * i), 1.3},
                    {2.0 * std::cos(0.05 * i + 0.3), 2.0 * std::sin(0.05 * i + 0.3), 1.0});
    case BoxRoomMotion::kStill:
      break;
  }
  return lookAt({0.0, 0.0, 1.3}, {3.0, 0.2, 1.0});
}

/// Every `step`-th pixel of depth, colour averaged over as many.
RgbdFrame shrink(const RgbdFrame& frame, int step_px) {
  RgbdFrame small = frame;
  const int width_px = frame.camera.width_px / step_px;
  const int height_px = frame.camera.height_px / step_px;
  const int offset_px = step_px / 2;
  small.depth.image = cv::Mat(height_px, width_px, frame.depth.image.type());
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      small.depth.image.at<std::uint16_t>(v, u) =
          frame.depth.image.at<std::uint16_t>(offset_px + v * step_px, offset_px + u * step_px);
    }
  }
  cv::resize(frame.color.image, small.color.image, small.depth.image.size(), 0, 0, cv::INTER_AREA);
  small.camera = {width_px,
                  height_px,
                  frame.camera.fx_px / step_px,
                  frame.camera.fy_px / step_px,
                  (frame.camera.cx_px - offset_px) / step_px,
                  (frame.camera.cy_px - offset_px) / step_px};
  return small;
}

}  // namespace

RgbdWalk makeBoxRoomWalk(BoxRoomMotion motion, int num_frames) {
  const auto room = makeBoxRoom();
  const CameraModel camera{160, 120, 131.0, 131.0, 79.5, 59.5};
  RgbdWalk walk;
  for (int i = 0; i < num_frames; ++i) {
    walk.push_back(render(room, camera, computeBoxRoomPose(motion, i)).frame);
    walk.back().stamp = Stamp::fromSeconds(100.0 + 0.1 * i);
  }
  return walk;
}

RgbdWalk makeApartmentWalk(int seed, int width_px, int first_frame, int num_frames) {
  const auto apartment = simulation::buildApartment({seed, 6});
  const auto poses = simulation::planWalk(apartment, simulation::WalkConfig{});
  const simulation::Renderer renderer(apartment, 2);
  const CameraModel camera = simulation::makeDefaultCamera(width_px, width_px * 3 / 4);
  RgbdWalk walk;
  const int end = std::min(first_frame + num_frames, static_cast<int>(poses.size()));
  for (int i = first_frame; i < end; ++i) {
    const auto& pose = poses[static_cast<std::size_t>(i)];
    const auto view = renderer.render(camera, pose.T_world_camera);
    RgbdFrame frame;
    frame.stamp = pose.stamp;
    frame.camera = camera;
    frame.T_world_camera = pose.T_world_camera;
    frame.color.image = view.color;
    frame.depth.image = simulation::simulateDepthSensor(view.depth_m, camera, {},
                                                        static_cast<std::uint64_t>(seed), i, 2);
    walk.push_back(frame);
  }
  return walk;
}

RgbdWalk loadWalk(const std::filesystem::path& folder, int num_frames, double rate_hz, int stride,
                  int width_px) {
  RgbdWalk walk;
  for (int i = 0; i < num_frames; i += stride) {
    const RgbdFrame frame = loadSequenceFrame(folder, i);
    walk.push_back(
        width_px < frame.camera.width_px ? shrink(frame, frame.camera.width_px / width_px) : frame);
    walk.back().stamp = Stamp::fromSeconds(100.0 + i / rate_hz);
  }
  return walk;
}

RgbdWalk cut(const RgbdWalk& walk, std::size_t first, std::size_t count) {
  const auto from = walk.begin() + static_cast<std::ptrdiff_t>(std::min(first, walk.size()));
  const auto left = static_cast<std::size_t>(walk.end() - from);
  return {from, from + static_cast<std::ptrdiff_t>(std::min(count, left))};
}

}  // namespace tsg::test
