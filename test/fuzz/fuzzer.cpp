// SPDX-License-Identifier: BSD-3-Clause
#include "fuzzer.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <new>
#include <stdexcept>
#include <vector>

#include "support.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TSG_SANITIZED 1
extern "C" void __sanitizer_set_death_callback(void (*callback)());
#endif

namespace tsg::fuzz {
namespace fs = std::filesystem;
namespace {

constexpr unsigned kLongest_s = 10;
constexpr long kMostMemory_kB = 1'000'000;
constexpr rlim_t kAddressSpace_bytes = 8'000'000'000;
constexpr std::size_t kMostFindings = 10;

struct Options {
  std::uint64_t runs = 2000;
  std::uint64_t seed = 1;
  std::uint64_t first = 0;
  fs::path findings = ".";
  fs::path result;
  std::vector<fs::path> inputs;
};

Options parseOptions(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0) {
      options.inputs.emplace_back(word);
      continue;
    }
    if (++i == argc) throw std::invalid_argument(word + " needs a value");
    const std::string value = argv[i];
    if (word == "--runs") {
      options.runs = std::stoull(value);
    } else if (word == "--seed") {
      options.seed = std::stoull(value);
    } else if (word == "--first") {
      options.first = std::stoull(value);
    } else if (word == "--findings") {
      options.findings = value;
      fs::create_directories(options.findings);
    } else if (word == "--result") {
      options.result = value;
    } else {
      throw std::invalid_argument("unknown option " + word);
    }
  }
  return options;
}

/// What a signal handler may read: where the input goes that is being read.
struct Current {
  const char* input = nullptr;
  std::size_t size = 0;
  std::array<char, 4096> path{};
};
Current current;

void print(const char* text) {
  std::size_t length = 0;
  while (text[length] != '\0') ++length;
  [[maybe_unused]] const auto ignored = write(STDERR_FILENO, text, length);
}

