// SPDX-License-Identifier: BSD-3-Clause
// Trajectories in TUM's format, and poses out of them.
#include <stdexcept>

#include "fuzzer.h"
#include "task_scene_graph/core/trajectory.h"

namespace {

namespace fuzz = tsg::fuzz;

std::string make(fuzz::Mutator& mutator) {
  static const std::vector<std::string> words{"#",  "\n",  " ",     ",",   "\r\n",
                                              "\t", "nan", "0x1p3", "\xff"};
  std::string text =
      "# timestamp tx ty tz qx qy qz qw\n1305031102.175304 1.3405 0.6266 1.6575 0.6574 0.6126 "
      "-0.2949 -0.3248\n1305031102.211214 1.3303 0.6256 1.6464 0.6579 0.6161 -0.2932 -0.3189\n"
      "1305031102.275326,1.3,0.6,1.6,0,0,0,1\n1305031102.311267 nan nan nan nan nan nan nan\n";
  mutator.mutateBytes(words, text);
  return text;
}

void readInput(const std::string& path) {
  const auto trajectory = tsg::loadTumTrajectory(path);
  const auto middle_ns = (trajectory.first().ns + trajectory.last().ns) / 2;
  for (const auto stamp : {trajectory.first(), tsg::Stamp{middle_ns}, trajectory.last()}) {
    const auto pose = trajectory.interpolate(stamp, 1e12);
    if (pose && !pose->matrix().allFinite()) throw std::logic_error("a pose that is not finite");
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("trajectory", "trajectory.txt", make, readInput));
}
