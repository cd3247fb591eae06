// A line is shown when the work has run for two seconds and the previous line is old enough.
#include "models/work/progress.h"

#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <string_view>

#include "models/files/atomic_file.h"

namespace sandglass::host {

using namespace std::chrono_literals;

constexpr auto k_quiet = 2s;               // shorter work shows nothing
constexpr auto k_terminal_period = 100ms;  // between two updates of the line on a terminal
constexpr auto k_log_period = 5s;          // between two lines in a log

std::string progress_line(const std::string& what, uint64_t count, uint64_t total, double elapsed_s) {
  char text[160];
  const double share = total == 0 ? 1.0 : static_cast<double>(count) / static_cast<double>(total);
  int used =
      std::snprintf(text, sizeof text, "%s %llu/%llu (%.0f %%)", what.c_str(), static_cast<unsigned long long>(count),
                    static_cast<unsigned long long>(total), share * 100.0);
  if (count > 0 && count < total && used > 0 && used < static_cast<int>(sizeof text))
    std::snprintf(text + used, sizeof text - static_cast<size_t>(used), ", %.0f s left",
                  elapsed_s * static_cast<double>(total - count) / static_cast<double>(count));
  return text;
}

Progress::Progress(std::string what, uint64_t total, std::FILE* stream)
    : what_(std::move(what)),
      total_(total),
      stream_(stream),
      terminal_(stream != nullptr && isatty(fileno(stream)) != 0) {
  start_ = std::chrono::steady_clock::now();
  next_ = start_ + k_quiet;
}

Progress::~Progress() {
  if (shown_ && terminal_) std::fputs("\r\033[K", stream_);
}

bool Progress::goes_on(uint64_t count) {
  done(count);
  return !interrupted();
}

void Progress::done(uint64_t count) { done_at(count, std::chrono::steady_clock::now()); }

void Progress::done_at(uint64_t count, Time now) {
  if (stream_ == nullptr || now < next_) return;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const std::string line = progress_line(what_, count, total_, elapsed);
  std::fprintf(stream_, terminal_ ? "\r%s\033[K" : "%s\n", line.c_str());
  std::fflush(stream_);
  shown_ = true;
  next_ = now + (terminal_ ? std::chrono::steady_clock::duration(k_terminal_period) : k_log_period);
}

namespace {

constexpr suseconds_t k_patience_us = 700'000;  // after Ctrl-C: then the program ends, or says why it does not

volatile std::sig_atomic_t interrupt_flag = 0, seen_flag = 0;
std::atomic<int> keepers = 0;
thread_local int tasks_of_several = 0;

void say(std::string_view sentence) {
  if (write(STDERR_FILENO, sentence.data(), sentence.size()) < 0) return;  // nobody listens
}

// The command has not asked interrupted() since Ctrl-C: a library is at work, a file is being read, a step takes long,
// or one of several tasks beside each other does.
void on_patience_over(int) {
  if (seen_flag != 0) return;
  if (keepers > 0) {
    say("sandglass: interrupted; the step in progress is finished first. Ctrl-C again ends at once.\n");
    return;
  }
  remove_unfinished();
  say("sandglass: interrupted.\n");
  constexpr int k_exit_interrupted = 130;
  _exit(k_exit_interrupted);
}

void on_interrupt(int number) {
  if (interrupt_flag == 0) {
    interrupt_flag = 1;
    const itimerval once = {{}, {0, k_patience_us}};
    setitimer(ITIMER_REAL, &once, nullptr);
    return;
  }
  remove_unfinished();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace

KeepingResults::KeepingResults() { ++keepers; }
KeepingResults::~KeepingResults() { --keepers; }
OneOfSeveral::OneOfSeveral() { ++tasks_of_several; }
OneOfSeveral::~OneOfSeveral() { --tasks_of_several; }

void listen_for_interrupt() {
  std::signal(SIGALRM, on_patience_over);
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}
bool interrupted() {
  if (interrupt_flag != 0 && tasks_of_several == 0) seen_flag = 1;
  return interrupt_flag != 0;
}

}  // namespace sandglass::host
