// SPDX-License-Identifier: BSD-3-Clause
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "task_scene_graph/evaluation/map_regions.h"

namespace tsg::evaluation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kSampleHeight_m = 0.5;  ///< above the floor
constexpr double kMargin_m = 0.3;        ///< of rooms below their floor: a map's floor is not exact
constexpr double kAnyHeight_m = 100.0;   ///< of rooms whose height is not told

OrientedBox makeRoomBox(const json& rectangle_m, double z0_m, double z1_m) {
  const Eigen::Vector3d low(rectangle_m.at(0), rectangle_m.at(1), z0_m);
  const Eigen::Vector3d high(rectangle_m.at(2), rectangle_m.at(3), z1_m);
  return toOrientedBox(makeAabb(low, high));
}

std::vector<TrueRoom> readWorld(const json& list) {
  std::vector<TrueRoom> rooms;
  for (const json& room : list) {
    const double z_m = room.value("floor_z_m", 0.0);
    const double top_m = z_m + room.at("height_m").get<double>();
    rooms.push_back(
        {room.at("name"), {makeRoomBox(room.at("rectangle_m"), z_m - kMargin_m, top_m)}});
  }
  return rooms;
}

std::vector<TrueRoom> readHouse(const json& list) {
  std::vector<TrueRoom> rooms;
  for (const json& room : list) {
    rooms.push_back({room.at("name"), {}});
    for (const json& rectangle_m : room.at("rects")) {
      rooms.back().boxes.push_back(makeRoomBox(rectangle_m, -kAnyHeight_m, kAnyHeight_m));
    }
  }
  return rooms;
}

OrientedBox readHydraBox(const YAML::Node& node) {
  const auto center = node["center"].as<std::vector<double>>();
  const auto extents = node["extents"].as<std::vector<double>>();
  if (center.size() != 3 || extents.size() != 3)
    throw YAML::Exception(node.Mark(), "not 3 numbers");
  OrientedBox box;
  box.center_m = {center[0], center[1], center[2]};
  box.size_m = {extents[0], extents[1], extents[2]};
  if (const YAML::Node r = node["rotation"]) {
    const double w = r["w"].as<double>();
    const double x = r["x"].as<double>();
    const double y = r["y"].as<double>();
    const double z = r["z"].as<double>();
    box.yaw_rad = std::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
  }
  return box;
}

std::vector<TrueRoom> readHydra(const YAML::Node& file) {
  std::vector<TrueRoom> rooms;
  for (const auto& entry : file) {
    rooms.push_back({entry.first.as<std::string>(), {}});
    for (const YAML::Node& box : entry.second) rooms.back().boxes.push_back(readHydraBox(box));
  }
  return rooms;
}

/// Height of the floor from the comment on top; 0 if there is none.
double readFloorHeight(const fs::path& path) {
  std::ifstream file(path);
  std::string hash, floor, at, z, equals;
  double floor_m = 0.0;
  const bool is_told = static_cast<bool>(file >> hash >> floor >> at >> z >> equals >> floor_m);
  return is_told && hash == "#" && floor == "Floor" ? floor_m : 0.0;
}

struct Image {
  int width = 0;
  int height = 0;
  std::string pixels;
};

Image readPgm(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic;
  Image image;
  int largest = 0;
  const bool is_whole = static_cast<bool>(file >> magic >> image.width >> image.height >> largest);
  if (!is_whole || magic != "P5" || largest != 255 || image.width < 1 || image.height < 1 ||
      image.width > 100000 || image.height > 100000) {
    throw std::runtime_error("image '" + path.string() + "', expected a binary PGM of 8 bits");
  }
  file.get();
  image.pixels.resize(static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
  if (!file.read(&image.pixels[0], static_cast<std::streamsize>(image.pixels.size()))) {
    throw std::runtime_error("image '" + path.string() + "' ends early");
  }
  return image;
}

FloorSamples readFloor(const fs::path& path) {
  const YAML::Node head = YAML::LoadFile(path.string());
  const Image image = readPgm(path.parent_path() / head["image"].as<std::string>());
  const auto origin = head["origin"].as<std::vector<double>>();
  const auto free_threshold = head["free_thresh"].as<double>();
  FloorSamples floor;
  floor.floor_m = readFloorHeight(path);
  floor.cell_m = head["resolution"].as<double>();
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const auto pixel = static_cast<unsigned char>(
          image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                       static_cast<std::size_t>(column)]);
      if ((255.0 - pixel) / 255.0 >= free_threshold) continue;
      floor.samples_m.emplace_back(origin.at(0) + (column + 0.5) * floor.cell_m,
                                   origin.at(1) + (image.height - row - 0.5) * floor.cell_m,
                                   floor.floor_m + kSampleHeight_m);
    }
  }
  return floor;
}

}  // namespace

std::vector<FloorSamples> loadFloors(const std::string& map_folder) {
  std::vector<FloorSamples> floors;
  for (int i = 0;; ++i) {
    const fs::path path = fs::path(map_folder) / ("floor_" + std::to_string(i) + ".yaml");
    if (!fs::exists(path)) return floors;
    try {
      floors.push_back(readFloor(path));
    } catch (const YAML::Exception& error) {
      throw std::runtime_error("ground plan '" + path.string() + "' " + error.what() +
                               "; expected image, resolution, origin and free_thresh");
    }
  }
}

std::vector<TrueRoom> loadRoomTruth(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("rooms '" + path + "' cannot be read");
  try {
    if (fs::path(path).extension() != ".json") return readHydra(YAML::LoadFile(path));
    const json content = json::parse(file);
    return content.is_array() ? readHouse(content) : readWorld(content.at("rooms"));
  } catch (const json::exception& error) {
    throw std::runtime_error("rooms '" + path + "' cannot be read: " + error.what());
  } catch (const YAML::Exception& error) {
    throw std::runtime_error("rooms '" + path + "' cannot be read: " + error.what() +
                             "; expected id -> [{center, extents, rotation}]");
  }
}

}  // namespace tsg::evaluation
