// Shows progress and the time left on stderr. Work shorter than two seconds shows nothing. After that a terminal shows
// one line that rewrites itself, and a log gets a plain line every few seconds. This is also the one place that listens
// for Ctrl-C.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace sandglass::host {

struct Progress {
  using Time = std::chrono::steady_clock::time_point;

  // `what` is for example "simulating". If `stream` is null, nothing is shown.
  Progress(std::string what, uint64_t total, std::FILE* stream = stderr);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void total(uint64_t count) { total_ = count; }
  void done(uint64_t count);
  bool goes_on(uint64_t count);  // the same; false after Ctrl-C
  // The same at a given time, for the tests.
  void done_at(uint64_t count, Time now);

 private:
  std::string what_;
  uint64_t total_;
  std::FILE* stream_;
  bool terminal_;
  bool shown_ = false;
  Time start_, next_;
};

// For example "simulating 120/200 (60 %), 3 s left". The time is left out at the start and at the end.
std::string progress_line(const std::string& what, uint64_t count, uint64_t total, double elapsed_s);

// After this call Ctrl-C (or SIGTERM) sets a flag. The work asks for it and ends. If the command does not notice within
// a second, the program ends there with exit code 130, or, while results are being kept, says that a step is finished
// first. A second Ctrl-C ends it at once. Neither leaves a half-written file.
void listen_for_interrupt();
bool interrupted();

// Lives while a thread does one of several tasks beside each other. That one of them asks does not mean that the
// command has noticed: another may still be in the middle of a long one.
struct OneOfSeveral {
  OneOfSeveral();
  ~OneOfSeveral();
  OneOfSeveral(const OneOfSeveral&) = delete;
  OneOfSeveral& operator=(const OneOfSeveral&) = delete;
};

// Lives while Ctrl-C should not lose what was computed: the frames of a run.
struct KeepingResults {
  KeepingResults();
  ~KeepingResults();
  KeepingResults(const KeepingResults&) = delete;
  KeepingResults& operator=(const KeepingResults&) = delete;
};

}  // namespace sandglass::host
