// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/language/vocabulary.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <sstream>

#include "test_vocabulary.h"

namespace tsg::language {
namespace {

using Tokens = std::vector<TokenId>;

constexpr const char* kSmall = "#version\na b\nab c</w>\nb c\nc c</w>\nabc</w> x\n";
// Tokens of letters: printable bytes are numbered from '!' on.
constexpr TokenId tokenOf(char letter) { return letter - '!'; }
constexpr TokenId lastTokenOf(char letter) { return 256 + letter - '!'; }

class VocabularyFile : public ::testing::Test {
 protected:
  std::string write(const std::string& content) {
    const auto path = folder_.path() / "vocabulary.txt";
    test::writeFile(path, content);
    return path.string();
  }

  std::string writePacked(const std::string& content, std::size_t lost_bytes) {
    const std::filesystem::path path = write(content) + ".gz";
    std::filesystem::remove(path);
    EXPECT_EQ(std::system(("gzip " + path.parent_path().string() + "/vocabulary.txt").c_str()), 0);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - lost_bytes);
    return path.string();
  }

  static std::string messageOf(const std::string& path, std::size_t num_merges) {
    try {
      Vocabulary::load(path, num_merges);
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos)
          << "path missing: " << e.what();
      return e.what();
    }
    return "no exception";
  }

 private:
  tsg::test::TemporaryFolder folder_;
};

TEST_F(VocabularyFile, MergesAreAppliedInTheFilesOrder) {
  const Vocabulary vocabulary = Vocabulary::load(write(kSmall), 4);
  EXPECT_EQ(vocabulary.startOfText(), 516);
  EXPECT_EQ(vocabulary.endOfText(), 517);
  EXPECT_EQ(vocabulary.size(), 518U);
  EXPECT_EQ(vocabulary.encodeWord("abc"), Tokens({513}));
  EXPECT_EQ(vocabulary.encodeWord("bc"), Tokens({tokenOf('b'), lastTokenOf('c')}));
  EXPECT_EQ(vocabulary.encodeWord("abca"), Tokens({512, tokenOf('c'), lastTokenOf('a')}));
  EXPECT_EQ(vocabulary.encodeWord("bca"), Tokens({514, lastTokenOf('a')}));
  EXPECT_EQ(vocabulary.encodeWord("ccc"), Tokens({tokenOf('c'), 515}));
  EXPECT_EQ(vocabulary.encodeWord("c"), Tokens({lastTokenOf('c')}));
  EXPECT_EQ(vocabulary.encodeWord(""), Tokens());
}

TEST_F(VocabularyFile, APairInARunOfThreeIsMergedFromTheLeft) {
  const Vocabulary vocabulary = Vocabulary::load(write("#version\na a\n"), 1);
  EXPECT_EQ(vocabulary.encodeWord("aaab"), Tokens({512, tokenOf('a'), lastTokenOf('b')}));
}

TEST_F(VocabularyFile, PackedAndUnpackedFilesAreTheSame) {
  const Vocabulary packed = Vocabulary::load(writePacked(kSmall, 0), 4);
  EXPECT_EQ(packed.encodeWord("abc"), Tokens({513}));
}

TEST_F(VocabularyFile, BytesThatAreNotPrintableHaveTheLastByteTokens) {
  const Vocabulary vocabulary = Vocabulary::load(write(kSmall), 4);
  EXPECT_EQ(vocabulary.encodeWord(std::string("\xa1\xad\x00", 3)),
            Tokens({'~' - '!' + 1, 255, 256 + 188}));
}

TEST_F(VocabularyFile, AbsentFileIsNamed) {
  EXPECT_NE(messageOf("/no/such/vocabulary", 4).find("No such file"), std::string::npos);
}

TEST_F(VocabularyFile, TooFewMergesAreReported) {
  EXPECT_NE(messageOf(write(kSmall), 6).find("has 5 merges, expected 6"), std::string::npos);
}

TEST_F(VocabularyFile, TruncatedPackedFileIsReported) {
  EXPECT_NE(messageOf(writePacked(kSmall, 9), 4).find("truncated"), std::string::npos);
}

TEST_F(VocabularyFile, LinesThatAreNoMergeAreReportedByNumber) {
  EXPECT_NE(messageOf(write("#version\na b\nab\n"), 2).find("line 3 'ab' is not a pair"),
            std::string::npos);
  EXPECT_NE(messageOf(write("#version\nab c\n"), 1).find("line 2 'ab c' merges what is no token"),
            std::string::npos);
  EXPECT_NE(messageOf(write("#version\na b\na b\n"), 2).find("line 3 'a b' is there twice"),
            std::string::npos);
}

/// Undoes the encoding of ASCII words, from the file's lines alone.
std::string spell(const std::string& text, const Tokens& tokens) {
  std::istringstream lines(text);
  std::string line, left, right, word;
  std::vector<std::string> names;
  std::getline(lines, line);
  while (lines >> left >> right) names.push_back(left + right);
  for (const TokenId token : tokens) {
    std::string name = token < 512 ? std::string(1, static_cast<char>('!' + token % 256))
                                   : names[static_cast<std::size_t>(token - 512)];
    if (const auto end = name.find("</w>"); end != std::string::npos) name.resize(end);
    word += name;
  }
  return word;
}

TEST_F(VocabularyFile, TokensSpellTheWordTheyEncode) {
  const Vocabulary vocabulary = Vocabulary::load(write(kSmall), 5);
  std::mt19937 generator(3);
  for (int i = 0; i < 500; ++i) {
    std::string word(1 + generator() % 12, ' ');
    for (char& letter : word) letter = "abcx"[generator() % 4];
    EXPECT_EQ(spell(kSmall, vocabulary.encodeWord(word)), word);
  }
}

TEST(ClipVocabulary, HasTheKnownSize) {
  TSG_REQUIRE_VOCABULARY(path);
  const Vocabulary vocabulary = Vocabulary::load(path);
  EXPECT_EQ(vocabulary.size(), 49408U);
  EXPECT_EQ(vocabulary.startOfText(), 49406);
}

}  // namespace
}  // namespace tsg::language
