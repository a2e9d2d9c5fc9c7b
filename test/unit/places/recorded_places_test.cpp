// SPDX-License-Identifier: BSD-3-Clause
// The place graph of a recorded walk through a house against the house's true mesh and rooms. The
// line that is printed is the result. TSG_OUTPUT=FOLDER also draws FOLDER/places.png.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "graph_checks.h"
#include "place_heap.h"
#include "sequence.h"
#include "support.h"
#include "task_scene_graph/mapping/tsdf_integrator.h"
#include "task_scene_graph/places/place_extractor.h"

namespace tsg::places {
namespace {

constexpr double kPixel_m = 0.025;

/// Plan of what stands between two heights, from the triangles of a binary PLY file.
class TruePlan {
 public:
  TruePlan(const std::filesystem::path& ply, double min_z_m, double max_z_m)
      : min_z_m_(min_z_m), max_z_m_(max_z_m), plan_(480, 800, CV_8UC1, cv::Scalar(0)) {
    std::ifstream file(ply, std::ios::binary);
    std::size_t num_vertices = 0;
    std::size_t num_faces = 0;
    for (std::string line; std::getline(file, line) && line != "end_header";) {
      std::sscanf(line.c_str(), "element vertex %zu", &num_vertices);
      std::sscanf(line.c_str(), "element face %zu", &num_faces);
    }
    std::vector<Eigen::Vector3f> vertices(num_vertices);
    file.read(reinterpret_cast<char*>(vertices.data()),
              static_cast<std::streamsize>(num_vertices * sizeof(Eigen::Vector3f)));
    for (std::size_t i = 0; i < num_faces; ++i) {
      char face[15];  // one count, three 32-bit indices, one 16-bit instance
      file.read(face, sizeof(face));
      std::int32_t index[3];
      std::memcpy(index, face + 1, sizeof(index));
      draw(vertices.at(static_cast<std::size_t>(index[0])).cast<double>(),
           vertices.at(static_cast<std::size_t>(index[1])).cast<double>(),
           vertices.at(static_cast<std::size_t>(index[2])).cast<double>());
    }
    cv::distanceTransform(plan_ == 0, distance_px_, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  }

  static cv::Point toPixel(const Eigen::Vector3d& p) {
    return {static_cast<int>((p.x() + 10.0) / kPixel_m),
            static_cast<int>((6.0 - p.y()) / kPixel_m)};
  }

  double computeClearance(const Eigen::Vector3d& p) const {
    return kPixel_m * static_cast<double>(distance_px_.at<float>(toPixel(p)));
  }

  const cv::Mat& plan() const { return plan_; }

 private:
  void draw(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double longest_m = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int steps = 1 + static_cast<int>(longest_m / kPixel_m);
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps - i; ++j) {
        const Eigen::Vector3d p = a + (b - a) * i / steps + (c - a) * j / steps;
        if (p.z() >= min_z_m_ && p.z() <= max_z_m_) plan_.at<std::uint8_t>(toPixel(p)) = 255;
      }
    }
  }

