// SPDX-License-Identifier: BSD-3-Clause
// Names of tasks on their way to tokens: entities, broken encodings, odd spaces.
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/language/text_cleaning.h"
#include "task_scene_graph/language/tokenizer.h"
#include "task_scene_graph/language/vocabulary.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace language = tsg::language;

std::string make(fuzz::Mutator& mutator) {
  static const std::vector<std::string> words{
      "&amp;",        "&#",           "&#x110000;",       "&#xd800;",     "&lt", "\xc3\x83\xc2\xa9",
      "\xe2\x80\x8b", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xef\xbf\xbe", "'s",  "<|endoftext|>",
      "\xcc\x81",     "\xe1\x85\xa1", "&&amp;amp;",       "123"};
  std::string text = mutator.pickFrom(std::vector<std::string>{
      "Wash the dishes &amp; dry them", "na\xc3\xafve caf\xc3\xa9, it's 3 o'clock",
      "\xe6\xb4\x97\xe7\xa2\x97 \xf0\x9f\xa4\x96", "&#65;&#x42;&nbsp;&eacute;"});
  mutator.mutateBytes(words, text);
  return text;
}

const language::Tokenizer& makeTokenizer() {
  static const language::Tokenizer tokenizer = [] {
    const auto path = fuzz::scratchFolder() / "vocabulary.txt";
    fuzz::writeFile(path, "#version: 0.2\ni n\nt h\n");
    return language::Tokenizer(language::Vocabulary::load(path.string(), 2));
  }();
  return tokenizer;
}

void readInput(const std::string& text) {
  const auto tokens = makeTokenizer().tokenize({text});
  if (tokens.minCoeff() < 0 || tokens.maxCoeff() > 515) throw std::logic_error("no such token");
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, {"text", "text 1", make, readInput});
}
