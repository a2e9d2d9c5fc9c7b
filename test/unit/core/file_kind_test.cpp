// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/file_kind.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support.h"

namespace tsg {
namespace {

TEST(FileKind, IsToldByTheFirstBytes) {
  const std::pair<std::string, const char*> cases[] = {
      {"", "is empty"},
      {"\x1f\x8b\x08", "gzip"},
      {"PK\x03\x04 and more", "zip archive"},
      {"version https://git-lfs.github.com/spec/v1\noid", "Git LFS"},
      {"\n <!DOCTYPE HTML><html>", "web page"},
      {"<?xml version=\"1.0\"?><net name=\"x\">", "XML"},
      {"#ROSBAG V2.0\n", "ROS bag"},
      {"\xff\xfe{", "UTF-16"},
      {std::string("\x1c\0\0\0TFL3", 8), "TensorFlow Lite"}};
  for (const auto& [bytes, words] : cases) {
    EXPECT_NE(describeFirstBytes(bytes).find(words), std::string::npos)
        << words << " is not in: " << describeFirstBytes(bytes);
  }
}

TEST(FileKind, NothingIsSaidOfWhatIsNotKnown) {
  for (const char* text :
       {"{}", "[1, 2]", "\xef\xbb\xbf{}", "name: a", "\x08\x08\x12\x07pytorch"}) {
    EXPECT_EQ(describeFirstBytes(text), "") << text;
  }
}

TEST(FileKind, FoldersAndFilesThatCannotBeOpenedAreTold) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(describeFileKind(folder.path()), "is a folder");
  EXPECT_EQ(describeFileKind(folder.path() / "no_such_file"), "cannot be opened");
  std::ofstream(folder.path() / "empty.json");
  EXPECT_EQ(describeFileKind(folder.path() / "empty.json"), "is empty");
}

}  // namespace
}  // namespace tsg
