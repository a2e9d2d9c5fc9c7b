// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace tsg {

/// What a file that cannot be read as expected is instead, as far as its first bytes give it away:
/// "is empty", "is packed with gzip; unpack it first", "is a web page; download the file itself",
/// ...; "" if nothing is known.
std::string describeFileKind(const std::filesystem::path& path);

/// The same of a file's first bytes, some 100 of them.
std::string describeFirstBytes(const std::string& first_bytes);

}  // namespace tsg
