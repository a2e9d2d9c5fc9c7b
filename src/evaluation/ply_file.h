// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

namespace tsg::evaluation {

/// Of the rows of a PLY file.
struct PlyProperty {
  std::string name;
  std::string type;        ///< of a number, "float" for example
  std::string count_type;  ///< of a list: that of its length; "" for a single number
};

/// Rows alike: vertices, or faces.
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

/// Values of a row, a list for each property; of a single number a list of one.
using PlyRow = std::vector<std::vector<double>>;

/// Reads a PLY file (ascii or binary little-endian), element by element and row by row. All throw
/// std::runtime_error naming the file, what was found and what was expected.
class PlyFile {
 public:
  /// Reads the header. Vertices must be the first element, as every known writer has them.
  explicit PlyFile(std::string path);

  const std::vector<PlyElement>& elements() const { return elements_; }
  const PlyElement& vertices() const { return elements_.front(); }
  std::size_t findProperty(const PlyElement& element, const std::string& name) const;
  /// The next row; `index` is its number, for messages.
  void readRow(const PlyElement& element, std::size_t index, PlyRow& row);

  [[noreturn]] void fail(const std::string& what) const;

 private:
  void readHeader();
  void readElement(std::istream& words);
  void readProperty(std::istream& words);
  bool readNumber(const std::string& type, double& value);
  bool readValues(const PlyProperty& property, std::vector<double>& values);

  std::string path_;
  std::ifstream in_;
  bool is_ascii_ = false;
  std::vector<PlyElement> elements_;
};

}  // namespace tsg::evaluation
