// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>
#include <string_view>

#include "task_scene_graph/config/visitor.h"

namespace tsg::scene_graph {

/// JSON text of a value; bytes that are not UTF-8 are replaced, not thrown over.
template <typename Json>
std::string toText(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Writes a JSON object that ends in long lists, one element a line, without holding the lists in
/// memory: construct with the short fields, then beginList, addElement..., endList for each list.
class JsonObjectStream {
 public:
  /// `head` is a JSON object; its closing brace is written by `finish`.
  template <typename Json>
  JsonObjectStream(std::ostream& stream, const Json& head)
      : stream_(stream), has_fields_(!head.empty()) {
    std::string text = toText(head);
    text.pop_back();
    stream_ << text;
  }

  void beginList(const std::string& name) {
    stream_ << (has_fields_ ? ",\n" : "") << '"' << name << "\":[";
    has_fields_ = true;
    has_elements_ = false;
  }
  /// `write(stream)` writes one element.
  template <typename Write>
  void addElementWith(const Write& write) {
    stream_ << (has_elements_ ? ",\n" : "\n");
    has_elements_ = true;
    write(stream_);
  }
  template <typename Json>
  void addElement(const Json& element) {
    addElementWith([&](std::ostream& stream) { stream << toText(element); });
  }
  void endList() { stream_ << ']'; }
  void finish() { stream_ << '}'; }

 private:
  std::ostream& stream_;
  bool has_fields_;
  bool has_elements_ = false;
};

/// Visitor that turns a configuration into a JSON object (see config/visitor.h). The number of
/// threads is left out: files are the same for any.
template <typename Json>
class ConfigJson {
 public:
  Json map = Json::object();

  template <typename T>
  void field(const char* name, const T& value, config::Range, const char*, const char*) {
    if (std::string_view(name) != "num_threads") map[name] = value;
  }
  template <typename Enum>
  void choice(const char* name, const Enum& value, const config::Choices<Enum>& choices,
              const char*) {
    for (const auto& [text, option] : choices) {
      if (option == value) map[name] = text;
    }
  }
  template <typename Config>
  void group(const char* name, const Config& config) {
    ConfigJson inner;
    Config::visit(config, inner);
    map[name] = std::move(inner.map);
  }
};

}  // namespace tsg::scene_graph
