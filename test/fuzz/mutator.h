// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

namespace tsg::fuzz {

/// Makes faults in inputs. The same seed gives the same faults on every machine.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  /// In [0, count); count > 0.
  std::size_t pick(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  bool isOneIn(std::size_t count) { return pick(count) == 0; }
  template <typename T>
  const T& pickFrom(const std::vector<T>& values) {
    return values[pick(values.size())];
  }

  /// A number's text that readers trip over: too large, too small, not finite, not quite a number.
  const std::string& pickNumber();
  /// A double of the same kinds.
  double pickDouble();
  /// An integer at the edge of some type, or a small one.
  std::uint64_t pickInteger();

  /// One to four of: bytes changed, taken away, put in or doubled; the end cut off; a number or a
  /// word put in; four or eight bytes that are an extreme number; brackets nested deeply.
  /// @param words  what may be put in besides
  void mutateBytes(const std::vector<std::string>& words, std::string& text);
  /// One to four of: lines doubled, taken away, indented or moved; values and keys replaced.
  void mutateYaml(std::string& text);
  /// One to four values replaced, taken away or put in elsewhere.
  void mutateJson(nlohmann::json& root);

 private:
  void mutateOnce(const std::vector<std::string>& words, std::string& text);
  void nest(std::string& text);
  void replaceNumber(std::string& text);
  void overwriteNumber(std::string& bytes);
  void mutateLine(std::vector<std::string>& lines);
  void mutateValue(nlohmann::json& root);

  std::mt19937_64 random_;
};

/// JSON with one fault in three made in its text, the others in its values.
std::string makeJson(Mutator& mutator, nlohmann::json root);
/// YAML with one fault in three made in its bytes, the others in its lines.
std::string makeYaml(Mutator& mutator, std::string text);

}  // namespace tsg::fuzz
