// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace tsg::simulation {

/// RGB, each in [0, 1].
using Color = Eigen::Vector3f;

enum class Pattern {
  kPlain,
  kWood,     ///< grain along the first texture axis
  kPlanks,   ///< boards `scale_m` wide with gaps
  kTiles,    ///< squares of `scale_m` with joints of the second colour
  kStripes,  ///< bands of both colours, `scale_m` wide
  kFabric,   ///< fine irregular speckle
  kPicture,  ///< a landscape
  kSky,      ///< what is seen through a window
  kWall      ///< the paint of the room that the surface faces, with a skirting board
};

struct Material {
  Color color{0.8F, 0.8F, 0.8F};
  Color second{0.3F, 0.3F, 0.3F};
  Pattern pattern = Pattern::kPlain;
  float scale_m = 0.1F;
  float glow = 0.0F;  ///< share of the colour that needs no light, in [0, 1]
};

/// Colour of the surface before lighting. `p_m`: point in the solid's frame, metres; `normal`: unit
/// normal in the same frame, which picks the two texture axes. kWall gives `material.color`.
Color computeAlbedo(const Material& material, const Eigen::Vector3d& p_m,
                    const Eigen::Vector3d& normal);

/// Smooth noise in [0, 1] with cells of size 1, the same on every platform.
float computeNoise(double x, double y);

}  // namespace tsg::simulation
