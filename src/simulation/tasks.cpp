// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>
#include <string>

#include "catalogue.h"
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

/// The same in both lists; most things that they are about are seen in parts.
const std::vector<TaskPhrases>& listFurnitureTasks() {
  static const std::vector<TaskPhrases> kTasks = {{"move the office chair", {"office chair"}},
                                                  {"look at the monitor", {"computer monitor"}},
                                                  {"sit on the sofa", {"sofa"}},
                                                  {"empty the waste bin", {"waste bin"}},
                                                  {"water the potted plant", {"potted plant"}},
                                                  {"print a letter", {"printer"}},
                                                  {"open the refrigerator", {"refrigerator"}},
                                                  {"fetch the backpack", {"backpack"}},
                                                  {"repair the bicycle", {"bicycle"}},
                                                  {"play the piano", {"piano"}}};
  return kTasks;
}

/// A task that all instances serve whose phrase is one of its own.
TaskTruth makeTask(const Apartment& apartment, const TaskPhrases& entry) {
  TaskTruth task;
  task.name = entry.name;
  for (const char* phrase : entry.phrases) task.phrases.emplace_back(phrase, 1.0);
  for (const Instance& instance : apartment.instances) {
    const auto& phrases = entry.phrases;
    const bool serves = std::any_of(phrases.begin(), phrases.end(),
                                    [&](const char* phrase) { return instance.phrase == phrase; });
    if (serves) task.instances.push_back(instance.id);
  }
  return task;
}

TaskTruth makeSetTask(const Apartment& apartment, const catalogue::ThingSet& set) {
  TaskTruth task;
  task.name = set.task;
  for (const auto& member : set.members) task.phrases.emplace_back(member.phrase, 1.0);
  for (std::size_t i = 0; i < apartment.groups.size(); ++i) {
    if (apartment.groups[i].phrase == set.phrase) task.groups.push_back(i);
  }
  return task;
}

}  // namespace

std::vector<TaskTruth> makeObjectTasks(const Apartment& apartment) {
  std::vector<TaskTruth> tasks;
  for (const TaskPhrases& entry : listTasks()) tasks.push_back(makeTask(apartment, entry));
  return tasks;
}

std::vector<TaskTruth> makeGroupTasks(const Apartment& apartment, TaskGrain grain) {
  std::vector<TaskTruth> tasks;
  for (const TaskPhrases& entry : listFurnitureTasks()) {
    tasks.push_back(makeTask(apartment, entry));
  }
  for (const catalogue::ThingSet& set : catalogue::thingSets()) {
    if (grain == TaskGrain::kCoarse) tasks.push_back(makeSetTask(apartment, set));
    if (grain == TaskGrain::kCoarse) continue;
    for (const auto& member : set.members) {
      if (member.task != nullptr) {
        tasks.push_back(makeTask(apartment, {member.task, {member.phrase}}));
      }
    }
  }
  return tasks;
}

std::vector<TaskTruth> makePlaceTasks(const Apartment& apartment) {
  std::vector<TaskTruth> tasks;
  std::set<std::string> seen;
  for (const Room& room : apartment.rooms) {
    if (seen.insert(room.phrase).second) {
      tasks.push_back({room.phrase, {{room.phrase, 1.0}}, {}, {}});
    }
  }
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
