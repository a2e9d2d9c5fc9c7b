// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/simulation/renderer.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "task_scene_graph/core/parallel.h"
#include "view_solids.h"

namespace tsg::simulation {
namespace {

constexpr double kShadeCell_m = 0.04;

std::uint8_t toByte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value * 255.0F + 0.5F, 0.0F, 255.0F));
}

/// 1 in the open, less close to the other walls, floor and ceiling: corners get little light.
float computeCornerShade(const Room& room, const Eigen::Vector3d& p_m,
                         const Eigen::Vector3d& normal) {
  const double z = room.floor_z_m;
  const Eigen::Vector3d low(room.interior_m.min().x(), room.interior_m.min().y(), z);
  const Eigen::Vector3d high(room.interior_m.max().x(), room.interior_m.max().y(),
                             z + room.height_m);
  double shade = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) > 0.5) continue;
    for (const double d : {p_m[axis] - low[axis], high[axis] - p_m[axis]}) {
      const double near = std::clamp(1.0 - d / 0.5, 0.0, 1.0);
      shade *= 1.0 - 0.22 * near * near;
    }
  }
  return static_cast<float>(shade);
}

}  // namespace

Renderer::Renderer(const Apartment& apartment, int num_threads)
    : apartment_(apartment), num_threads_(num_threads) {
  buildFloorShades();
}

void Renderer::buildFloorShades() {
  Rect outline;
  std::vector<double> heights_m(static_cast<std::size_t>(apartment_.countFloors()), 0.0);
  for (const Room& room : apartment_.rooms) {
    outline.extend(room.interior_m);
    heights_m[static_cast<std::size_t>(room.floor)] = room.floor_z_m;
  }
  floor_origin_m_ = outline.min();
  const Eigen::Vector2d size = outline.sizes() / kShadeCell_m;
  const cv::Size cells(static_cast<int>(size.x()) + 2, static_cast<int>(size.y()) + 2);
  for (const double z_m : heights_m) floor_shades_.push_back(makeFloorShade(cells, z_m));
}

cv::Mat Renderer::makeFloorShade(const cv::Size& cells, double floor_z_m) const {
  cv::Mat shade(cells, CV_32FC1, cv::Scalar(1.0));
  for (const Solid& solid : apartment_.solids) {
    const Aabb box = computeBounds(solid);
    const double low_m = box.min().z() - floor_z_m;
    const double high_m = box.max().z() - floor_z_m;
    if (solid.instance == 0 || low_m > 0.5 || high_m < 0.04) continue;
    const Eigen::Vector2d a = (box.min().head<2>() - floor_origin_m_) / kShadeCell_m;
    const Eigen::Vector2d b = (box.max().head<2>() - floor_origin_m_) / kShadeCell_m;
    cv::rectangle(shade, cv::Point(static_cast<int>(a.x()), static_cast<int>(a.y())),
                  cv::Point(static_cast<int>(b.x()), static_cast<int>(b.y())), cv::Scalar(0.45),
                  cv::FILLED);
  }
  cv::blur(shade, shade, {5, 5});
  cv::blur(shade, shade, {5, 5});
  return shade;
}

float Renderer::computeFloorShade(const Eigen::Vector2d& p_m, int floor) const {
  const cv::Mat& shade = floor_shades_[static_cast<std::size_t>(floor)];
  const Eigen::Vector2d cell = (p_m - floor_origin_m_) / kShadeCell_m - Eigen::Vector2d(0.5, 0.5);
  const int x = static_cast<int>(std::floor(cell.x()));
  const int y = static_cast<int>(std::floor(cell.y()));
  if (x < 0 || y < 0 || x + 1 >= shade.cols || y + 1 >= shade.rows) return 1.0F;
  const auto u = static_cast<float>(cell.x() - x);
  const auto v = static_cast<float>(cell.y() - y);
  const float* top = shade.ptr<float>(y) + x;
  const float* bottom = shade.ptr<float>(y + 1) + x;
  return (top[0] * (1.0F - u) + top[1] * u) * (1.0F - v) +
         (bottom[0] * (1.0F - u) + bottom[1] * u) * v;
}

