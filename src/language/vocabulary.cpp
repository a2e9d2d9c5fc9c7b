// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/vocabulary.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace tsg::language {
namespace {

constexpr int kNumBytes = 256;
constexpr const char* kEndOfWord = "</w>";

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("vocabulary '" + path + "': " + what);
}

/// Reads a file, unpacking it if it is a gzip file.
std::string readMaybePacked(const std::string& path) {
  const gzFile file = gzopen(path.c_str(), "rb");
  if (!file) fail(path, std::string("cannot be opened: ") + std::strerror(errno));
  std::string content;
  std::vector<char> buffer(1 << 16);
  int num_read = 0;
  while ((num_read = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0) {
    content.append(buffer.data(), static_cast<std::size_t>(num_read));
  }
  // Closing tells of a packed file that ends early.
  if (gzclose_r(file) != Z_OK || num_read < 0) fail(path, "is truncated or damaged");
  return content;
}

bool isPrintableByte(int byte) {
  return (byte >= '!' && byte <= '~') || (byte >= 0xa1 && byte <= 0xac) || byte >= 0xae;
}

/// The bytes in the order of their tokens.
std::vector<int> orderBytes() {
  std::vector<int> bytes;
  for (const bool printable : {true, false}) {
    for (int byte = 0; byte < kNumBytes; ++byte) {
      if (isPrintableByte(byte) == printable) bytes.push_back(byte);
    }
  }
  return bytes;
}

/// The vocabulary file writes a byte as one character: printable ones as in Latin-1, the others as
/// U+0100 and up. All of them are below U+0800.
std::string toFileCharacter(int code_point) {
  if (code_point < 0x80) return {static_cast<char>(code_point)};
  return {static_cast<char>(0xc0 | (code_point >> 6)),
          static_cast<char>(0x80 | (code_point & 0x3f))};
}

std::unordered_map<std::string, TokenId> nameByteTokens() {
  std::unordered_map<std::string, TokenId> tokens;
  TokenId token = 0;
  int next_code_point = 0x100;
  for (const int byte : orderBytes()) {
    const std::string name = toFileCharacter(isPrintableByte(byte) ? byte : next_code_point++);
    tokens[name] = token;
    tokens[name + kEndOfWord] = token + kNumBytes;
    ++token;
  }
  return tokens;
}

std::uint64_t toKey(TokenId left, TokenId right) {
  return (static_cast<std::uint64_t>(left) << 32) | static_cast<std::uint64_t>(right);
}

/// Reads the merges of a vocabulary file one by one.
class MergeReader {
 public:
  MergeReader(const std::string& path, std::size_t num_merges)
      : path_(path), num_merges_(num_merges), lines_(readMaybePacked(path)) {
    std::string header;
    std::getline(lines_, header);
  }

  /// Calls `add` with the pair's key and the merged token, for each merge.
  template <typename Add>
  void readAll(const Add& add) {
    for (std::size_t i = 0; i < num_merges_; ++i) {
      const TokenId token = 2 * kNumBytes + static_cast<TokenId>(i);
      add(readMerge(token), token);
    }
  }

 private:
  std::uint64_t readMerge(TokenId token) {
    const auto number = token - 2 * kNumBytes;
    std::string line;
    if (!std::getline(lines_, line)) {
      fail(path_,
           "has " + std::to_string(number) + " merges, expected " + std::to_string(num_merges_));
    }
    std::istringstream words(line);
    std::string left, right, rest;
    if (!(words >> left >> right) || words >> rest) failAt(number, line, "is not a pair");
    const auto left_token = tokens_.find(left);
    const auto right_token = tokens_.find(right);
    if (left_token == tokens_.end() || right_token == tokens_.end()) {
      failAt(number, line, "merges what is no token yet");
    }
    const std::uint64_t key = toKey(left_token->second, right_token->second);
    if (!tokens_.emplace(left + right, token).second) failAt(number, line, "is there twice");
    return key;
  }

  [[noreturn]] void failAt(TokenId number, const std::string& line, const std::string& what) const {
    // Line 1 is the header.
    fail(path_, "line " + std::to_string(number + 2) + " '" + line.substr(0, 80) + "' " + what);
  }

  std::string path_;
  std::size_t num_merges_;
  std::istringstream lines_;
  std::unordered_map<std::string, TokenId> tokens_ = nameByteTokens();
};

using Merges = std::unordered_map<std::uint64_t, TokenId>;

TokenId findMerge(const Merges& merges, TokenId left, TokenId right) {
  const auto it = merges.find(toKey(left, right));
  return it == merges.end() ? std::numeric_limits<TokenId>::max() : it->second;
}

/// The merge that comes first in the file among all neighbours.
TokenId findBestMerge(const Merges& merges, const std::vector<TokenId>& tokens) {
  TokenId best = std::numeric_limits<TokenId>::max();
  for (std::size_t i = 0; i + 1 < tokens.size(); ++i) {
    best = std::min(best, findMerge(merges, tokens[i], tokens[i + 1]));
  }
  return best;
}

/// Merges each pair that becomes `merged`, from left to right.
void applyMerge(const Merges& merges, TokenId merged, std::vector<TokenId>& tokens) {
  std::size_t end = 0;
  for (std::size_t i = 0; i < tokens.size(); ++i, ++end) {
    const bool is_pair =
        i + 1 < tokens.size() && findMerge(merges, tokens[i], tokens[i + 1]) == merged;
    tokens[end] = is_pair ? merged : tokens[i];
    if (is_pair) ++i;
  }
  tokens.resize(end);
}

}  // namespace

std::optional<std::string> findInstalledVocabulary() {
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string(value ? value : "");
  };
  std::filesystem::path path = variable("TSG_VOCABULARY");
  if (path.empty()) {
    const std::filesystem::path cache = variable("XDG_CACHE_HOME");
    const std::filesystem::path home = variable("HOME");
    path = (cache.empty() ? home / ".cache" : cache) / "task_scene_graph" /
           "bpe_simple_vocab_16e6.txt.gz";
  }
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  return path.string();
}

Vocabulary Vocabulary::load(const std::string& path, std::size_t num_merges) {
  Vocabulary vocabulary;
  vocabulary.merges_.reserve(num_merges);
  MergeReader(path, num_merges).readAll([&](std::uint64_t key, TokenId token) {
    vocabulary.merges_.emplace(key, token);
  });
  vocabulary.token_of_byte_.resize(kNumBytes);
  TokenId token = 0;
  for (const int byte : orderBytes()) {
    vocabulary.token_of_byte_[static_cast<std::size_t>(byte)] = token++;
  }
  vocabulary.start_of_text_ = 2 * kNumBytes + static_cast<TokenId>(num_merges);
  return vocabulary;
}

std::vector<TokenId> Vocabulary::encodeWord(const std::string& word) const {
  std::vector<TokenId> tokens;
  for (const char character : word) {
    tokens.push_back(token_of_byte_[static_cast<unsigned char>(character)]);
  }
  if (!tokens.empty()) tokens.back() += kNumBytes;
  while (true) {
    const TokenId best = findBestMerge(merges_, tokens);
    if (best == std::numeric_limits<TokenId>::max()) return tokens;
    applyMerge(merges_, best, tokens);
  }
}

}  // namespace tsg::language
