// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

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
  bool has_map_owner = false;  ///< the last one is the scene graph: it writes the map
};

/// A main program: a nodelet manager that loads the nodelets given, in the order of the chain, and
/// runs until SIGINT, SIGTERM or a shutdown from the master. On a signal, while ROS is still up,
/// the chain is flushed (Flush.srv, END) so that nothing in it is lost, and the map written, within
/// the 15 s that roslaunch gives: by the scene graph's process for all stages, wherever they run; a
/// process of other stages flushes its own and stays until that one is done. Then the nodelets are
/// unloaded, last stage first; one line says which files were written, or why none. Other nodelets
/// (a camera driver) can be loaded into it as into any manager. Without a master it waits for one;
/// a signal ends it then, too.
/// @param options  what may be on the command line besides --help and ROS's own words; the
/// nodelets get the whole command line
/// Returns the program's exit status: 0; 1 if a nodelet did not load, or if files were asked for
/// and not written; 2 for an option that is not known; 128 and the signal if it came before all
/// were loaded.
int runNodelets(int argc, char** argv, const NodeletProgram& program,
                const std::vector<std::string>& options = {});

}  // namespace tsg::ros_interface