Color Renderer::shade(const Solid& solid, const Eigen::Vector3d& p, const Eigen::Vector3d& p_solid,
                      const Eigen::Vector3d& normal_solid, int& room_id) const {
  const Eigen::Vector3d normal = solid.T_world_solid.linear() * normal_solid;
  room_id = apartment_.findRoom(Eigen::Vector3d(p + 0.02 * normal));
  Color albedo = computeAlbedo(solid.material, p_solid, normal_solid);
  double floor_z_m = 0.0;
  int floor = 0;
  float light = (room_id > 0 ? 0.5F : 0.8F) + 0.12F * static_cast<float>(normal.z());
  if (room_id > 0) {
    const Room& room = apartment_.rooms[static_cast<std::size_t>(room_id - 1)];
    floor = room.floor;
    floor_z_m = room.floor_z_m;
    if (solid.material.pattern == Pattern::kWall) {
      albedo = p.z() - floor_z_m < 0.08 ? Color(0.96F, 0.96F, 0.95F) : room.wall_color;
    }
    // A lamp as long as the room less 1.2 m on each side: the point of it that is nearest.
    const Eigen::Vector2d reach = (0.5 * room.interior_m.sizes().array() - 1.2).max(0.0);
    const Eigen::Vector2d middle = room.interior_m.center();
    const Eigen::Vector2d lamp = p.head<2>().cwiseMax(middle - reach).cwiseMin(middle + reach);
    const Eigen::Vector3d to_lamp =
        Eigen::Vector3d(lamp.x(), lamp.y(), floor_z_m + room.height_m - 0.4) - p;
    const double distance = to_lamp.norm();
    const double lambert = std::max(0.0, normal.dot(to_lamp)) / distance;
    light += static_cast<float>(0.75 * lambert / (1.0 + 0.06 * distance * distance));
    if (solid.instance == 0) light *= computeCornerShade(room, p, normal);
  }
  if (p.z() - floor_z_m < 0.02 && normal.z() > 0.5) {
    light *= computeFloorShade(p.head<2>(), floor);
  }
  return albedo * (light * (1.0F - solid.material.glow) + solid.material.glow);
}

/// Renders the tiles of one view.
class TileRenderer {
 public:
  TileRenderer(const Renderer& renderer, const CameraModel& camera, const Pose& T_world_camera)
      : renderer_(renderer),
        camera_(camera),
        T_world_camera_(T_world_camera),
        solids_(renderer.apartment_.solids, camera, T_world_camera) {}

  /// Row `tile_y` of tiles; adds to `room_pixels`.
  void renderRow(int tile_y, RenderedView& view, std::vector<int>& room_pixels) const {
    cv::Mat winners(ViewSolids::kTile_px, camera_.width_px, CV_32SC1);
    const int v0 = tile_y * ViewSolids::kTile_px;
    const int v1 = std::min(v0 + ViewSolids::kTile_px, camera_.height_px);
    for (int v = v0; v < v1; ++v) {
      for (int u = 0; u < camera_.width_px; ++u) {
        winners.at<int>(v - v0, u) = renderPixel(u, v, view, room_pixels);
      }
    }
    for (int v = v0; v < v1; ++v) {
      for (int u = 0; u < camera_.width_px; ++u) smoothEdge(winners, u, v, v0, v1, view);
    }
  }

 private:
  struct Sample {
    ViewSolids::Hit hit;
    Color color{0.0F, 0.0F, 0.0F};
    int room = 0;
  };