/// Only what is allowed in a signal handler.
void keepCurrent() {
  if (current.input == nullptr) return;
  const int file = open(current.path.data(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return;
  [[maybe_unused]] const auto ignored = write(file, current.input, current.size);
  close(file);
  print("\nfuzzing: the input that did it is kept in ");
  print(current.path.data());
  print("\n");
}

void onSignal(int signal) {
  const bool is_hang = signal == SIGALRM || signal == SIGPROF;
  print(is_hang ? "\nfuzzing: HANG, over 10 s" : "\nfuzzing: CRASH");
  keepCurrent();
  std::signal(signal, SIG_DFL);
  raise(is_hang ? SIGKILL : signal);
}

void catchSignal(int signal) {
  struct sigaction action = {};
  action.sa_handler = onSignal;
  action.sa_flags = SA_ONSTACK;
  sigaction(signal, &action, nullptr);
}

void watchForCrashes() {
  catchSignal(SIGALRM);
  catchSignal(SIGPROF);
#ifdef TSG_SANITIZED
  __sanitizer_set_death_callback(keepCurrent);
#else
  static std::array<char, 1 << 16> stack;  // for the overflow of the usual one
  stack_t other = {};
  other.ss_sp = stack.data();
  other.ss_size = stack.size();
  sigaltstack(&other, nullptr);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) catchSignal(signal);
  const rlimit limit{kAddressSpace_bytes, kAddressSpace_bytes};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

constexpr bool isSanitized() {
#ifdef TSG_SANITIZED
  return true;
#else
  return false;
#endif
}

/// Of the processor's time, for a busy machine can hold up anybody; of the clock's twelve times
/// that, for who waits uses none.
void watchForHang(bool is_on) {
  const unsigned limit_s = is_on ? kLongest_s * (isSanitized() ? 5 : 1) : 0;
  itimerval timer = {};
  timer.it_value.tv_sec = static_cast<time_t>(limit_s);
  setitimer(ITIMER_PROF, &timer, nullptr);
  alarm(12 * limit_s);
}

long measurePeak_kB() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// What is wrong with how an input was refused; empty if nothing is.
std::string judge(const Reader& reader, const std::exception& e) {
  if (dynamic_cast<const std::bad_alloc*>(&e) != nullptr) return "asks for too much memory";
  const std::string what = e.what();
  if (what.find(reader.source) != std::string::npos) return "";
  return "the refusal does not name '" + reader.source + "': " + what.substr(0, 400);
}

class Fuzzer {
 public:
  Fuzzer(const Reader& reader, Options options) : reader_(reader), options_(std::move(options)) {}

  bool run() {
    const auto start = std::chrono::steady_clock::now();
    if (options_.inputs.empty()) {
      readMutated();
    } else {
      for (const auto& path : options_.inputs) readGiven(path);
    }
    printSummary(std::chrono::steady_clock::now() - start);
    if (!options_.result.empty()) writeResult();
    return findings_.empty();
  }

 private:
  void readMutated() {
    const std::uint64_t end = options_.first + options_.runs;
    for (std::uint64_t run = options_.first; run < end && findings_.size() < kMostFindings; ++run) {
      const std::string label = std::to_string(options_.seed) + "_" + std::to_string(run);
      // The sequence of seeds must not repeat that of another seed, shifted.
      Mutator mutator(options_.seed * 0x9e3779b97f4a7c15U + run);
      readOne(label, reader_.make(mutator));
    }
  }

  void readGiven(const fs::path& path) { readOne(path.filename().string(), readFile(path)); }

  void readOne(const std::string& label, const std::string& input) {
    const std::string path =
        (options_.findings / ("finding_" + reader_.name + "_" + label)).string();
    path.copy(current.path.data(), current.path.size() - 1);
    current.path[std::min(path.size(), current.path.size() - 1)] = '\0';
    current.input = input.data();
    current.size = input.size();
    const long before_kB = measurePeak_kB();
    const auto start = std::chrono::steady_clock::now();
    watchForHang(true);
    const std::string problem = readAndJudge(input);
    watchForHang(false);
    slowest_ = std::max(slowest_, std::chrono::steady_clock::now() - start);
    ++num_read_;
    current.input = nullptr;
    if (!problem.empty()) add(problem, path, input);
    const long peak_kB = measurePeak_kB();
    if (peak_kB > kMostMemory_kB && peak_kB > before_kB) {
      add("memory grew to " + std::to_string(peak_kB / 1000) + " MB", path, input);
    }
  }

  std::string readAndJudge(const std::string& input) {
    try {
      reader_.read(input);
      ++num_accepted_;
      return "";
    } catch (const std::exception& e) {
      return judge(reader_, e);
    } catch (...) {
      return "throws what is no std::exception";
    }
  }

  /// One of a kind is enough.
  void add(const std::string& problem, const std::string& path, const std::string& input) {
    if (!findings_.emplace(problem.substr(0, 120), path).second) return;
    writeFile(path, input);
    std::cerr << "FINDING " << path << ": " << problem << std::endl;
  }

  void printSummary(std::chrono::steady_clock::duration time) const {
    using Seconds = std::chrono::duration<double>;
    std::cout << "fuzz_" << reader_.name << ": " << num_read_ << " inputs (" << num_accepted_
              << " accepted), " << findings_.size() << " findings, " << Seconds(time).count()
              << " s, slowest " << Seconds(slowest_).count() << " s, memory at most "
              << measurePeak_kB() / 1000 << " MB\n";
  }

  void writeResult() const {
    std::ofstream xml(options_.result);
    xml << "<testsuite name=\"fuzz_" << reader_.name << "\" tests=\"1\" errors=\"0\" failures=\""
        << (findings_.empty() ? 0 : 1) << "\" skipped=\"0\"><testcase classname=\"fuzz\" name=\""
        << reader_.name << "\">";
    if (!findings_.empty()) {
      xml << "<failure message=\"" << findings_.size() << " findings, see the output\"/>";
    }
    xml << "</testcase></testsuite>\n";
  }

  const Reader& reader_;
  const Options options_;
  std::map<std::string, std::string> findings_;  ///< kind -> path of the first
  std::chrono::steady_clock::duration slowest_{};
  std::uint64_t num_read_ = 0;
  std::uint64_t num_accepted_ = 0;
};

}  // namespace

const fs::path& scratchFolder() {
  static const test::TemporaryFolder folder;
  return folder.path();
}

std::string readFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot open '" + path.string() + "'");
  return {std::istreambuf_iterator<char>(file), {}};
}

void writeFile(const fs::path& path, const std::string& content) {
  std::error_code ignored;
  fs::remove(path, ignored);  // filling an old one anew waits for the disk
  std::ofstream file(path, std::ios::binary);
  file << content;
  if (!file.flush()) throw std::runtime_error("cannot write '" + path.string() + "'");
}

Reader makeFileReader(const std::string& name, const std::string& file_name,
                      std::function<std::string(Mutator&)> make,
                      std::function<void(const std::string& path)> read) {
  const fs::path path = scratchFolder() / file_name;
  return {name, path.string(), std::move(make), [path, read](const std::string& input) {
            writeFile(path, input);
            read(path.string());
          }};
}

int runFuzzer(int argc, char** argv, const Reader& reader) {
  try {
    Fuzzer fuzzer(reader, parseOptions(argc, argv));
    watchForCrashes();
    return fuzzer.run() ? 0 : 1;
  } catch (const std::exception& e) {
    std::cerr << "fuzz_" << reader.name << ": " << e.what() << '\n';
    return 2;
  }
}

}  // namespace tsg::fuzz