  double min_z_m_;
  double max_z_m_;
  cv::Mat plan_;
  cv::Mat distance_px_;
};

/// Id of the room that holds a point, 0 if none does.
int findRoom(const nlohmann::json& rooms, const Eigen::Vector3d& p) {
  for (const auto& room : rooms) {
    for (const auto& rect : room.at("rects")) {
      const bool is_inside =
          p.x() >= rect[0] && p.x() <= rect[2] && p.y() >= rect[1] && p.y() <= rect[3];
      if (is_inside) return room.at("id");
    }
  }
  return 0;
}

/// Walkable space in green, the paler the more clearance.
void drawFreeSpace(const GroundPlan& plan, cv::Mat& image) {
  for (const auto& [index, tiles] : plan.tiles()) {
    for (const auto& tile : tiles) {
      for (int i = 0; i < 64; ++i) {
        const PlanCell& cell = (*tile)[static_cast<std::size_t>(i)];
        if (!cell.isFree()) continue;
        const Eigen::Vector2d p_m =
            plan.computeCenter({index.first * 8 + i % 8, index.second * 8 + i / 8});
        const cv::Point at = TruePlan::toPixel({p_m.x(), p_m.y(), 0.0});
        const double shade = 180.0 + 25.0 * static_cast<double>(cell.clearance_m);
        cv::rectangle(image, at - cv::Point(2, 2), at + cv::Point(1, 1),
                      cv::Scalar(shade, 255, shade), -1);
      }
    }
  }
}

void drawGraph(const TruePlan& plan, const GroundPlan& ground, const PlaceGraph& graph,
               const std::filesystem::path& path) {
  cv::Mat image(plan.plan().size(), CV_8UC3, cv::Scalar::all(255));
  drawFreeSpace(ground, image);
  image.setTo(cv::Scalar::all(120), plan.plan());
  for (const PlaceEdge& edge : graph.edges) {
    cv::line(image, TruePlan::toPixel(test::findPlace(graph, edge.a).position_m),
             TruePlan::toPixel(test::findPlace(graph, edge.b).position_m), {200, 120, 0}, 1,
             cv::LINE_AA);
  }
  for (const Place& place : graph.places) {
    const cv::Scalar color = place.num_views > 0 ? cv::Scalar(0, 0, 220) : cv::Scalar(0, 160, 0);
    cv::circle(image, TruePlan::toPixel(place.position_m), 3, color, -1, cv::LINE_AA);
  }
  cv::resize(image, image, {}, 2.0, 2.0);
  cv::imwrite(path.string(), image);
}

std::vector<int> readRooms(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<int> rooms;
  for (int room = 0; file >> room;) rooms.push_back(room);
  return rooms;
}

TEST(RecordedPlaces, LieInTheFreeSpaceOfAHouseAndKnowTheirRooms) {
  TSG_REQUIRE_SHARED(folder, "data/house_a");
  mapping::IntegratorConfig integrator_config;
  integrator_config.voxel_size_m = 0.1;
  integrator_config.truncation_m = 0.3;
  integrator_config.carve_free_space = true;
  integrator_config.with_color = false;
  mapping::TsdfIntegrator integrator(integrator_config);
  mapping::TsdfVolume volume(0.1);
  PlaceExtractor extractor{PlacesConfig{}};
  const std::vector<int> camera_rooms = readRooms(folder / "rooms_per_frame.txt");
  for (int i = 0; i < 400; i += 2) {
    const RgbdFrame frame = tsg::test::loadSequenceFrame(folder, i);
    const auto result = integrator.integrate(frame, volume);
    extractor.addPose({frame.stamp, frame.T_world_camera});
    extractor.update(volume, result.changed_blocks, frame.stamp);
    extractor.addView(frame, Embedding::Unit(8, camera_rooms.at(static_cast<std::size_t>(i))));
  }
  const PlaceGraph graph = extractor.graph();
  const TruePlan plan(folder / "scene_mesh.ply", 0.25, 1.0);
  const auto rooms = nlohmann::json::parse(std::ifstream(folder / "rooms.json"));
  int num_colliding = 0;
  int num_seen = 0;
  int num_in_their_room = 0;
  std::set<int> rooms_reached;
  for (const Place& place : graph.places) {
    num_colliding += plan.computeClearance(place.position_m) < 0.2 ? 1 : 0;
    const int room = findRoom(rooms, place.position_m);
    rooms_reached.insert(room);
    if (place.num_views == 0) continue;
    ++num_seen;
    Eigen::Index strongest = 0;
    place.embedding->maxCoeff(&strongest);
    num_in_their_room += strongest == room ? 1 : 0;
  }
  const auto num_places = static_cast<int>(graph.places.size());
  const auto heap = tsg::test::measurePlaceHeap(extractor.memory(), PlacesConfig{});
  std::printf(
      "places %d (created %llu), edges %zu, parts %zu, rooms %zu, nearer than 0.2 m to a "
      "surface %d, seen %d, of these like their room %d; kB for each place %.2f, for the choice of "
      "places %.2f\n",
      num_places, static_cast<unsigned long long>(extractor.counters().places_created),
      graph.edges.size(), test::findParts(graph).size(), rooms_reached.size(), num_colliding,
      num_seen, num_in_their_room, 1e-3 * heap.graph() / num_places,
      1e-3 * heap.cells / num_places);
  if (const char* output = std::getenv("TSG_OUTPUT")) {
    drawGraph(plan, extractor.plan(), graph, std::filesystem::path(output) / "places.png");
  }
  EXPECT_GE(num_places, 60);
  EXPECT_EQ(test::findParts(graph).size(), 1U);
  EXPECT_LE(num_colliding, num_places / 20);
  EXPECT_GE(num_seen, num_places * 9 / 10);
  EXPECT_GE(num_in_their_room, num_seen / 2);
  EXPECT_LE(heap.graph(), 1000.0 * num_places);
}

}  // namespace
}  // namespace tsg::places
