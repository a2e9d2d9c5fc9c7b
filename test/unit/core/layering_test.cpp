// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

namespace tsg {
namespace {
namespace fs = std::filesystem;

// Modules that may know ROS; all others are libraries without ROS.
bool isRosModule(const fs::path& file) {
  const std::string path = file.generic_string();
  for (const char* module : {"/ros/", "/nodelets/", "/rviz/"}) {
    if (path.find(module) != std::string::npos) return true;
  }
  return false;
}

TEST(Layering, TheLibrariesIncludeNoRosHeader) {
  const std::regex ros_include(
      R"(#include\s*[<"](ros|rosbag|nodelet|pluginlib|cv_bridge|tf2?|tf2_\w+|\w+_msgs|std_srvs|message_filters|image_transport|dynamic_reconfigure|diagnostic_updater|task_scene_graph/(ros/|[A-Z]\w*\.h))[/"\w.])");
  int files = 0;
  for (const char* root : {"include", "src"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(TSG_SOURCE_DIR) / root)) {
      if (!entry.is_regular_file() || isRosModule(entry.path())) continue;
      ++files;
      std::ifstream stream(entry.path());
      for (std::string line; std::getline(stream, line);) {
        EXPECT_FALSE(std::regex_search(line, ros_include)) << entry.path() << ": " << line;
      }
    }
  }
  EXPECT_GT(files, 10);
}

TEST(Layering, TheChainIncludesNothingOfTheSimulation) {
  const std::regex simulation_include(R"(#include\s*[<"].*simulation/)");
  int files = 0;
  for (const char* root : {"include", "src"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(TSG_SOURCE_DIR) / root)) {
      const std::string path = entry.path().generic_string();
      const bool may = path.find("/simulation/") != std::string::npos ||
                       path.find("/tools/") != std::string::npos;
      if (!entry.is_regular_file() || may) continue;
      ++files;
      std::ifstream stream(entry.path());
      for (std::string line; std::getline(stream, line);) {
        EXPECT_FALSE(std::regex_search(line, simulation_include)) << path << ": " << line;
      }
    }
  }
  EXPECT_GT(files, 10);
}

}  // namespace
}  // namespace tsg