  Sample cast(double u, double v, int tile_u, int tile_v) const {
    const Eigen::Vector3d direction = camera_.unproject(u, v, 1.0);
    Sample sample;
    sample.hit = solids_.cast(direction, tile_u, tile_v);
    if (sample.hit.index < 0) return sample;
    const Solid& solid = renderer_.apartment_.solids[static_cast<std::size_t>(sample.hit.index)];
    const Eigen::Vector3d p_unit = solids_.toUnit(sample.hit.index, sample.hit.depth_m * direction);
    const Eigen::Vector3d p_world = T_world_camera_ * (sample.hit.depth_m * direction);
    sample.color = renderer_.shade(solid, p_world, p_unit.cwiseProduct(solid.half_size_m),
                                   computeNormal(solid, p_unit), sample.room);
    return sample;
  }

  int renderPixel(int u, int v, RenderedView& view, std::vector<int>& room_pixels) const {
    const Sample sample = cast(u, v, u, v);
    ++room_pixels[static_cast<std::size_t>(sample.room)];
    if (sample.hit.index < 0) return -1;
    const Solid& solid = renderer_.apartment_.solids[static_cast<std::size_t>(sample.hit.index)];
    view.depth_m.at<float>(v, u) = static_cast<float>(sample.hit.depth_m);
    view.labels.at<std::uint16_t>(v, u) = solid.instance;
    view.parts.at<std::uint16_t>(v, u) = solid.part;
    setColor(view, u, v, sample.color);
    return sample.hit.index;
  }

  /// Pixels beside another solid (in their own row of tiles) get the mean of four more rays.
  void smoothEdge(const cv::Mat& winners, int u, int v, int v0, int v1, RenderedView& view) const {
    const int own = winners.at<int>(v - v0, u);
    const bool edge = (u > 0 && winners.at<int>(v - v0, u - 1) != own) ||
                      (u + 1 < winners.cols && winners.at<int>(v - v0, u + 1) != own) ||
                      (v > v0 && winners.at<int>(v - v0 - 1, u) != own) ||
                      (v + 1 < v1 && winners.at<int>(v - v0 + 1, u) != own);
    if (!edge) return;
    Color sum(0.0F, 0.0F, 0.0F);
    for (const double dv : {-0.25, 0.25}) {
      for (const double du : {-0.25, 0.25}) sum += cast(u + du, v + dv, u, v).color;
    }
    setColor(view, u, v, sum * 0.25F);
  }

  static void setColor(RenderedView& view, int u, int v, const Color& color) {
    view.color.at<cv::Vec3b>(v, u) = {toByte(color.x()), toByte(color.y()), toByte(color.z())};
  }

  const Renderer& renderer_;
  const CameraModel& camera_;
  const Pose T_world_camera_;
  const ViewSolids solids_;
};

RenderedView Renderer::render(const CameraModel& camera, const Pose& T_world_camera) const {
  camera.validate();
  const cv::Size size(camera.width_px, camera.height_px);
  RenderedView view;
  view.color = cv::Mat(size, CV_8UC3, cv::Scalar::all(0));
  view.depth_m = cv::Mat(size, CV_32FC1, cv::Scalar(0));
  view.labels = cv::Mat(size, CV_16UC1, cv::Scalar(0));
  view.parts = cv::Mat(size, CV_16UC1, cv::Scalar(0));
  const TileRenderer tiles(*this, camera, T_world_camera);
  const auto rows = static_cast<std::size_t>((size.height - 1) / ViewSolids::kTile_px + 1);
  std::vector<std::vector<int>> counts(rows, std::vector<int>(apartment_.rooms.size() + 1, 0));
  parallelFor(rows, num_threads_,
              [&](std::size_t row) { tiles.renderRow(static_cast<int>(row), view, counts[row]); });
  view.room_pixels.assign(apartment_.rooms.size() + 1, 0);
  for (const auto& row : counts) {
    for (std::size_t i = 0; i < row.size(); ++i) view.room_pixels[i] += row[i];
  }
  return view;
}

}  // namespace tsg::simulation
