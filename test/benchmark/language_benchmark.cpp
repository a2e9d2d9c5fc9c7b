// SPDX-License-Identifier: BSD-3-Clause
// What turning words into tokens costs, apart from the network that reads them.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "task_scene_graph/language/text_cleaning.h"
#include "task_scene_graph/language/tokenizer.h"

namespace tsg::language {
namespace {

const std::vector<std::string> kTasks = {
    "wash the dishes",       "get my notes and books",    "something to sit on while reading",
    "caf&eacute; &amp; bar", "the dog's bowl, 2 of them", "clean the “green” mug",
};

void countTexts(benchmark::State& state) {
  state.counters["texts/s"] = benchmark::Counter(static_cast<double>(kTasks.size()),
                                                 benchmark::Counter::kIsIterationInvariantRate);
}

void loadVocabulary(benchmark::State& state) {
  const auto path = findInstalledVocabulary();
  if (!path) return state.SkipWithError("CLIP's vocabulary is not here");
  for (auto _ : state) benchmark::DoNotOptimize(Vocabulary::load(*path));
}

void cleanTexts(benchmark::State& state) {
  for (auto _ : state) {
    for (const auto& task : kTasks) benchmark::DoNotOptimize(cleanText(task));
  }
  countTexts(state);
}

void tokenizeTexts(benchmark::State& state) {
  const auto path = findInstalledVocabulary();
  if (!path) return state.SkipWithError("CLIP's vocabulary is not here");
  const Tokenizer tokenizer(Vocabulary::load(*path));
  for (auto _ : state) benchmark::DoNotOptimize(tokenizer.tokenize(kTasks));
  countTexts(state);
}

/// The worst case of byte pair encoding: one word of this many letters.
void tokenizeLongWord(benchmark::State& state) {
  const auto path = findInstalledVocabulary();
  if (!path) return state.SkipWithError("CLIP's vocabulary is not here");
  const Tokenizer tokenizer(Vocabulary::load(*path));
  std::string word;
  for (int i = 0; i < state.range(0); ++i) word += static_cast<char>('a' + i * i % 26);
  for (auto _ : state) benchmark::DoNotOptimize(tokenizer.tokenize({word}));
}

BENCHMARK(loadVocabulary)->Unit(benchmark::kMillisecond);
BENCHMARK(cleanTexts)->Unit(benchmark::kMicrosecond);
BENCHMARK(tokenizeTexts)->Unit(benchmark::kMicrosecond);
BENCHMARK(tokenizeLongWord)->Arg(100)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tsg::language

BENCHMARK_MAIN();
