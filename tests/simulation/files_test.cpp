// A file is complete or does not exist. Arrays come back as they were written. Progress says how long the work will
// take. The thread pool runs every index exactly once in each call, even when workers come late.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/npy.h"
#include "models/work/progress.h"
#include "models/work/thread_pool.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(Npy, RoundTrip) {
  const tests::TemporaryFolder folder;
  const std::vector<float> values = {1.0f, -2.5f, 3e-38f, 4.0f, 5.0f, 6e20f};
  write_npy(folder / "a.npy", values, 2, 3);
  const NpyArray table = read_npy(folder / "a.npy");
  EXPECT_EQ(table.shape, (std::vector<uint64_t>{2, 3}));
  EXPECT_EQ(table.values, values);
  write_npy(folder / "b.npy", values, 6, 1);
  EXPECT_EQ(read_npy(folder / "b.npy").shape, (std::vector<uint64_t>{6}));
  write_npy(folder / "c.npy", {}, 0, 3);
  EXPECT_EQ(read_npy(folder / "c.npy").shape, (std::vector<uint64_t>{0, 3}));
}

TEST(Npy, RefusesATruncatedFile) {
  const tests::TemporaryFolder folder;
  write_npy(folder / "a.npy", std::vector<float>(30), 10, 3);
  const std::string whole = read_file(folder / "a.npy", "array");
  for (const size_t length : {size_t{0}, size_t{5}, size_t{9}, size_t{40}, whole.size() - 1}) {
    write_file(folder / "b.npy", whole.substr(0, length));
    EXPECT_THROW(read_npy(folder / "b.npy"), Failure) << length;
  }
}

TEST(AtomicFile, LeavesNothingButTheFile) {
  const tests::TemporaryFolder folder;
  write_file(folder / "a.txt", std::string_view("content"));
  EXPECT_EQ(read_file(folder / "a.txt", "text"), "content");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()), 1);
  EXPECT_THROW(write_file(folder / "missing/a.txt", std::string_view("x")), Failure);
  EXPECT_THROW(read_file(folder / "b.txt", "text"), Failure);
}

// The second Ctrl-C comes in the middle of a file: its temporary name is a pipe, which takes no more than its buffer.
TEST(AtomicFile, ASecondCtrlCLeavesNothingHalfWritten) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer keeps a signal back while a call of write waits";
#endif
  const tests::TemporaryFolder folder;
  const std::string path = (folder / "a.txt");
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    listen_for_interrupt();
    std::raise(SIGINT);
    if (!interrupted() || mkfifo((path + ".unfinished." + std::to_string(getpid())).c_str(), 0600) != 0) _exit(3);
    write_file(path, std::string(1 << 24, 'x'));
    _exit(4);
  }
  fs::path pipe;
  while (pipe.empty() && waitpid(child, nullptr, WNOHANG) == 0)
    for (const auto& entry : fs::directory_iterator(folder.path)) pipe = entry.path();
  const int reader = open(pipe.c_str(), O_RDONLY);  // returns once the other end is open
  ASSERT_GE(reader, 0);
  char byte = 0;
  ASSERT_EQ(::read(reader, &byte, 1), 1);  // the child is writing
  kill(child, SIGINT);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  close(reader);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) << status;
  EXPECT_TRUE(fs::is_empty(folder.path)) << pipe;
}

TEST(Progress, SaysHowLongItWillTake) {
  EXPECT_EQ(progress_line("working", 25, 100, 5.0), "working 25/100 (25 %), 15 s left");
  EXPECT_EQ(progress_line("working", 0, 100, 5.0), "working 0/100 (0 %)");
  EXPECT_EQ(progress_line("working", 100, 100, 5.0), "working 100/100 (100 %)");
}

TEST(Progress, IsSilentForTwoSecondsAndThenWritesPlainLinesNowAndThen) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  {
    Progress progress("working", 100, file);
    const auto now = std::chrono::steady_clock::now();
    progress.done_at(1, now + 500ms);
    progress.done_at(5, now + 1900ms);
    EXPECT_EQ(std::ftell(file), 0);
    progress.done_at(10, now + 3s);
    progress.done_at(11, now + 4s);
    progress.done_at(50, now + 10s);
  }
  std::rewind(file);
  char text[400] = {};
  const size_t length = std::fread(text, 1, sizeof text - 1, file);
  std::fclose(file);
  const std::string written(text, length);
  EXPECT_EQ(std::count(written.begin(), written.end(), '\n'), 2);
  EXPECT_NE(written.find("working 10/100"), std::string::npos) << written;
  EXPECT_NE(written.find("working 50/100"), std::string::npos) << written;
  EXPECT_EQ(written.find('\r'), std::string::npos);
}

TEST(ThreadPool, OneThreadNeedsNoPool) {
  ThreadPool pool(1);
  EXPECT_EQ(pool.hook().run, nullptr);
}

TEST(ThreadPool, RunsEveryIndexOnceInEveryCall) {
  constexpr uint32_t k_calls = 3000, k_count = 37;
  ThreadPool pool(4);
  const sandglass_parallel hook = pool.hook();
  std::vector<std::atomic<uint32_t>> hits(k_count);
  for (uint32_t call = 0; call < k_calls; ++call)
    hook.run(
        hook.user,
        [](void* context, uint32_t index) {
          (*static_cast<std::vector<std::atomic<uint32_t>>*>(context))[index].fetch_add(1);
        },
        &hits, call % (k_count + 1));
  // Index i is part of every call with more than i items. The 3000 calls cycle through counts of 0..37.
  for (uint32_t index = 0; index < k_count; ++index) {
    uint32_t expected = 0;
    for (uint32_t call = 0; call < k_calls; ++call) expected += index < call % (k_count + 1);
    EXPECT_EQ(hits[index].load(), expected);
  }
}

}  // namespace
}  // namespace sandglass::host
