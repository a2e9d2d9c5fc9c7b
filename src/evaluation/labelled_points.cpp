// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "task_scene_graph/evaluation/class_scores.h"

namespace tsg::evaluation {
namespace {

struct Property {
  std::string name;
  std::string type;
};

struct Header {
  bool is_ascii = false;
  std::size_t num_vertices = 0;
  std::vector<Property> properties;  ///< of a vertex
};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("PLY file '" + path + "': " + what);
}

std::size_t sizeOf(const std::string& path, const std::string& type) {
  static const std::map<std::string, std::size_t> kSizes = {
      {"char", 1},  {"uchar", 1},  {"int8", 1},    {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2}, {"int", 4},     {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"double", 8}, {"float32", 4}, {"float64", 8}};
  const auto found = kSizes.find(type);
  if (found == kSizes.end())
    fail(path, "vertex property of type '" + type + "', expected a number");
  return found->second;
}

template <typename Value>
double decode(const char* bytes) {
  Value value;
  std::memcpy(&value, bytes, sizeof(Value));
  return static_cast<double>(value);
}

double decode(const std::string& type, const char* bytes) {
  if (type == "char" || type == "int8") return decode<std::int8_t>(bytes);
  if (type == "uchar" || type == "uint8") return decode<std::uint8_t>(bytes);
  if (type == "short" || type == "int16") return decode<std::int16_t>(bytes);
  if (type == "ushort" || type == "uint16") return decode<std::uint16_t>(bytes);
  if (type == "int" || type == "int32") return decode<std::int32_t>(bytes);
  if (type == "uint" || type == "uint32") return decode<std::uint32_t>(bytes);
  return type == "double" || type == "float64" ? decode<double>(bytes) : decode<float>(bytes);
}

/// Vertices must be the first element, as every known writer has them.
Header readHeader(std::istream& in, const std::string& path) {
  std::string line;
  if (!std::getline(in, line) || line.rfind("ply", 0) != 0) fail(path, "expected a PLY file");
  Header header;
  int num_elements = 0;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string word;
    std::string kind;
    words >> word;
    if (word == "end_header") return header;
    if (word == "format") {
      words >> kind;
      header.is_ascii = kind == "ascii";
      if (!header.is_ascii && kind != "binary_little_endian") {
        fail(path, "format '" + kind + "', expected ascii or binary_little_endian");
      }
    } else if (word == "element") {
      words >> kind;
      if (++num_elements == 1 && (kind != "vertex" || !(words >> header.num_vertices))) {
        fail(path, "first element '" + kind + "', expected vertices and their number");
      }
    } else if (word == "property" && num_elements == 1) {
      Property property;
      words >> property.type >> property.name;
      header.properties.push_back(property);
    }
  }
  fail(path, "the header has no end");
}

std::size_t findProperty(const Header& header, const std::string& path, const std::string& name) {
  for (std::size_t i = 0; i < header.properties.size(); ++i) {
    if (header.properties[i].name == name) return i;
  }
  fail(path, "vertices have no '" + name + "'");
}

/// The values of one vertex. False at the file's end.
bool readVertex(std::istream& in, const Header& header, const std::string& path,
                std::vector<double>& values) {
  char bytes[8];
  for (std::size_t i = 0; i < header.properties.size(); ++i) {
    const std::string& type = header.properties[i].type;
    if (header.is_ascii) {
      if (!(in >> values[i])) return false;
    } else {
      if (!in.read(bytes, static_cast<std::streamsize>(sizeOf(path, type)))) return false;
      values[i] = decode(type, bytes);
    }
  }
  return true;
}

}  // namespace

LabelledPoints loadLabelledPoints(const std::string& path, const std::string& property) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be read");
  const Header header = readHeader(in, path);
  const std::size_t x = findProperty(header, path, "x");
  const std::size_t y = findProperty(header, path, "y");
  const std::size_t z = findProperty(header, path, "z");
  const std::size_t label = findProperty(header, path, property);
  LabelledPoints points;
  std::vector<double> values(header.properties.size());
  for (std::size_t i = 0; i < header.num_vertices; ++i) {
    if (!readVertex(in, header, path, values)) {
      fail(path, "ends at vertex " + std::to_string(i) + ", expected " +
                     std::to_string(header.num_vertices));
    }
    const Eigen::Vector3d p(values[x], values[y], values[z]);
    const bool is_class = std::abs(values[label]) < 1e6 && values[label] >= kNoClass;
    if (!p.allFinite() || !is_class) {
      fail(path, "vertex " + std::to_string(i) +
                     " has a place or a label that is no number, or a label below -1");
    }
    points.points_m.push_back(p);
    points.classes.push_back(static_cast<int>(values[label]));
  }
  return points;
}

}  // namespace tsg::evaluation
