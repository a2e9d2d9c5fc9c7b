// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "task_scene_graph/language/vocabulary.h"

namespace tsg::language {

/// Length of the texts that CLIP's text encoders read, in tokens.
constexpr int kClipContextLength = 77;

/// One text per row, as text encoders read them (n x context length, row-major).
using TokenMatrix = Eigen::Matrix<TokenId, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// CLIP's tokenizer: the same ids as open_clip's `tokenize` but for the deviations that
/// text_cleaning.h lists. Thread-safe.
class Tokenizer {
 public:
  /// @param context_length at least 2 (start and end of the text).
  /// @throws std::invalid_argument if it is less.
  explicit Tokenizer(Vocabulary vocabulary, int context_length = kClipContextLength);

  int contextLength() const { return context_length_; }
  const Vocabulary& vocabulary() const { return vocabulary_; }

  /// Each row: start, the text's tokens, end, zeros. A text that is too long loses its last tokens,
  /// not the end mark. An empty text is start and end only.
  /// @throws std::invalid_argument naming the text (by number) if it is not valid UTF-8.
  TokenMatrix tokenize(const std::vector<std::string>& utf8_texts) const;

 private:
  std::vector<TokenId> encode(const std::string& utf8_text) const;
  std::vector<TokenId> encodeWord(const std::string& word) const;

  Vocabulary vocabulary_;
  int context_length_;
};

}  // namespace tsg::language
