// SPDX-License-Identifier: BSD-3-Clause
#include "graph_json.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "task_scene_graph/core/file_kind.h"

namespace tsg::bottleneck {
namespace {

using Span = std::pair<std::size_t, std::size_t>;  // begin, end

constexpr int kMaxDepth = 256;
constexpr std::size_t kLongNumber = 300;  // digits that a double may just hold

bool isWord(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.';
}

bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

bool isOddNumber(std::string word) {
  const bool is_number = std::isdigit(static_cast<unsigned char>(word.back())) != 0;
  if (is_number) return !std::isfinite(std::strtod(word.c_str(), nullptr));
  if (word[0] == '-' || word[0] == '+') word.erase(0, 1);
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word == "nan" || word == "infinity" || word == "inf";
}

/// Position behind a string that begins at `at`.
std::size_t skipString(const std::string& text, std::size_t at) {
  for (++at; at < text.size() && text[at] != '"'; ++at) {
    if (text[at] == '\\') ++at;
  }
  return at + 1;
}

/// Where odd numbers are. @throws std::runtime_error if the text is nested too deeply.
std::vector<Span> findOddNumbers(const std::string& text) {
  std::vector<Span> odd;
  int depth = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"') {
      at = skipString(text, at);
      continue;
    }
    depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (depth > kMaxDepth) {
      throw std::runtime_error("is nested deeper than " + std::to_string(kMaxDepth) +
                               " levels; expected a spark_dsg scene graph");
    }
    const std::size_t begin = at++;
    if (!isWord(c)) continue;
    bool has_letters = isLetter(c);
    for (; at < text.size() && isWord(text[at]); ++at) has_letters |= isLetter(text[at]);
    if (!has_letters && at - begin <= kLongNumber) continue;
    if (isOddNumber(text.substr(begin, at - begin))) odd.emplace_back(begin, at);
  }
  return odd;
}

void replaceByNull(const std::vector<Span>& spans, std::string& text) {
  if (spans.empty()) return;
  std::string replaced;
  std::size_t kept = 0;
  for (const auto& [begin, end] : spans) {
    replaced.append(text, kept, begin - kept);
    replaced += "null";
    kept = end;
  }
  replaced.append(text, kept);
  text = std::move(replaced);
}

std::string readText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(std::string("cannot be opened: ") + std::strerror(errno));
  const std::string kind = describeFileKind(path);
  if (!kind.empty()) throw std::runtime_error(kind);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw std::runtime_error("holds nothing but spaces");
  }
  return text;
}

/// Whether an object or list is not closed at the end.
bool isCutOff(const std::string& text) {
  const char first = text[text.find_first_not_of(" \t\r\n")];
  const char last = text[text.find_last_not_of(" \t\r\n")];
  return (first == '{' && last != '}') || (first == '[' && last != ']');
}

/// Without the library's own number of the error.
std::string describe(const nlohmann::json::exception& e) {
  const std::string what = e.what();
  const std::size_t end = what.find("] ");
  return end == std::string::npos ? what : what.substr(end + 2);
}

}  // namespace

JsonFile readJsonFile(const std::string& path) {
  std::string text = readText(path);
  const std::vector<Span> odd = findOddNumbers(text);
  replaceByNull(odd, text);
  try {
    return {nlohmann::json::parse(text), odd.size()};
  } catch (const nlohmann::json::exception& e) {
    throw std::runtime_error("is not JSON" + std::string(isCutOff(text) ? " or cut off" : "") +
                             ": " + describe(e));
  }
}

}  // namespace tsg::bottleneck
