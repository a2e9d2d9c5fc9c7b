// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/binary.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <random>

#include "support.h"

namespace tsg {
namespace {

namespace fs = std::filesystem;

std::string readAll(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void writeAll(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void writeSample(const fs::path& path) {
  writeBinaryFile(path, "sample", 3, [](BinaryWriter& out) {
    out.putString("a name");
    out.putVector(std::vector<float>(1000, 1.5F));
    out.putMatrix(Eigen::VectorXf(Eigen::VectorXf::LinSpaced(5, 0.0F, 1.0F)));
    out.put(std::int64_t{-7});
  });
}

void readSample(const fs::path& path) {
  readBinaryFile(path, "sample", 3, [](BinaryReader& in) {
    EXPECT_EQ(in.getString(), "a name");
    EXPECT_EQ(in.getVector<float>(), std::vector<float>(1000, 1.5F));
    Eigen::VectorXf vector;
    in.getMatrix(vector);
    EXPECT_EQ(vector.size(), 5);
    EXPECT_EQ(in.get<std::int64_t>(), -7);
  });
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(Binary, AFileIsReadAsItWasWritten) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  writeSample(path);
  readSample(path);
  EXPECT_LT(fs::file_size(path), 1000U);  // compressed
}

TEST(Binary, LargeContentIsReadAsItWasWritten) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  std::mt19937 random(5);
  std::vector<std::uint32_t> numbers(500000);
  for (auto& number : numbers) number = static_cast<std::uint32_t>(random());
  writeBinaryFile(path, "numbers", 1, [&](BinaryWriter& out) { out.putVector(numbers); });
  readBinaryFile(path, "numbers", 1,
                 [&](BinaryReader& in) { EXPECT_EQ(in.getVector<std::uint32_t>(), numbers); });
}

TEST(Binary, AnotherKindOrVersionIsNamedWithWhatWasExpected) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  writeSample(path);
  const auto ignore = [](BinaryReader&) {};
  const std::string kind = errorOf([&] { readBinaryFile(path, "meshes", 3, ignore); });
  EXPECT_NE(kind.find(path.string()), std::string::npos) << kind;
  EXPECT_NE(kind.find("'sample', expected 'meshes'"), std::string::npos) << kind;
  const std::string version = errorOf([&] { readBinaryFile(path, "sample", 4, ignore); });
  EXPECT_NE(version.find("version 3, expected 4"), std::string::npos) << version;
}

TEST(Binary, WhatIsLeftUnreadIsAnError) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  writeSample(path);
  const std::string error =
      errorOf([&] { readBinaryFile(path, "sample", 3, [](BinaryReader& in) { in.getString(); }); });
  EXPECT_NE(error.find("more than expected"), std::string::npos) << error;
}

TEST(Binary, NoFileThatWasCutShortCanBeRead) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  writeSample(path);
  const std::string whole = readAll(path);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    writeAll(path, whole.substr(0, size));
    const std::string error = errorOf([&] {
      readBinaryFile(path, "sample", 3, [](BinaryReader& in) {
        in.getString();
        in.getVector<float>();
        Eigen::VectorXf vector;
        in.getMatrix(vector);
        in.get<std::int64_t>();
      });
    });
    EXPECT_NE(error.find("damaged"), std::string::npos) << size << " bytes: " << error;
  }
}

TEST(Binary, ACountThatTheBytesCannotHoldIsRefusedBeforeAnythingIsAllocated) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  writeBinaryFile(path, "sample", 3, [](BinaryWriter& out) { out.put(std::uint64_t{1} << 60); });
  const std::string error = errorOf(
      [&] { readBinaryFile(path, "sample", 3, [](BinaryReader& in) { in.getVector<double>(); }); });
  EXPECT_NE(error.find("damaged"), std::string::npos) << error;
}

TEST(Binary, TheChecksumTellsEveryChangedByte) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file.bin";
  writeAll(path, "123456789");
  EXPECT_EQ(computeCrc32(path), 0xCBF43926U);  // the check value of CRC-32/ISO-HDLC
  writeAll(path, "123456788");
  EXPECT_NE(computeCrc32(path), 0xCBF43926U);
}

}  // namespace
}  // namespace tsg
