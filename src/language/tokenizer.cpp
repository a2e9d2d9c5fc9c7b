// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/tokenizer.h"

#include <algorithm>
#include <stdexcept>

#include "task_scene_graph/language/text_cleaning.h"

namespace tsg::language {

Tokenizer::Tokenizer(Vocabulary vocabulary, int context_length)
    : vocabulary_(std::move(vocabulary)), context_length_(context_length) {
  if (context_length < 2) {
    throw std::invalid_argument("tokenizer: context length is " + std::to_string(context_length) +
                                ", expected at least 2");
  }
}

TokenMatrix Tokenizer::tokenize(const std::vector<std::string>& utf8_texts) const {
  TokenMatrix result = TokenMatrix::Zero(static_cast<Eigen::Index>(utf8_texts.size()),
                                         static_cast<Eigen::Index>(context_length_));
  for (std::size_t i = 0; i < utf8_texts.size(); ++i) {
    try {
      const std::vector<TokenId> tokens = encode(utf8_texts[i]);
      std::copy(tokens.begin(), tokens.end(), result.row(static_cast<Eigen::Index>(i)).data());
    } catch (const std::invalid_argument& e) {
      throw std::invalid_argument("text " + std::to_string(i + 1) + ": " + e.what());
    }
  }
  return result;
}

std::vector<TokenId> Tokenizer::encode(const std::string& utf8_text) const {
  const auto capacity = static_cast<std::size_t>(context_length_ - 1);
  std::vector<TokenId> tokens = {vocabulary_.startOfText()};
  for (const std::string& word : splitWords(cleanText(utf8_text))) {
    const std::vector<TokenId> word_tokens = encodeWord(word);
    tokens.insert(tokens.end(), word_tokens.begin(), word_tokens.end());
    if (tokens.size() >= capacity) break;
  }
  tokens.resize(std::min(tokens.size(), capacity));
  tokens.push_back(vocabulary_.endOfText());
  return tokens;
}

std::vector<TokenId> Tokenizer::encodeWord(const std::string& word) const {
  if (word == "<start_of_text>") return {vocabulary_.startOfText()};
  if (word == "<end_of_text>") return {vocabulary_.endOfText()};
  return vocabulary_.encodeWord(word);
}

}  // namespace tsg::language
