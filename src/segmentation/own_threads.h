// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

namespace tsg::segmentation {

/// Calls `body(i)` for i in [0, count) on at most `num_threads` threads, the caller's among them.
/// The threads are its own, unlike parallelFor's: a network's run takes long, and in the pool that
/// all stages share, another stage's short loop could end up waiting for one. An exception from a
/// body is rethrown after the others have stopped.
void runOnOwnThreads(std::size_t count, int num_threads,
                     const std::function<void(std::size_t)>& body);

}  // namespace tsg::segmentation
