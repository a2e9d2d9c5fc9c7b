// SPDX-License-Identifier: BSD-3-Clause
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <stdexcept>

#include "task_scene_graph/core/files.h"

namespace tsg {
namespace fs = std::filesystem;
namespace {

constexpr const char* kFileScheme = "file://";

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw std::invalid_argument("path '" + text + "': " + why);
}

bool isNameStart(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool isNamePart(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The bytes that %41 and the like stand for.
std::string decodePercent(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_code = text[i] == '%' && i + 2 < text.size() &&
                         std::isxdigit(static_cast<unsigned char>(text[i + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(text[i + 2])) != 0;
    decoded += is_code ? static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16)) : text[i];
    if (is_code) i += 2;
  }
  return decoded;
}

std::string removeScheme(const std::string& text) {
  const std::size_t end = text.find("://");
  const bool has_scheme =
      end != std::string::npos && end > 0 && text.find_first_of("/~$") == end + 1;
  if (!has_scheme) return text;
  if (text.rfind(kFileScheme, 0) != 0) {
    refuse(text, "expected a path or file://..., not '" + text.substr(0, end) + "://'");
  }
  std::string path = text.substr(end + 3);
  if (path.rfind("localhost/", 0) == 0) path.erase(0, std::string("localhost").size());
  return decodePercent(path);
}

/// The value of the variable that begins at text[begin], just behind its dollar sign; `begin` is
/// moved behind its name.
std::string readVariable(const std::string& text, std::size_t& begin) {
  const bool is_braced = text[begin] == '{';
  std::size_t end = begin + (is_braced ? 1 : 0);
  const std::size_t start = end;
  while (end < text.size() && (is_braced ? text[end] != '}' : isNamePart(text[end]))) ++end;
  if (is_braced && end == text.size()) refuse(text, "'${' is not closed by '}'");
  const std::string name = text.substr(start, end - start);
  const char* value = std::getenv(name.c_str());
  if (value == nullptr) refuse(text, "the environment variable '" + name + "' is not set");
  begin = end + (is_braced ? 1 : 0);
  return value;
}

std::string replaceVariables(const std::string& text) {
  if (text.find("$(") != std::string::npos) {
    refuse(text, "substitutions like $(find ...) are known in launch files only");
  }
  std::string replaced;
  for (std::size_t i = 0; i < text.size();) {
    const bool is_variable =
        text[i] == '$' && i + 1 < text.size() && (isNameStart(text[i + 1]) || text[i + 1] == '{');
    if (is_variable) {
      replaced += readVariable(text, ++i);
    } else {
      replaced += text[i++];
    }
  }
  return replaced;
}

std::string findHome(const std::string& user, const std::string& text) {
  const char* home = std::getenv("HOME");
  if (user.empty() && home != nullptr && *home != '\0') return home;
  const passwd* entry = user.empty() ? getpwuid(getuid()) : getpwnam(user.c_str());
  if (entry == nullptr || entry->pw_dir == nullptr) {
    refuse(text, user.empty() ? "HOME is not set" : "there is no user '" + user + "'");
  }
  return entry->pw_dir;
}

std::string replaceHome(const std::string& text) {
  if (text.empty() || text[0] != '~') return text;
  const std::size_t end = std::min(text.find('/'), text.size());
  return findHome(text.substr(1, end - 1), text) + text.substr(end);
}

}  // namespace

fs::path expandPath(const std::string& text, const fs::path& folder) {
  if (text.empty()) return {};
  const fs::path path = replaceVariables(replaceHome(removeScheme(text)));
  const fs::path base = folder.empty() ? fs::current_path() : fs::absolute(folder);
  const fs::path whole = (base / path).lexically_normal();
  return whole.has_filename() || whole == whole.root_path() ? whole : whole.parent_path();
}

}  // namespace tsg
