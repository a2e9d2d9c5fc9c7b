// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/scene_graph/tasks.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>

#include "support.h"
#include "task_scene_graph/config/config.h"

namespace tsg::scene_graph {
namespace {

class Tasks : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(path()) << text;
    return path();
  }
  std::string path() const { return (folder_.path() / "tasks.yaml").string(); }

  /// What loading `text` complains of; "" if it loads.
  std::string errorOf(const std::string& text) const {
    try {
      loadTasks(write(text));
    } catch (const config::ConfigError& e) {
      return e.what();
    }
    return "";
  }
  void expectError(const std::string& text, const std::vector<std::string>& parts) const {
    const std::string message = errorOf(text);
    EXPECT_NE(message.find("task file '" + path() + "'"), std::string::npos) << message;
    for (const auto& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
  }

 private:
  test::TemporaryFolder folder_;
};

using Names = std::vector<std::string>;

TEST_F(Tasks, KeysOfCliosOwnFormatAreTheTasksInTheirOrder) {
  const TaskList tasks =
      loadTasks(write("wash the dishes:\n"
                      "  - center: [1, 2, 3]\n"
                      "    extents: [1, 1, 1]\n"
                      "    rotation: {w: 1, x: 0, y: 0, z: 0}\n"
                      "a task without boxes: []\n"
                      "bring me a pillow:\n"));
  EXPECT_EQ(tasks.names, (Names{"wash the dishes", "a task without boxes", "bring me a pillow"}));
  EXPECT_FALSE(tasks.hasEmbeddings());
}

TEST_F(Tasks, PlainListKeepsItsOrder) {
  EXPECT_EQ(loadTasks(write("- zebra\n- apple\n- \"42\"\n- 7\n")).names,
            (Names{"zebra", "apple", "42", "7"}));
  EXPECT_EQ(loadTasks(write("tasks: [b, a]\n")).names, (Names{"b", "a"}));
}

TEST_F(Tasks, NamesComeWithTheirEmbeddings) {
  const TaskList tasks = loadTasks(
      write("tasks:\n  - {name: b, embedding: [1, 2.5, -3e-2]}\n  - name: a\n    embedding: [0, 0, "
            "1]\n"));
  EXPECT_EQ(tasks.names, (Names{"b", "a"}));
  EmbeddingMatrix expected(2, 3);
  expected << 1.0F, 2.5F, -3e-2F, 0.0F, 0.0F, 1.0F;
  EXPECT_EQ(tasks.embeddings, expected);
}

TEST_F(Tasks, NamesThatAreNotUtf8AreNamedByNumber) {
  expectError("- wash\n- caf\xe9\n", {"task 2", "not valid UTF-8", "convert the file"});
}

TEST_F(Tasks, NothingInTheFileIsAnEmptyList) {
  for (const char* text : {"", "# only a comment\n", "[]", "{}", "tasks: []\n", "tasks:\n"}) {
    EXPECT_EQ(loadTasks(write(text)).size(), 0U) << text;
  }
}

TEST_F(Tasks, ATaskOfClioMayBeCalledTasks) {
  EXPECT_EQ(loadTasks(write("tasks:\n  - name: x\nother: []\n")).names, (Names{"tasks", "other"}));
}

TEST_F(Tasks, DuplicatesAreNamed) {
  expectError("- cup\n- spoon\n- cup\n", {"task 3 'cup' is there twice"});
  expectError("cup: []\nspoon: []\ncup: []\n", {"task 3 'cup' is there twice"});
}

TEST_F(Tasks, EmptyNamesAreFound) {
  expectError("- cup\n- ''\n", {"task 2 '' is empty"});
  expectError("- cup\n-\n", {"task 2 '' is empty"});
  expectError("'  ': []\n", {"task 1 '  ' is empty"});
  expectError("tasks: [{embedding: [1]}]\n", {"task 1 '' is empty"});
  expectError("- [cup, spoon]\n", {"task 1 '' is empty"});
}

TEST_F(Tasks, EmbeddingsThatAreNoDirectionAreNamed) {
  expectError("tasks: [{name: cup, embedding: [1, .nan]}]\n", {"task 1 'cup'", "NaN"});
  expectError("tasks: [{name: cup, embedding: [.inf, 1]}]\n", {"task 1 'cup'", "infinite"});
  expectError("tasks: [{name: cup, embedding: [0, 0]}]\n", {"task 1 'cup'", "all zeros"});
  expectError("tasks: [{name: cup, embedding: [1, two]}]\n",
              {"task 'cup'", "value 2 is 'two'", "a number"});
  expectError("tasks: [{name: cup, embedding: 1}]\n",
              {"task 'cup'", "is '1'", "a list of numbers"});
  expectError("tasks: [{name: cup, embedding: []}]\n", {"task 'cup'", "a list of numbers"});
}

TEST_F(Tasks, DifferentSizesNameBothTasksAndSizes) {
  expectError("tasks: [{name: a, embedding: [1, 2]}, {name: b, embedding: [1, 2, 3]}]\n",
              {"task 'b'", "has 3 values", "expected 2 as in task 'a'"});
  expectError("tasks: [{name: a}, {name: b, embedding: [1, 2, 3]}]\n",
              {"task 'a'", "has 0 values", "expected 3 as in task 'b'"});
}

TEST_F(Tasks, AllErrorsOfAFileComeAtOnce) {
  expectError("tasks: [{name: a}, {name: a}, {name: '', embeding: [1]}]\n",
              {"task 2 'a' is there twice", "task 3 '' is empty", "unknown key 'embeding'"});
}

TEST_F(Tasks, FilesThatAreNoTasksAreRefused) {
  expectError("just words\n", {"'just words'", "expected a list"});
  EXPECT_NE(errorOf("a: [1\n").find(path()), std::string::npos);
  try {
    loadTasks("/nonexistent/tasks.yaml");
    FAIL() << "loaded a file that is not there";
  } catch (const config::ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("/nonexistent/tasks.yaml"), std::string::npos);
  }
}

