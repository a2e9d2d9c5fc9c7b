// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/evaluation/openlex3d.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>

namespace tsg::evaluation {
namespace {

using scene_graph::FileObject;

struct Point {
  std::array<float, 3> p_m;
  std::uint32_t rgb = 0;  ///< 0x00RRGGBB
};

struct Predictions {
  std::vector<float> embeddings;  ///< row after row
  Eigen::Index dimension = 0;
  std::size_t num_objects = 0;
  std::vector<std::int64_t> index;
  std::vector<Point> points;
};

void addPoints(const FileObject& object, double cell_m, Predictions& predictions) {
  std::set<std::array<std::int64_t, 3>> taken;
  for (std::size_t i = 0; i < object.points_m.size(); ++i) {
    const Eigen::Vector3d& p_m = object.points_m[i];
    if (cell_m > 0.0) {
      const Eigen::Vector3d cell = (p_m / cell_m).array().floor();
      const auto toInt = [&](int axis) { return static_cast<std::int64_t>(cell[axis]); };
      if (!taken.insert({toInt(0), toInt(1), toInt(2)}).second) continue;
    }
    const auto& c = object.colors[i];
    const Eigen::Vector3f p = p_m.cast<float>();
    predictions.points.push_back(
        {{p.x(), p.y(), p.z()},
         (std::uint32_t{c[0]} << 16U) | (std::uint32_t{c[1]} << 8U) | std::uint32_t{c[2]}});
    predictions.index.push_back(static_cast<std::int64_t>(predictions.num_objects));
  }
}

Predictions collect(const std::vector<FileObject>& objects, double cell_m) {
  Predictions predictions;
  for (const FileObject& object : objects) {
    if (object.points_m.empty()) continue;
    if (predictions.num_objects == 0) predictions.dimension = object.embedding.size();
    const float length = object.embedding.norm();
    if (object.embedding.size() != predictions.dimension || !(length > 0.0F)) {
      throw std::invalid_argument(
          "an object has an embedding of " + std::to_string(object.embedding.size()) +
          " numbers and length " + std::to_string(length) + ", expected " +
          std::to_string(predictions.dimension) + " as the first has, not all 0");
    }
    addPoints(object, cell_m, predictions);
    for (Eigen::Index i = 0; i < predictions.dimension; ++i) {
      predictions.embeddings.push_back(object.embedding[i] / length);
    }
    ++predictions.num_objects;
  }
  if (predictions.num_objects == 0) {
    throw std::invalid_argument("none of " + std::to_string(objects.size()) +
                                " objects has a mesh, expected points to export");
  }
  return predictions;
}

template <typename Value>
void writeValues(std::ostream& out, const std::vector<Value>& values) {
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(Value)));
}

/// NumPy's format, version 1.0: the head's length is a multiple of 64.
template <typename Value>
void writeNpy(const std::filesystem::path& path, const char* type, const std::string& shape,
              const std::vector<Value>& values) {
  std::string head =
      "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': " + shape + ", }";
  constexpr std::size_t kBefore = 10;
  head.append(63 - (kBefore + head.size()) % 64, ' ');
  head += '\n';
  writeFileAtomically(path, [&](std::ostream& out) {
    out.write("\x93NUMPY\x01\x00", 8);
    out.put(static_cast<char>(head.size() & 0xFFU)).put(static_cast<char>(head.size() >> 8U));
    out << head;
    writeValues(out, values);
  });
}

void writePcd(const std::filesystem::path& path, const std::vector<Point>& points) {
  static_assert(sizeof(Point) == 16, "as the header says");
  const std::string count = std::to_string(points.size());
  writeFileAtomically(path, [&](std::ostream& out) {
    out << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
        << "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " << count
        << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << count << "\nDATA binary\n";
    writeValues(out, points);
  });
}

}  // namespace

std::vector<WrittenFile> writeOpenLex3d(const std::filesystem::path& folder,
                                        const std::vector<FileObject>& objects, double cell_m) {
  const Predictions predictions = collect(objects, cell_m);
  const std::string rows = std::to_string(predictions.num_objects);
  const std::string columns = std::to_string(predictions.dimension);
  writeNpy(folder / "embeddings.npy", "<f4", "(" + rows + ", " + columns + ")",
           predictions.embeddings);
  writeNpy(folder / "index.npy", "<i8", "(" + std::to_string(predictions.index.size()) + ",)",
           predictions.index);
  writePcd(folder / "point_cloud.pcd", predictions.points);
  return {{"embeddings.npy", formatCount(predictions.num_objects, "object")},
          {"index.npy", ""},
          {"point_cloud.pcd", formatCount(predictions.points.size(), "point")}};
}

}  // namespace tsg::evaluation
