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
/// @param positions  what words without an option are. With any, words that begin with '-' and a
/// digit are numbers below zero, so that options have no short form but -h.
/// @throws boost::program_options::error naming an option that is unknown, missing or unreadable;
/// for words that are none of its options.
inline bool parseOptions(
    int argc, char** argv, const boost::program_options::options_description& description,
    const boost::program_options::positional_options_description& positions = {}) {
  namespace options = boost::program_options;
  using Style = options::command_line_style::style_t;
  const bool has_positions = positions.max_total_count() > 0;
  const bool is_help = has_positions && argc == 2 && std::string(argv[1]) == "-h";
  const int style = Style::unix_style & ~(has_positions ? Style::allow_short : 0);
  options::variables_map values;
  if (!is_help) {
    options::store(options::command_line_parser(argc, argv)
                       .options(description)
                       .positional(positions)
                       .style(style)
                       .run(),
                   values);
  }
  if (is_help || values.count("help") > 0) {
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
