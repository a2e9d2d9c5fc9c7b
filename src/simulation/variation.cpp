// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/variation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "task_scene_graph/simulation/floor_map.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/walk.h"

namespace tsg::simulation {
namespace {

constexpr int kTriesPerView = 6;
constexpr double kViewClearance_m = 0.25;

/// Hue in [0, 6), saturation and value in [0, 1].
struct Hsv {
  float hue = 0.0F;
  float saturation = 0.0F;
  float value = 0.0F;
};

Hsv toHsv(const Color& c) {
  Hsv result;
  int largest = 0;
  result.value = c.maxCoeff(&largest);
  const float spread = result.value - c.minCoeff();
  if (result.value <= 0.0F || spread <= 0.0F) return result;
  result.saturation = spread / result.value;
  const int next = (largest + 1) % 3;
  const int after = (largest + 2) % 3;
  result.hue =
      std::fmod(2.0F * static_cast<float>(largest) + (c[next] - c[after]) / spread + 6.0F, 6.0F);
  return result;
}

Color toRgb(const Hsv& hsv) {
  Color rgb;
  for (int i = 0; i < 3; ++i) {
    const float k = std::fmod(5.0F - 2.0F * static_cast<float>(i) + hsv.hue, 6.0F);
    rgb[i] = hsv.value * (1.0F - hsv.saturation * std::clamp(std::min(k, 4.0F - k), 0.0F, 1.0F));
  }
  return rgb;
}

float draw(Random& random, double low, double high) {
  return static_cast<float>(random.uniform(low, high));
}

/// What is added to a hue (in sixths of a turn) and what saturation and value are multiplied with.
Hsv drawShift(Random& random) {
  return {draw(random, -0.11, 0.11), draw(random, 0.82, 1.15), draw(random, 0.85, 1.12)};
}

Color shiftColor(const Color& color, const Hsv& shift) {
  Hsv hsv = toHsv(color);
  hsv.hue = std::fmod(hsv.hue + shift.hue + 6.0F, 6.0F);
  hsv.saturation = std::min(1.0F, hsv.saturation * shift.saturation);
  hsv.value = std::min(1.0F, hsv.value * shift.value);
  return toRgb(hsv);
}

Material drawFloor(SurfaceSet set, Random& random) {
  Material floor;
  const bool training = set == SurfaceSet::kTraining;
  constexpr Pattern kTrainingPatterns[] = {Pattern::kPlanks, Pattern::kTiles, Pattern::kFabric};
  constexpr Pattern kHeldOutPatterns[] = {Pattern::kStripes, Pattern::kWood};
  floor.pattern =
      training ? kTrainingPatterns[random.integer(3)] : kHeldOutPatterns[random.integer(2)];
  const bool is_wood = floor.pattern == Pattern::kPlanks || floor.pattern == Pattern::kWood;
  floor.color =
      is_wood ? toRgb({draw(random, 0.35, 0.65), draw(random, 0.3, 0.6), draw(random, 0.4, 0.8)})
              : toRgb({draw(random, 0.0, 6.0), draw(random, 0.0, 0.2), draw(random, 0.4, 0.85)});
  floor.second = floor.color * draw(random, 0.55, 0.85);
  floor.scale_m = is_wood ? draw(random, 0.1, 0.2) : draw(random, 0.2, 0.5);
  return floor;
}

bool isFloor(const Solid& solid) {
  return solid.instance == 0 &&
         std::abs(solid.T_world_solid.translation().z() + solid.half_size_m.z()) < 1e-6;
}

/// True if a small picture from there shows at least two instances well.
bool showsThings(const Renderer& renderer, const Pose& T_world_camera) {
  const RenderedView view = renderer.render(makeDefaultCamera(64, 48), T_world_camera);
  std::map<std::uint16_t, int> pixels;
  for (int v = 0; v < view.labels.rows; ++v) {
    const auto* row = view.labels.ptr<std::uint16_t>(v);
    for (int u = 0; u < view.labels.cols; ++u) ++pixels[row[u]];
  }
  return std::count_if(pixels.begin(), pixels.end(), [](const auto& entry) {
           return entry.first != 0 && entry.second >= 8;
         }) >= 2;
}

}  // namespace

void varySurfaces(Apartment& apartment, SurfaceSet set, std::uint64_t seed) {
  Random random(combineSeeds(seed, hashText("surfaces")));
  const bool training = set == SurfaceSet::kTraining;
  for (Room& room : apartment.rooms) {
    room.wall_color = toRgb({draw(random, 0.0, 6.0),
                             training ? draw(random, 0.0, 0.14) : draw(random, 0.16, 0.24),
                             draw(random, 0.75, 0.97)});
  }
  std::vector<Hsv> shifts(apartment.instances.size() + 1);
  for (Hsv& shift : shifts) shift = drawShift(random);
  for (Solid& solid : apartment.solids) {
    if (isFloor(solid)) solid.material = drawFloor(set, random);
    if (solid.instance == 0) continue;
    solid.material.color = shiftColor(solid.material.color, shifts[solid.instance]);
    solid.material.second = shiftColor(solid.material.second, shifts[solid.instance]);
  }
}

std::vector<Pose> pickRandomViews(const Apartment& apartment, int count, Random& random) {
  const Renderer renderer(apartment, 1);
  const auto places = FloorMap(apartment).findReachable(apartment.rooms.front().interior_m.center(),
                                                        kViewClearance_m);
  std::vector<Pose> views;
  for (int tries = 0; tries < kTriesPerView * count && !places.empty(); ++tries) {
    if (static_cast<int>(views.size()) == count) break;
    const auto& place =
        places[static_cast<std::size_t>(random.integer(static_cast<int>(places.size())))];
    const double height_m = random.uniform(0.9, 1.7);
    const double yaw_rad = random.uniform(-kPi, kPi);
    const double pitch_down_rad = random.uniform(0.0, 0.6);
    const Pose view = makeCameraPose({place.x(), place.y(), height_m}, yaw_rad, pitch_down_rad);
    if (showsThings(renderer, view)) views.push_back(view);
  }
  return views;
}

CameraModel makeDefaultCamera(int width_px, int height_px) {
  CameraModel camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = 525.0 * width_px / 640.0;
  camera.fy_px = camera.fx_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

}  // namespace tsg::simulation
