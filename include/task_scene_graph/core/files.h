// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace tsg {

/// Writes a file so that it is there whole or not at all: `write` fills a temporary file in the
/// same folder, which is flushed to the disk and renamed to `path`. Parent folders are made.
/// @throws std::runtime_error naming the path and the system's reason; the temporary file is
/// removed.
void writeFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write);

}  // namespace tsg
