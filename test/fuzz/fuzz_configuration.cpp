// SPDX-License-Identifier: BSD-3-Clause
// Configuration files, for all stages; what holds is written as settings.yaml and read again.
#include <sstream>
#include <stdexcept>

#include "../../src/nodelets/chain_config.h"
#include "fuzzer.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace config = tsg::config;
namespace nodelets = tsg::nodelets;

std::string toText(const nodelets::ChainConfig& chain) {
  std::ostringstream text;
  config::writeSettings(text, {}, nodelets::listSettings(chain));
  return text.str();
}

std::string make(fuzz::Mutator& mutator) {
  static const std::vector<std::string> corpus{
      toText(nodelets::loadChain({})),
      "input: {world_frame: map, depth_scale: 0.001}\nmodels: models.yaml\noutput: ~/map\n"
      "tracker:\n  preset: khronos\n  window_s: 3.0\nscene_graph:\n  object_alpha: 0.25\n"};
  return fuzz::makeYaml(mutator, mutator.pickFrom(corpus));
}

/// The first line that differs.
std::string findDifference(const std::string& a, const std::string& b) {
  std::istringstream lines_a(a);
  std::istringstream lines_b(b);
  std::string line_a;
  std::string line_b;
  while (std::getline(lines_a, line_a)) {
    if (!std::getline(lines_b, line_b)) line_b = "nothing";
    if (line_a != line_b) return "'" + line_a + "' became '" + line_b + "'";
  }
  return "";
}

/// A model set that is missing is named itself.
bool isOfModelSet(const config::ConfigError& e) {
  return std::string(e.what()).rfind("model set '", 0) == 0;
}

void readInput(const std::string& path) {
  try {
    const std::string written = toText(nodelets::loadChain({config::readConfigFile(path)}));
    fuzz::writeFile(path, written);
    const std::string again = toText(nodelets::loadChain({config::readConfigFile(path)}));
    if (again != written) throw std::logic_error("settings: " + findDifference(written, again));
  } catch (const config::ConfigError& e) {
    if (!isOfModelSet(e)) throw;
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv,
                         fuzz::makeFileReader("configuration", "my.yaml", make, readInput));
}
