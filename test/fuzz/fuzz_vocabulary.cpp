// SPDX-License-Identifier: BSD-3-Clause
// Vocabulary files, plain and packed, and what their tokenizer makes of texts.
#include <zlib.h>

#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/language/tokenizer.h"
#include "task_scene_graph/language/vocabulary.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace language = tsg::language;

constexpr std::size_t kNumMerges = 5;
const std::string kText = "#version: 0.2\ni n\nt h\na n\nth e</w>\nan d</w>\nin g</w>\n";

std::string pack(const std::string& text) {
  const auto path = fuzz::scratchFolder() / "packed.gz";
  const gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
  return fuzz::readFile(path);
}

std::string make(fuzz::Mutator& mutator) {
  static const std::string packed = pack(kText);
  static const std::vector<std::string> words{"</w>", " ", "\n", "\xff", "\xc4\xa0", "a n\n"};
  std::string text = mutator.isOneIn(4) ? packed : kText;
  mutator.mutateBytes(words, text);
  return text;
}

void readInput(const std::string& path) {
  const language::Tokenizer tokenizer(language::Vocabulary::load(path, kNumMerges));
  const auto tokens = tokenizer.tokenize({"the thing and \xc3\xa9\xf0\x9f\xa4\x96", ""});
  const auto size = static_cast<language::TokenId>(tokenizer.vocabulary().size());
  if (tokens.minCoeff() < 0 || tokens.maxCoeff() >= size) throw std::logic_error("no such token");
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("vocabulary", "vocabulary.txt.gz", make, readInput));
}
