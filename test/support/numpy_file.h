// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "task_scene_graph/core/embedding.h"

namespace tsg::test {

/// An array as NumPy stores it, row-major.
struct NumpyArray {
  std::string type;  ///< NumPy's, such as "|u1", "<f2", "<i4"
  std::vector<std::size_t> shape;
  std::vector<std::uint8_t> bytes;
};

/// @throws std::runtime_error naming the file if it is not one.
NumpyArray readNpy(const std::filesystem::path& path);
/// By name, without ".npy". @throws as readNpy.
std::map<std::string, NumpyArray> readNpz(const std::filesystem::path& path);

/// Rows of a two-dimensional array of half floats, scaled to length 1.
EmbeddingMatrix toUnitRows(const NumpyArray& array);

}  // namespace tsg::test
