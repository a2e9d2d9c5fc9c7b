// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/program_options.hpp>
#include <exception>
#include <iostream>
#include <string>

#include "task_scene_graph/core/files.h"

/// What the programs with options have in common.
namespace tsg::tools {

/// An option whose value is a path, see expandPath(); relative ones begin at the current folder.
inline boost::program_options::typed_value<std::string>* pathOption(std::string& path) {
  return boost::program_options::value<std::string>()->value_name("PATH")->notifier(
      [&path](const std::string& text) { path = expandPath(text).string(); });
}

/// Stores what the command line gives into what `description` names. False if only help was asked
/// for, which is then printed.
/// @throws boost::program_options::error naming an option that is unknown, missing or unreadable.
inline bool parseOptions(int argc, char** argv,
                         const boost::program_options::options_description& description) {
  namespace options = boost::program_options;
  options::variables_map values;
  options::store(options::parse_command_line(argc, argv, description), values);
  if (values.count("help") > 0) {
    std::cout << description << '\n';
    return false;
  }
  options::notify(values);
  return true;
}

/// Exit status of `parse(argc, argv)`, an optional that is empty where only help was asked for, and
/// `run` of its value: 2 after a wrong command line, 1 after any other exception.
template <typename Parse, typename Run>
int runProgram(const char* name, int argc, char** argv, const Parse& parse, const Run& run) {
  try {
    if (const auto arguments = parse(argc, argv)) run(*arguments);
    return 0;
  } catch (const boost::program_options::error& e) {
    std::cerr << name << ": " << e.what() << " (see " << name << " --help)\n";
    return 2;
  } catch (const std::exception& e) {
    std::cerr << name << ": " << e.what() << '\n';
    return 1;
  }
}

}  // namespace tsg::tools
