// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/map/folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <thread>

#include "support.h"
#include "task_scene_graph/core/files.h"

namespace tsg::map {
namespace {

namespace fs = std::filesystem;

std::string readAll(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void writeAll(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::set<std::string> listFiles(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) names.insert(entry.path().lexically_relative(folder).string());
  }
  return names;
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

ManifestHead makeHead(const std::string& frame = "odom") {
  ManifestHead head;
  head.world_frame = frame;
  head.model_set = "clip";
  head.embedding_size = 512;
  return head;
}

void save(const fs::path& folder, const std::map<std::string, std::string>& files,
          OtherFiles others = OtherFiles::kRemove) {
  replaceFiles(folder, makeHead(), [&](const fs::path& to) {
    for (const auto& [name, text] : files) writeAll(to / name, text);
    return others;
  });
}

/// All files of a map say the same number.
void saveNumber(const fs::path& folder, int number, int num_files = 20) {
  std::map<std::string, std::string> files;
  for (int i = 0; i < num_files; ++i) {
    files["state/file_" + std::to_string(i)] = std::to_string(number);
  }
  save(folder, files);
}

/// The number that all files of the map say; -1 if they differ or one is not there.
int readNumber(const fs::path& folder) {
  const Manifest manifest = readManifest(folder);
  checkFiles(folder, manifest);
  std::set<std::string> numbers;
  for (const auto& [name, record] : manifest.files)
    numbers.insert(readAll(locateFile(folder, name)));
  return numbers.size() == 1 ? std::stoi(*numbers.begin()) : -1;
}

TEST(MapFolder, TheManifestNamesWhatTheMapIsAndItsFiles) {
  const test::TemporaryFolder folder;
  ManifestHead head = makeHead();
  head.newest_ns = 77;
  MapSource source;
  source.name = "upstairs";
  source.T_map_source.translation() = Eigen::Vector3d(1, 2, 3);
  source.primitive_id_offset = 10;
  source.place_id_offset = 20;
  source.max_primitive_id = 15;
  head.sources = {source};
  replaceFiles(folder.path() / "map", head, [](const fs::path& to) {
    writeAll(to / "state/a.bin", "123456789");
    return OtherFiles::kRemove;
  });
  const Manifest manifest = readManifest(folder.path() / "map");
  EXPECT_EQ(manifest.head.world_frame, "odom");
  EXPECT_EQ(manifest.head.model_set, "clip");
  EXPECT_EQ(manifest.head.embedding_size, 512);
  EXPECT_EQ(manifest.head.newest_ns, 77);
  ASSERT_EQ(manifest.head.sources.size(), 1U);
  EXPECT_EQ(manifest.head.sources[0].name, "upstairs");
  EXPECT_EQ(manifest.head.sources[0].T_map_source.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(manifest.head.sources[0].max_primitive_id, 15U);
  ASSERT_EQ(manifest.files.size(), 1U);
  EXPECT_EQ(manifest.files.at("state/a.bin").bytes, 9U);
  EXPECT_EQ(manifest.files.at("state/a.bin").crc32, 0xCBF43926U);
}

TEST(MapFolder, FilesOfTheMapOfBeforeGoAndThoseOfOthersStay) {
  const test::TemporaryFolder folder;
  save(folder.path(), {{"state/a", "1"}, {"floor_1.pgm", "1"}, {"thumbnails/O1.png", "1"}});
  writeAll(folder.path() / "notes.txt", "mine");
  save(folder.path(), {{"state/a", "2"}});
  EXPECT_EQ(listFiles(folder.path()), (std::set<std::string>{"map.json", "notes.txt", "state/a"}));
  EXPECT_FALSE(fs::exists(folder.path() / "thumbnails"));
  EXPECT_EQ(readAll(folder.path() / "state/a"), "2");
}

TEST(MapFolder, FilesThatAreKeptStayPartOfTheMap) {
  const test::TemporaryFolder folder;
  save(folder.path(), {{"state/a", "1"}, {"mesh.ply", "1"}});
  save(folder.path(), {{"state/a", "2"}}, OtherFiles::kKeep);
  EXPECT_EQ(listFiles(folder.path()), (std::set<std::string>{"map.json", "mesh.ply", "state/a"}));
  EXPECT_EQ(readManifest(folder.path()).files.count("mesh.ply"), 1U);
}

TEST(MapFolder, WhereWritingFailsTheMapOfBeforeStays) {
  const test::TemporaryFolder folder;
  saveNumber(folder.path(), 1);
  const auto before = listFiles(folder.path());
  const std::string error = errorOf([&] {
    replaceFiles(folder.path(), makeHead("other"), [](const fs::path& to) -> OtherFiles {
      writeAll(to / "state/file_0", "2");
      throw std::runtime_error("no more paper");
    });
  });
  EXPECT_EQ(error, "no more paper");
  EXPECT_EQ(listFiles(folder.path()), before);
  EXPECT_EQ(readNumber(folder.path()), 1);
  EXPECT_EQ(readManifest(folder.path()).head.world_frame, "odom");
}

TEST(MapFolder, WhereTheDiskIsFullTheMapOfBeforeStays) {
  const test::TemporaryFolder folder;
  saveNumber(folder.path(), 1);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 1000;  // no file may be larger: writing fails as on a full disk
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string error = errorOf([&] {
    replaceFiles(folder.path(), makeHead(), [](const fs::path& to) {
      writeFileAtomically(to / "state/file_0",
                          [](std::ostream& out) { out << std::string(100000, 'x'); });
      return OtherFiles::kRemove;
    });
  });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(error.find("state/file_0"), std::string::npos) << error;
  EXPECT_EQ(readNumber(folder.path()), 1);
}

TEST(MapFolder, WhateverMomentTheWriterIsKilledAtTheMapIsWhole) {
  const test::TemporaryFolder folder;
  const fs::path map = folder.path() / "map";
  saveNumber(map, 0);
  std::mt19937 random(3);
  std::set<int> seen;
  for (int round = 0; round < 60; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      for (int number = 1000 * round + 1;; ++number) saveNumber(map, number);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 40000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const int number = readNumber(map);  // also throws if anything is missing
    EXPECT_GE(number, 0) << "round " << round;
    seen.insert(number);
    if (round % 3 == 0) saveNumber(map, 1000 * round + 999);
  }
  EXPECT_GT(seen.size(), 3U);
  saveNumber(map, 7);
  EXPECT_EQ(readNumber(map), 7);
  for (const auto& entry : fs::directory_iterator(map)) {
    EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path();
  }
}

/// The map that is ready but for k of its files is interrupted at each of these steps.
TEST(MapFolder, AnInterruptedMoveIsReadAsTheNewMapAndFinishedByTheNextSave) {
  for (int moved = 0; moved <= 3; ++moved) {
    const test::TemporaryFolder folder;
    saveNumber(folder.path(), 1, 4);
    const test::TemporaryFolder other;
    saveNumber(other.path(), 2, 3);
    const fs::path ready = folder.path() / ".saved";
    fs::create_directories(ready / "state");
    for (const std::string& name : listFiles(other.path())) {
      fs::copy_file(other.path() / name, ready / name);
    }
    for (int i = 0; i < moved; ++i) {
      const std::string name = "state/file_" + std::to_string(i);
      fs::rename(ready / name, folder.path() / name);
    }
    EXPECT_EQ(readNumber(folder.path()), 2) << moved;
    save(folder.path(), {{"extra", "3"}}, OtherFiles::kKeep);
    EXPECT_EQ(listFiles(folder.path()), (std::set<std::string>{"extra", "map.json", "state/file_0",
                                                               "state/file_1", "state/file_2"}));
  }
}

TEST(MapFolder, WritersWaitForOneAnother) {
  const test::TemporaryFolder folder;
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i) {
    writers.emplace_back([&, i] {
      for (int k = 0; k < 5; ++k) saveNumber(folder.path(), 10 * i + k);
    });
  }
  for (auto& writer : writers) writer.join();
  EXPECT_GE(readNumber(folder.path()), 0);
}

TEST(MapFolder, WhatIsNoMapIsNamed) {
  const test::TemporaryFolder folder;
  const auto error = [&](const fs::path& path) { return errorOf([&] { readManifest(path); }); };
  EXPECT_NE(error(folder.path() / "nowhere").find("nowhere' is not there"), std::string::npos);
  EXPECT_NE(error(folder.path()).find("has no map.json"), std::string::npos);
  const std::pair<const char*, const char*> bad[] = {
      {"", "parse error"},
      {"[]", "no manifest"},
      {"{\"format\": \"something else\"}", "no manifest"},
      {"{\"format\": \"task_scene_graph map\", \"version\": 2}", "version 2, expected 1"},
      {"{\"format\": \"task_scene_graph map\", \"version\": 1}", "frame"}};
  for (const auto& [text, what] : bad) {
    writeAll(folder.path() / "map.json", text);
    EXPECT_NE(error(folder.path()).find(what), std::string::npos) << error(folder.path());
    EXPECT_NE(error(folder.path()).find("map.json"), std::string::npos);
  }
  writeAll(folder.path() / "map.json", std::string(100000, '['));
  EXPECT_NE(error(folder.path()).find("nested"), std::string::npos);
}

TEST(MapFolder, AFileOutsideTheFolderIsRefused) {
  const test::TemporaryFolder folder;
  save(folder.path(), {{"state/a", "1"}});
  std::string text = readAll(folder.path() / "map.json");
  text.replace(text.find("state/a"), 7, "../../a");
  writeAll(folder.path() / "map.json", text);
  const std::string error = errorOf([&] { readManifest(folder.path()); });
  EXPECT_NE(error.find("../../a"), std::string::npos) << error;
}

TEST(MapFolder, DamagedStateIsNamedAndEditedFilesAreTold) {
  const test::TemporaryFolder folder;
  save(folder.path(), {{"state/a", "1234"}, {"scene_graph.json", "{}"}});
  const Manifest manifest = readManifest(folder.path());
  EXPECT_TRUE(checkFiles(folder.path(), manifest).empty());
  writeAll(folder.path() / "scene_graph.json", "{ }");
  EXPECT_EQ(checkFiles(folder.path(), manifest), std::vector<std::string>{"scene_graph.json"});
  writeAll(folder.path() / "state/a", "1235");
  const std::string damaged = errorOf([&] { checkFiles(folder.path(), manifest); });
  EXPECT_NE(damaged.find("state/a' is damaged"), std::string::npos) << damaged;
  fs::remove(folder.path() / "state/a");
  const std::string missing = errorOf([&] { checkFiles(folder.path(), manifest); });
  EXPECT_NE(missing.find("state/a' is not there"), std::string::npos) << missing;
}

}  // namespace
}  // namespace tsg::map
