// SPDX-License-Identifier: BSD-3-Clause
#include "ply_file.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace tsg::evaluation {
namespace {

constexpr double kMaxListLength = 1e6;

std::size_t sizeOf(const std::string& type) {
  static const std::map<std::string, std::size_t> kSizes = {
      {"char", 1},  {"uchar", 1},  {"int8", 1},    {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2}, {"int", 4},     {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"double", 8}, {"float32", 4}, {"float64", 8}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? 0 : found->second;
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

}  // namespace

PlyFile::PlyFile(std::string path) : path_(std::move(path)), in_(path_, std::ios::binary) {
  if (!in_) fail("cannot be read");
  readHeader();
}

void PlyFile::fail(const std::string& what) const {
  throw std::runtime_error("PLY file '" + path_ + "': " + what);
}

void PlyFile::readHeader() {
  std::string line;
  if (!std::getline(in_, line) || line.rfind("ply", 0) != 0) fail("expected a PLY file");
  while (std::getline(in_, line)) {
    std::istringstream words(line);
    std::string word;
    std::string format;
    words >> word;
    if (word == "element") readElement(words);
    if (word == "property") readProperty(words);
    if (word == "format") {
      words >> format;
      is_ascii_ = format == "ascii";
      if (!is_ascii_ && format != "binary_little_endian") {
        fail("format '" + format + "', expected ascii or binary_little_endian");
      }
    }
    if (word != "end_header") continue;
    if (elements_.empty()) fail("no element, expected vertices and their number");
    return;
  }
  fail("the header has no end");
}

void PlyFile::readElement(std::istream& words) {
  PlyElement element;
  const bool is_read = static_cast<bool>(words >> element.name >> element.count);
  if (elements_.empty() && (!is_read || element.name != "vertex")) {
    fail("first element '" + element.name + "', expected vertices and their number");
  }
  if (!is_read) fail("element '" + element.name + "', expected a name and a number");
  elements_.push_back(element);
}

void PlyFile::readProperty(std::istream& words) {
  if (elements_.empty()) fail("a property before the first element");
  PlyProperty property;
  words >> property.type;
  if (property.type == "list") words >> property.count_type >> property.type;
  words >> property.name;
  for (const std::string& type : {property.type, property.count_type}) {
    if (!type.empty() && sizeOf(type) == 0) {
      fail(elements_.back().name + " property of type '" + type + "', expected a number");
    }
  }
  elements_.back().properties.push_back(property);
}

std::size_t PlyFile::findProperty(const PlyElement& element, const std::string& name) const {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].name == name) return i;
  }
  fail(element.name + " rows have no '" + name + "'");
}

bool PlyFile::readNumber(const std::string& type, double& value) {
  char bytes[8];
  if (is_ascii_) return static_cast<bool>(in_ >> value);
  if (!in_.read(bytes, static_cast<std::streamsize>(sizeOf(type)))) return false;
  value = decode(type, bytes);
  return true;
}

bool PlyFile::readValues(const PlyProperty& property, std::vector<double>& values) {
  double count = 1.0;
  if (!property.count_type.empty() && !readNumber(property.count_type, count)) return false;
  if (!(count >= 0.0 && count <= kMaxListLength)) {
    fail("a list of " + std::to_string(count) + " numbers, expected at most a million");
  }
  values.resize(static_cast<std::size_t>(count));
  for (double& value : values) {
    if (!readNumber(property.type, value)) return false;
  }
  return true;
}

void PlyFile::readRow(const PlyElement& element, std::size_t index, PlyRow& row) {
  row.resize(element.properties.size());
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (readValues(element.properties[i], row[i])) continue;
    fail("ends at " + element.name + " " + std::to_string(index) + ", expected " +
         std::to_string(element.count));
  }
}

}  // namespace tsg::evaluation
