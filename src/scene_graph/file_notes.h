// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tsg::scene_graph {

/// Items of a file that went another way than the rest, by number and the first few by name.
class FileNote {
 public:
  void add(const std::string& item) {
    if (++count_ <= kMostNamed) first_items_.push_back(item);
  }
  std::size_t count() const { return count_; }

  /// "a; b; c and 7 more"
  std::string listItems() const {
    std::string text;
    for (const std::string& item : first_items_) text += (text.empty() ? "" : "; ") + item;
    if (count_ > kMostNamed) text += " and " + std::to_string(count_ - kMostNamed) + " more";
    return text;
  }

 private:
  static constexpr std::size_t kMostNamed = 5;
  std::size_t count_ = 0;
  std::vector<std::string> first_items_;
};

}  // namespace tsg::scene_graph
