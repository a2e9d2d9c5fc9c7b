// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

namespace tsg {

/// Calls `body(i)` for i in [0, count) on at most `num_threads` threads (of OpenCV's pool). Calls
/// must not depend on each other: the result is then the same for any number of threads. An
/// exception from a body is rethrown after the others have stopped.
void parallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body);

}  // namespace tsg
