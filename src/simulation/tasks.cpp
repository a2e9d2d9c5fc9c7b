// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>

#include "task_scene_graph/core/files.h"
#include "task_scene_graph/simulation/ground_truth.h"

namespace tsg::simulation {
namespace {

struct TaskPhrases {
  const char* name;
  std::vector<const char*> phrases;
};

const std::vector<TaskPhrases>& listTasks() {
  static const std::vector<TaskPhrases> kTasks = {{"get the coffee mug", {"coffee mug"}},
                                                  {"get a bottle", {"bottle"}},
                                                  {"bring the laptop", {"laptop"}},
                                                  {"find something to read", {"book", "magazine"}},
                                                  {"tidy the row of books", {"row of books"}},
                                                  {"water the potted plant", {"potted plant"}},
                                                  {"sit on the sofa", {"sofa"}},
                                                  {"make the bed", {"bed"}},
                                                  {"clean the toilet", {"toilet"}},
                                                  {"open the refrigerator", {"refrigerator"}},
                                                  {"set the dining table", {"dining table"}},
                                                  {"switch on the television", {"television"}},
                                                  {"move the office chair", {"office chair"}},
                                                  {"fetch the teddy bear", {"teddy bear"}},
                                                  {"fetch the backpack", {"backpack"}},
                                                  {"take the frying pan", {"frying pan"}},
                                                  {"load the washing machine", {"washing machine"}},
                                                  {"empty the waste bin", {"waste bin"}},
                                                  {"open the wardrobe", {"wardrobe"}},
                                                  {"take a pair of shoes", {"pair of shoes"}},
                                                  {"repair the bicycle", {"bicycle"}},
                                                  {"play the piano", {"piano"}}};
  return kTasks;
}

}  // namespace

std::vector<TaskTruth> makeObjectTasks(const Apartment& apartment) {
  std::vector<TaskTruth> tasks;
  for (const TaskPhrases& entry : listTasks()) {
    TaskTruth task;
    task.name = entry.name;
    for (const char* phrase : entry.phrases) task.phrases.emplace_back(phrase, 1.0);
    for (const Instance& instance : apartment.instances) {
      const auto& phrases = entry.phrases;
      const bool serves = std::any_of(phrases.begin(), phrases.end(), [&](const char* phrase) {
        return instance.phrase == phrase;
      });
      if (serves) task.instances.push_back(instance.id);
    }
    tasks.push_back(task);
  }
  return tasks;
}

std::vector<TaskTruth> makePlaceTasks(const Apartment& apartment) {
  std::vector<TaskTruth> tasks;
  for (const Room& room : apartment.rooms) tasks.push_back({room.phrase, {{room.phrase, 1.0}}, {}});
  return tasks;
}

void writeTaskEmbeddings(const std::filesystem::path& path, const std::vector<TaskTruth>& tasks) {
  const EmbeddingSpace space;
  writeFileAtomically(path, [&](std::ostream& out) {
    out.precision(8);
    out << "tasks:\n";
    for (const TaskTruth& task : tasks) {
      const Embedding embedding = space.encodeText(task.phrases);
      out << "  - name: \"" << task.name << "\"\n    embedding: [";
      for (Eigen::Index i = 0; i < embedding.size(); ++i)
        out << (i > 0 ? ", " : "") << embedding[i];
      out << "]\n";
    }
  });
}

void writeTaskNames(const std::filesystem::path& path, const std::vector<TaskTruth>& tasks) {
  writeFileAtomically(path, [&](std::ostream& out) {
    for (const TaskTruth& task : tasks) out << "- \"" << task.name << "\"\n";
  });
}

}  // namespace tsg::simulation
