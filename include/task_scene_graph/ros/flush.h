// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/ros/messages.h"
#include "task_scene_graph/ros/patience.h"

namespace tsg::ros_interface {

/// What a row of stages says when it is flushed, see Flush.srv.
struct FlushedStages {
  std::vector<std::string> contents;  ///< "tracker: 12 live tracks", one for each stage
  std::vector<std::string> missing;   ///< one line for each thing that is
  std::vector<std::string> absent;    ///< stages that have no such service
  std::uint64_t sequence = 0;         ///< of the last stage's newest message
  std::uint64_t place_sequence = 0;
};

/// Calls the service `flush` of each stage, in order, telling each what the one before has
/// published; a stage whose service does not exist is passed over, and the next one waits for
/// nothing. What remains of the deadline is each one's timeout.
/// @param mode  of FlushRequest
FlushedStages flushStages(const std::vector<std::string>& stages, std::uint8_t mode,
                          const Patience& patience);

/// Lives while a stage of this process serves somebody who writes the map.
class FlushGuard {
 public:
  FlushGuard();
  ~FlushGuard();
  FlushGuard(const FlushGuard&) = delete;
  FlushGuard& operator=(const FlushGuard&) = delete;
};

/// Waits until the stage that owns the map has ended: its services are gone; or no FlushGuard has
/// lived for 3 s; or the deadline has passed. For a process that holds other stages of the chain.
void waitForMapOwner(const std::string& owner, std::chrono::steady_clock::time_point deadline);

}  // namespace tsg::ros_interface