TEST_F(Tasks, WrittenTasksReadBackBitByBit) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0.0F, 1.0F);
  TaskList tasks;
  tasks.names = {"wash: the dishes", "it's \"quoted\"", "- dash", "Küche", "# no comment", "null"};
  tasks.embeddings = EmbeddingMatrix::NullaryExpr(6, 50, [&] { return normal(random); });
  tasks.embeddings(0, 0) = std::numeric_limits<float>::min();
  tasks.embeddings(0, 1) = std::numeric_limits<float>::max();
  writeTasks(path(), tasks);
  EXPECT_TRUE(loadTasks(path()) == tasks);

  tasks.embeddings.resize(0, 0);
  writeTasks(path(), tasks);
  EXPECT_EQ(loadTasks(path()).names, tasks.names);
  EXPECT_FALSE(loadTasks(path()).hasEmbeddings());
}

TEST_F(Tasks, InvalidTasksAreNotWritten) {
  TaskList tasks;
  tasks.names = {"a", "a"};
  EXPECT_THROW(writeTasks(path(), tasks), config::ConfigError);
  EXPECT_FALSE(std::filesystem::exists(path()));
}

/// What checkUsable complains of; "" if nothing.
std::string usabilityError(const TaskList& tasks, bool has_text_encoder, int embedding_size) {
  try {
    checkUsable(tasks, "t.yaml", has_text_encoder, embedding_size);
  } catch (const config::ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(TasksAndModels, NamesAloneNeedATextEncoder) {
  TaskList tasks;
  EXPECT_EQ(usabilityError(tasks, false, 512), "");
  tasks.names = {"cup"};
  EXPECT_EQ(usabilityError(tasks, true, 512), "");
  const std::string message = usabilityError(tasks, false, 512);
  EXPECT_NE(message.find("task file 't.yaml'"), std::string::npos) << message;
  EXPECT_NE(message.find("no embeddings and the model set has no text encoder"), std::string::npos)
      << message;
}

TEST(TasksAndModels, EmbeddingsOfAnotherModelAreRefused) {
  TaskList tasks;
  tasks.names = {"cup"};
  tasks.embeddings = EmbeddingMatrix::Ones(1, 4);
  EXPECT_EQ(usabilityError(tasks, false, 4), "");
  EXPECT_EQ(usabilityError(tasks, false, 0), "");
  const std::string message = usabilityError(tasks, true, 512);
  EXPECT_NE(message.find("have 4 values, expected 512"), std::string::npos) << message;
}

TEST(TasksAndModels, SharedTaskEmbeddingsLoad) {
  TSG_REQUIRE_SHARED(file, "models/task_embeddings.yaml");
  const TaskList tasks = loadTasks(file.string());
  EXPECT_EQ(tasks.size(), 24U);
  EXPECT_EQ(tasks.names.front(), "get the coffee mug");
  ASSERT_EQ(tasks.embeddings.cols(), 384);
  for (Eigen::Index i = 0; i < tasks.embeddings.rows(); ++i) {
    EXPECT_NEAR(tasks.embeddings.row(i).norm(), 1.0F, 1e-4F);
  }
}

}  // namespace
}  // namespace tsg::scene_graph
