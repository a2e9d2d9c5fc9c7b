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

/// Command line of a program that runs nodelets.
struct NodeletProgram {
  std::string node_name;
  std::string usage;  ///< printed for --help
  std::vector<NodeletSpec> nodelets;
};

/// A main program: a nodelet manager that loads the nodelets given, in the order of the chain, and
/// runs until SIGINT, SIGTERM or a shutdown from the master. On a signal, while ROS is still up, it
/// calls `finish` of its stages in order, each told what the one before has published, so that
/// nothing in the chain is lost; then the nodelets are unloaded, last stage first, and write their
/// files; one line says which, or why none. Other nodelets (a camera driver) can be loaded into it
/// as into any manager. Without a master it waits for one; a signal ends it then, too.
/// @param options  what may be on the command line besides --help and ROS's own words; the
/// nodelets get the whole command line
/// Returns the program's exit status: 0; 1 if a nodelet did not load, or if files were asked for
/// and not written; 2 for an option that is not known; 128 and the signal if it came before all
/// were loaded.
int runNodelets(int argc, char** argv, const NodeletProgram& program,
                const std::vector<std::string>& options = {});

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
