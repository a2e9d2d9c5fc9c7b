// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace tsg::fuzz {

/// Messages of several types in one input: a letter for the type, the length, the bytes.
using Records = std::vector<std::pair<char, std::string>>;

inline std::string joinRecords(const Records& records) {
  std::string text;
  for (const auto& [type, bytes] : records) {
    const auto size = static_cast<std::uint32_t>(bytes.size());
    text += type;
    text.append(reinterpret_cast<const char*>(&size), sizeof(size));
    text += bytes;
  }
  return text;
}

inline Records splitRecords(const std::string& text) {
  Records records;
  std::uint32_t size = 0;
  for (std::size_t at = 0; at + 1 + sizeof(size) <= text.size();) {
    std::memcpy(&size, text.data() + at + 1, sizeof(size));
    records.emplace_back(text[at], text.substr(at + 1 + sizeof(size), size));
    at += 1 + sizeof(size) + size;
  }
  return records;
}

}  // namespace tsg::fuzz
