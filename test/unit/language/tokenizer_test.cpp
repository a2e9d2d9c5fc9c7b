// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/tokenizer.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "test_vocabulary.h"

namespace tsg::language {
namespace {

using Tokens = std::vector<TokenId>;

/// One line of tokens.json, which test/support/record_tokens.py writes.
struct Recording {
  std::string text;
  Tokens tokens;              ///< without the zeros at the end
  std::string why_different;  ///< empty unless our tokenizer knowingly differs
};

std::vector<Recording> loadRecordings() {
  std::ifstream file(TSG_SOURCE_DIR "/test/unit/language/tokens.json");
  const nlohmann::json root = nlohmann::json::parse(file);
  std::vector<Recording> recordings;
  for (const auto& entry : root.at("texts")) {
    recordings.push_back({entry.at("text"), entry.at("tokens"), entry.value("differs", "")});
  }
  return recordings;
}

Tokens toTokens(const TokenMatrix& row) { return {row.data(), row.data() + row.size()}; }

Tokens pad(Tokens tokens) {
  tokens.resize(kClipContextLength, 0);
  return tokens;
}

TEST(TokenizerIds, EqualThoseOfOpenClip) {
  TSG_REQUIRE_VOCABULARY(path);
  const Tokenizer tokenizer(Vocabulary::load(path));
  int num_compared = 0;
  for (const Recording& recording : loadRecordings()) {
    if (!recording.why_different.empty()) continue;
    EXPECT_EQ(toTokens(tokenizer.tokenize({recording.text})), pad(recording.tokens))
        << "text: " << nlohmann::json(recording.text).dump(-1, ' ', true);
    ++num_compared;
  }
  EXPECT_GE(num_compared, 250);
}

// Fails when a deviation has gone: then its text belongs to the others.
TEST(TokenizerIds, DifferFromOpenClipOnlyWhereDocumented) {
  TSG_REQUIRE_VOCABULARY(path);
  const Tokenizer tokenizer(Vocabulary::load(path));
  int num_different = 0;
  for (const Recording& recording : loadRecordings()) {
    if (recording.why_different.empty()) continue;
    EXPECT_NE(toTokens(tokenizer.tokenize({recording.text})), pad(recording.tokens))
        << recording.text << ": no " << recording.why_different << " any more?";
    ++num_different;
  }
  EXPECT_EQ(num_different, 11);
}

TEST(TokenizerIds, OfABatchEqualThoseOneByOne) {
  TSG_REQUIRE_VOCABULARY(path);
  const Tokenizer tokenizer(Vocabulary::load(path));
  const std::vector<std::string> texts = {"a mug", "", "two books on a shelf"};
  const TokenMatrix batch = tokenizer.tokenize(texts);
  ASSERT_EQ(batch.rows(), 3);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_EQ(TokenMatrix(batch.row(static_cast<Eigen::Index>(i))), tokenizer.tokenize({texts[i]}));
  }
}

class SmallTokenizer : public ::testing::Test {
 protected:
  Tokenizer make(int context_length) {
    const auto path = folder_.path() / "vocabulary.txt";
    test::writeFile(path, "#version\na b\nab c</w>\n");
    return Tokenizer(Vocabulary::load(path.string(), 2), context_length);
  }

 private:
  tsg::test::TemporaryFolder folder_;
};

TEST_F(SmallTokenizer, EmptyTextIsStartAndEnd) {
  EXPECT_EQ(toTokens(make(4).tokenize({" \n"})), Tokens({514, 515, 0, 0}));
  EXPECT_EQ(make(4).tokenize({}).rows(), 0);
  EXPECT_EQ(make(4).tokenize({}).cols(), 4);
}

TEST_F(SmallTokenizer, TextThatFitsExactlyKeepsItsLastToken) {
  EXPECT_EQ(toTokens(make(4).tokenize({"abc abc"})), Tokens({514, 513, 513, 515}));
}

TEST_F(SmallTokenizer, LongerTextEndsWithTheEndMark) {
  EXPECT_EQ(toTokens(make(4).tokenize({"abc abc abc"})), Tokens({514, 513, 513, 515}));
  EXPECT_EQ(toTokens(make(2).tokenize({"abc"})), Tokens({514, 515}));
}

TEST_F(SmallTokenizer, InvalidUtf8IsReportedWithTheTextsNumber) {
  try {
    make(8).tokenize({"fine", "caf\xe9"});
    FAIL() << "expected an exception";
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "text 2: text of 4 bytes is not valid UTF-8");
  }
}

TEST_F(SmallTokenizer, ContextWithoutRoomForBothMarksIsRefused) {
  EXPECT_THROW(make(1), std::invalid_argument);
}

}  // namespace
}  // namespace tsg::language
