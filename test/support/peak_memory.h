// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <malloc.h>

#include <fstream>
#include <string>

/// What a benchmark's work takes of the machine's memory (Linux).
namespace tsg::test {

/// A field of /proc/self/status in MB; 0 where there is none.
inline double readStatus_MB(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == field + ":" && status >> kilobytes) return kilobytes / 1024.0;
  }
  return 0.0;
}

/// Peak memory since construction, beyond what was in use then.
class PeakMemory {
 public:
  PeakMemory() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
    start_MB_ = readStatus_MB("VmRSS");
  }
  double peak_MB() const { return readStatus_MB("VmHWM") - start_MB_; }

 private:
  double start_MB_ = 0.0;
};

}  // namespace tsg::test
