// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/inference_engine.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <future>
#include <iostream>
#include <thread>

#include "networks.h"

namespace tsg::segmentation {
namespace {

std::string errorOf(const std::string& path, const EngineConfig& config = {}) {
  try {
    const Network network(path, config);
  } catch (const InferenceError& e) {
    return e.what();
  }
  return "";
}

TEST(Network, TellsNamesTypesAndShapes) {
  TSG_REQUIRE_ENGINE();
  const Network network(findNetwork("encoder"), {});
  EXPECT_EQ(toText(network.inputs()), "image float32[?,3,8,8]");
  EXPECT_EQ(toText(network.outputs()), "embedding float32[?,4]");
}

TEST(Network, ComputesWhatTheFileSays) {
  TSG_REQUIRE_ENGINE();
  const Network network(findNetwork("encoder"), {});
  std::vector<float> image(2 * 3 * 64, 0.0F);
  std::fill(image.begin(), image.begin() + 64, 1.0F);  // first image: red
  std::fill(image.end() - 64, image.end(), 2.0F);      // second image: twice blue
  const auto outputs = network.run({{2, 3, 8, 8}, image.data(), nullptr});
  ASSERT_EQ(outputs.size(), 1U);
  EXPECT_EQ(outputs[0].shape, (std::vector<std::int64_t>{2, 4}));
  const std::vector<float> expected = {1.25F, 0.25F, 0.25F, 1.5F, 0.25F, 0.25F, 2.25F, 2.0F};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_FLOAT_EQ(outputs[0].values[i], expected[i]) << i;
}

TEST(Network, OutputsOutliveTheNetwork) {
  TSG_REQUIRE_ENGINE();
  const std::vector<float> image(3 * 64, 1.0F);
  TensorView output;
  {
    const Network network(findNetwork("encoder"), {});
    output = network.run({{1, 3, 8, 8}, image.data(), nullptr}).front();
  }
  EXPECT_FLOAT_EQ(output.values[0], 1.25F);
}

TEST(Network, RunsInSeveralThreadsAtOnceGiveTheSame) {
  TSG_REQUIRE_ENGINE();
  const Network network(findNetwork("segmenter"), {});
  std::vector<float> image(3 * 64 * 64);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<float>(i % 97) / 97.0F;
  const auto run = [&] {
    std::vector<float> all;
    for (int i = 0; i < 50; ++i) {
      const auto outputs = network.run({{1, 3, 64, 64}, image.data(), nullptr});
      all.insert(all.end(), outputs[1].values, outputs[1].values + 4 * 16 * 16);
    }
    return all;
  };
  auto other = std::async(std::launch::async, run);
  const std::vector<float> here = run();
  EXPECT_EQ(other.get(), here);
}

TEST(Network, AMissingFileIsNamed) {
  TSG_REQUIRE_ENGINE();
  EXPECT_EQ(errorOf("/no/such/file.onnx"), "network file '/no/such/file.onnx' is not there");
  EXPECT_NE(errorOf("/tmp").find("'/tmp'"), std::string::npos);
}

TEST(Network, ATruncatedFileAndAFileOfTextAreNamed) {
  TSG_REQUIRE_ENGINE();
  const test::TemporaryFolder folder;
  const std::string truncated = (folder.path() / "truncated.onnx").string();
  std::ifstream whole(findNetwork("segmenter"), std::ios::binary);
  std::string bytes(300, '\0');
  whole.read(&bytes[0], 300);
  std::ofstream(truncated, std::ios::binary) << bytes;
  const std::string text = (folder.path() / "text.onnx").string();
  std::ofstream(text) << "this is no network\n";
  for (const std::string& path : {truncated, text}) {
    EXPECT_NE(errorOf(path).find("network file '" + path + "' cannot be loaded"), std::string::npos)
        << errorOf(path);
  }
}

TEST(Network, FilesOfAnotherKindAreToldApart) {
  TSG_REQUIRE_ENGINE();
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "model.onnx").string();
  for (const auto& [bytes, words] : {std::pair<const char*, const char*>{"", "it is empty"},
                                     {"PK\x03\x04", "PyTorch's .pt"},
                                     {"version https://git-lfs.github.com/spec/v1\n", "Git LFS"},
                                     {"<!DOCTYPE html>", "a web page"}}) {
    std::ofstream(path, std::ios::binary) << bytes;
    const std::string error = errorOf(path);
    EXPECT_NE(error.find("'" + path + "' cannot be loaded"), std::string::npos) << error;
    EXPECT_NE(error.find(words), std::string::npos) << error;
    EXPECT_NE(error.find("expected an ONNX file"), std::string::npos) << error;
  }
}

TEST(Network, AnInputOfTheWrongShapeIsExplained) {
  TSG_REQUIRE_ENGINE();
  const Network network(findNetwork("encoder"), {});
  const std::vector<float> image(3 * 49);
  try {
    network.run({{1, 3, 7, 7}, image.data(), nullptr});
    FAIL();
  } catch (const InferenceError& e) {
    const std::string what = e.what();
    EXPECT_NE(what.find("encoder.onnx' failed on an input [1,3,7,7]"), std::string::npos) << what;
    EXPECT_NE(what.find("image float32[?,3,8,8]"), std::string::npos) << what;
  }
}

TEST(Network, AMissingProviderIsAnErrorThatListsThosePresent) {
  TSG_REQUIRE_ENGINE();
  EngineConfig config;
  config.provider = ExecutionProvider::kTensorRt;
  const std::string error = errorOf(findNetwork("encoder"), config);
  if (error.find("has no") == std::string::npos) GTEST_SKIP() << "this ONNX Runtime has TensorRT";
  EXPECT_NE(error.find("no TensorrtExecutionProvider"), std::string::npos) << error;
  EXPECT_NE(error.find("CPUExecutionProvider"), std::string::npos) << error;
  EXPECT_NE(error.find("engine/provider"), std::string::npos) << error;
}

TEST(Network, ASecondLibraryInOneProcessIsRefused) {
  TSG_REQUIRE_ENGINE();
  EngineConfig config;
  config.library = "/no/such/libonnxruntime.so";
  const std::string error = errorOf(findNetwork("encoder"), config);
  EXPECT_NE(error.find("'/no/such/libonnxruntime.so' cannot be opened beside it"),
            std::string::npos)
      << error;
}

/// In a fresh process (a threadsafe death test), where no library is open yet.
void loadWithLibraryAndExit(const std::string& library) {
  EngineConfig config;
  config.library = library;
  std::cerr << errorOf(findNetwork("encoder"), config);
  std::exit(3);
}

const char* const kBuiltWithout = "|was built without ONNX Runtime";

class NetworkDeathTest : public ::testing::Test {
 protected:
  void SetUp() override { ::testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

TEST_F(NetworkDeathTest, AMissingLibraryIsAnErrorThatSaysWhereItWasLookedFor) {
  EXPECT_EXIT(loadWithLibraryAndExit("/no/such/libonnxruntime.so"), ::testing::ExitedWithCode(3),
              std::string("cannot be opened; run scripts/install_engine.*\n.*/no/such/libonnx") +
                  kBuiltWithout);
}

TEST_F(NetworkDeathTest, AnotherLibraryIsRecognised) {
  EXPECT_EXIT(loadWithLibraryAndExit("libm.so.6"), ::testing::ExitedWithCode(3),
              std::string("'libm.so.6' is not ONNX Runtime") + kBuiltWithout);
}

/// Waits until this process has used some CPU time, i.e. the network runs; false after a minute.
bool waitUntilBusy() {
  const std::clock_t start = std::clock();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (std::clock() - start < CLOCKS_PER_SEC / 20) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

TEST(Network, CancelEndsARunThatWouldTakeHoursAndAllLaterOnes) {
  TSG_REQUIRE_ENGINE();
  Network network(findNetwork("slow_segmenter"), {});
  const std::vector<float> white(3 * 64 * 64, 1.0F);
  const auto run = [&] { network.run({{1, 3, 64, 64}, white.data(), nullptr}); };
  auto running = std::async(std::launch::async, run);
  EXPECT_TRUE(waitUntilBusy());
  EXPECT_FALSE(network.isCancelled());
  network.cancel();
  EXPECT_THROW(running.get(), Cancelled);
  EXPECT_THROW(run(), Cancelled);
}

}  // namespace
}  // namespace tsg::segmentation
