// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "task_scene_graph/core/stamp.h"

namespace tsg::ros_interface {

/// One nodelet of a program: its class, and the name under which it runs.
struct NodeletSpec {
  std::string type;  ///< "task_scene_graph/Tracker"
  std::string name;  ///< resolved in the node's namespace; empty = the node's own name
};

/// A main program: a nodelet manager that loads the nodelets given, in the order of the chain, and
/// runs until SIGINT, SIGTERM or a shutdown from the master. On a signal, while ROS is still up, it
/// calls `finish` of its stages in order, each told what the one before has published, so that
/// nothing in the chain is lost; then the nodelets are unloaded, last stage first, and write their
/// files. Other nodelets (a camera driver) can be loaded into it as into any manager.
/// Returns the program's exit status: 1 if a nodelet did not load, else 0.
int runNodelets(int argc, char** argv, const std::string& node_name,
                const std::vector<NodeletSpec>& nodelets);

/// What the last of a row of stages has published when it was finished, see Finish.srv.
struct FinishedStages {
  std::vector<std::string> problems;  ///< one line for each stage that had one
  std::uint64_t last_id = 0;
  Stamp stamp;
};

/// Calls the service `finish` of each stage, in order, telling each what the one before has
/// published; a stage whose service does not exist is passed over.
FinishedStages finishStages(const std::vector<std::string>& stages);

}  // namespace tsg::ros_interface
