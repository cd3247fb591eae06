// Progress with the time still to go, on stderr: nothing for work shorter than two seconds, then one line that rewrites
// itself on a terminal, or a plain line every few seconds in a log. Also the one place that listens for Ctrl-C.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace sandglass::host {

struct Progress {
  using Time = std::chrono::steady_clock::time_point;

  // `stream` may be null: then nothing is shown. `what`: "simulating", "drawing". `first`: how much was done before, by
  // a run that was interrupted; the time left is judged by what this run does.
  Progress(std::string what, uint64_t total, std::FILE* stream = stderr, uint64_t first = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void total(uint64_t count) { total_ = count; }
  void done(uint64_t count);
  // The same with an explicit time: what the tests call.
  void done_at(uint64_t count, Time now);

 private:
  std::string what_;
  uint64_t total_, first_;
  std::FILE* stream_;
  bool terminal_;
  bool shown_ = false;
  Time start_, next_;
};

// "simulating 120/200 (60 %), 3 s left"; the time left is left out while nothing beyond `first` is done.
std::string progress_line(const std::string& what, uint64_t count, uint64_t total, double elapsed_s,
                          uint64_t first = 0);

// From the first call on, Ctrl-C sets a flag instead of ending the program; a second Ctrl-C ends it at once, and leaves
// no file half-written.
void listen_for_interrupt();
bool interrupted();

}  // namespace sandglass::host
