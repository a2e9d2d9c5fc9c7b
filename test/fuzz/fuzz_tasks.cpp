// SPDX-License-Identifier: BSD-3-Clause
// Task lists of all three kinds; what was accepted is written and read again.
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/scene_graph/tasks.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace scene_graph = tsg::scene_graph;

std::string make(fuzz::Mutator& mutator) {
  static const std::vector<std::string> corpus{
      "tasks:\n  - name: \"wash the dishes\"\n    embedding: [0.1, -0.25, 3e-1]\n"
      "  - name: read\n    embedding: [1, 0, 0]\n  - name: sit\n    embedding:\n      - .5\n"
      "      - 0.5\n      - 1.0e-3\n",
      "- wash the dishes\n- read a book\n- \"sit: down\"\n",
      "wash the dishes: [[1, 2, 3]]\nread a book: {center: [0, 1, 2], extents: [1, 1, 1]}\n",
      "tasks:\n- name: a\n- name: b\n"};
  return fuzz::makeYaml(mutator, mutator.pickFrom(corpus));
}

void readInput(const std::string& path) {
  const auto tasks = scene_graph::loadTasks(path);
  scene_graph::writeTasks(path, tasks);
  const auto again = scene_graph::loadTasks(path);
  if (!(again == tasks)) throw std::logic_error("other tasks after writing and reading");
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, fuzz::makeFileReader("tasks", "tasks.yaml", make, readInput));
}
