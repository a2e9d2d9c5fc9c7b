// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace tsg::language {

using TokenId = std::int64_t;

/// Number of merges that CLIP uses of its vocabulary file, which has more.
constexpr std::size_t kNumClipMerges = 48894;

/// The rules of a byte pair encoding: which two neighbouring tokens become one, best first.
///
/// Tokens are numbered as in CLIP: 256 bytes (printable ones first), the same at the end of a word,
/// one for each merge in the file's order, then the marks for start and end of a text.
class Vocabulary {
 public:
  /// Reads CLIP's `bpe_simple_vocab_16e6.txt`, packed (gzip) or not: a line that is skipped, then
  /// one merge a line, "left right", "</w>" marking a word's end.
  /// @param num_merges how many of the file's merges count; the file must have that many.
  /// @throws std::runtime_error naming the path and what is wrong: not readable, truncated, too few
  /// merges, or a line (by number) that merges what is no token or makes one that exists.
  static Vocabulary load(const std::string& path, std::size_t num_merges = kNumClipMerges);

  /// Token ids of one word: starts with its bytes and merges the best pair until none is left.
  /// O(length^2) at worst; thread-safe.
  std::vector<TokenId> encodeWord(const std::string& word) const;

  TokenId startOfText() const { return start_of_text_; }
  TokenId endOfText() const { return start_of_text_ + 1; }
  std::size_t size() const { return static_cast<std::size_t>(start_of_text_) + 2; }

 private:
  Vocabulary() = default;

  /// Merged token of a pair; smaller is better.
  std::unordered_map<std::uint64_t, TokenId> merges_;
  std::vector<TokenId> token_of_byte_;
  TokenId start_of_text_ = 0;
};

/// Path of CLIP's vocabulary: $TSG_VOCABULARY if set, else where scripts/install_vocabulary put it
/// (${XDG_CACHE_HOME:-~/.cache}/task_scene_graph); nothing if it is not there.
std::optional<std::string> findInstalledVocabulary();

}  // namespace tsg::language
