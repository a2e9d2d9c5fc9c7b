// SPDX-License-Identifier: BSD-3-Clause
#include "rgbd_faults.h"

#include <cmath>
#include <random>

namespace tsg::test {
namespace {

template <typename Change>
RgbdWalk changePoses(RgbdWalk walk, const Change& change) {
  for (RgbdFrame& frame : walk) frame.T_world_camera = change(frame.T_world_camera);
  return walk;
}

/// Replaces every depth image by float metres; `change(frame, depth_m)` writes into it.
template <typename Change>
RgbdWalk changeDepth(RgbdWalk walk, const Change& change) {
  for (RgbdFrame& frame : walk) {
    cv::Mat depth_m(frame.depth.image.size(), CV_32FC1);
    for (int v = 0; v < depth_m.rows; ++v) {
      for (int u = 0; u < depth_m.cols; ++u) depth_m.at<float>(v, u) = frame.depth.at(u, v);
    }
    change(frame, depth_m);
    frame.depth.image = depth_m;
    frame.depth.metres_per_unit = 1.0;
  }
  return walk;
}

}  // namespace

RgbdWalk withInversePoses(RgbdWalk walk) {
  return changePoses(std::move(walk), [](const Pose& T) { return T.inverse(Eigen::Isometry); });
}

RgbdWalk withFrame(RgbdWalk walk, const Eigen::Matrix3d& R_optical_frame) {
  Pose T_optical_frame = Pose::Identity();
  T_optical_frame.linear() = R_optical_frame;
  return changePoses(std::move(walk), [&](const Pose& T) { return T * T_optical_frame; });
}

RgbdWalk withOpenglAxes(RgbdWalk walk) {
  return withFrame(std::move(walk), Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal());
}

RgbdWalk withBodyAxes(RgbdWalk walk) {
  Eigen::Matrix3d R_optical_body;
  R_optical_body << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return withFrame(std::move(walk), R_optical_body);
}

RgbdWalk withMirroredWorld(RgbdWalk walk) {
  const Eigen::Matrix3d M = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal();
  return changePoses(std::move(walk), [&](Pose T) {
    T.linear() = M * T.linear() * M;
    T.translation() = M * T.translation();
    return T;
  });
}

RgbdWalk withTranslationsTimes(RgbdWalk walk, double factor) {
  return changePoses(std::move(walk), [&](Pose T) {
    T.translation() *= factor;
    return T;
  });
}

RgbdWalk withDepthTimes(RgbdWalk walk, double factor) {
  for (RgbdFrame& frame : walk) frame.depth.metres_per_unit *= factor;
  return walk;
}

RgbdWalk withFocalLengthTimes(RgbdWalk walk, double factor) {
  for (RgbdFrame& frame : walk) {
    frame.camera.fx_px *= factor;
    frame.camera.fy_px *= factor;
  }
  return walk;
}

RgbdWalk withRayDistances(RgbdWalk walk) {
  return changeDepth(std::move(walk), [](const RgbdFrame& frame, cv::Mat& depth_m) {
    for (int v = 0; v < depth_m.rows; ++v) {
      for (int u = 0; u < depth_m.cols; ++u) {
        depth_m.at<float>(v, u) *= static_cast<float>(frame.camera.unproject(u, v, 1.0).norm());
      }
    }
  });
}

RgbdWalk withUnregisteredDepth(RgbdWalk walk, double baseline_m) {
  return changeDepth(std::move(walk), [&](const RgbdFrame& frame, cv::Mat& depth_m) {
    const cv::Mat before = depth_m.clone();
    depth_m.setTo(0.0F);
    for (int v = 0; v < depth_m.rows; ++v) {
      for (int u = 0; u < depth_m.cols; ++u) {
        const float z_m = before.at<float>(v, u);
        if (!(z_m > 0.0F)) continue;
        const int to_px = static_cast<int>(std::lround(u - frame.camera.fx_px * baseline_m / z_m));
        if (to_px < 0 || to_px >= depth_m.cols) continue;
        float& seen_m = depth_m.at<float>(v, to_px);
        if (seen_m == 0.0F || z_m < seen_m) seen_m = z_m;
      }
    }
  });
}

RgbdWalk withLatePoses(const RgbdWalk& walk, int num_frames) {
  RgbdWalk late(walk.begin() + num_frames, walk.end());
  for (std::size_t i = 0; i < late.size(); ++i) late[i].T_world_camera = walk[i].T_world_camera;
  return late;
}

RgbdWalk withPoseNoise(RgbdWalk walk, double sigma_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sigma_m);
  const auto draw = [&] {
    const double x = normal(random);
    const double y = normal(random);
    return Eigen::Vector3d(x, y, normal(random));
  };
  return changePoses(std::move(walk), [&](Pose T) {
    T.translation() += draw();
    const Eigen::Vector3d turn_rad = 0.5 * draw();
    T.rotate(Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()));
    return T;
  });
}

RgbdWalk withFrozenDepth(RgbdWalk walk) {
  for (RgbdFrame& frame : walk) frame.depth = walk.front().depth;
  return walk;
}

RgbdWalk withConstantPose(RgbdWalk walk) {
  const Pose T = walk.front().T_world_camera;
  return changePoses(std::move(walk), [&](const Pose&) { return T; });
}

RgbdWalk withConstantDepth(RgbdWalk walk, float z_m) {
  return changeDepth(std::move(walk),
                     [&](const RgbdFrame&, cv::Mat& depth_m) { depth_m.setTo(z_m); });
}

RgbdWalk withoutMostDepth(RgbdWalk walk) {
  return changeDepth(std::move(walk), [](const RgbdFrame&, cv::Mat& depth_m) {
    depth_m.rowRange(depth_m.rows / 50, depth_m.rows).setTo(0.0F);
  });
}

RgbdWalk withBlackColor(RgbdWalk walk) {
  for (RgbdFrame& frame : walk) {
    frame.color.image = cv::Mat::zeros(frame.color.image.size(), CV_8UC3);
  }
  return walk;
}

RgbdWalk withPerson(RgbdWalk walk, double share) {
  int i = 0;
  return changeDepth(std::move(walk), [&](const RgbdFrame&, cv::Mat& depth_m) {
    const int width_px = static_cast<int>(share * depth_m.cols);
    const double place = 0.5 + 0.5 * std::sin(0.13 * i);
    const int left_px = static_cast<int>(place * (depth_m.cols - width_px));
    depth_m.colRange(left_px, left_px + width_px).setTo(0.9 + 0.3 * std::sin(0.07 * i));
    ++i;
  });
}

RgbdWalk inWorld(RgbdWalk walk, const Eigen::Matrix3d& R_new_world) {
  Pose T_new_world = Pose::Identity();
  T_new_world.linear() = R_new_world;
  return changePoses(std::move(walk), [&](const Pose& T) { return T_new_world * T; });
}

}  // namespace tsg::test
