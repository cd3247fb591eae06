// Every file operation of a command fails in turn: the disk is full, a write is short, the disk does not answer, there
// is no permission. The command then says so and ends with an exit code, or what it made is whole all the same. What
// lay under an output's name before is there unharmed, and no unfinished file stays behind.
//
// failing_files.c, preloaded into the program, makes the call with a given number fail. A first run, in which none
// fails, lists the calls.
#include <cerrno>
#include <cstring>
#include <map>
#include <set>

#include "models/files/command_files.h"
#include "models/files/image.h"
#include "tests/program/cli.h"

namespace sandglass {
namespace {

constexpr const char* k_old = "what lay there before";
constexpr int k_short = 0;  // not an error: a read or a write ends after one byte

struct Faults {
  std::string command;
  std::vector<std::string> outputs;  // whose bytes are the same in every run
  std::string marked;                // a folder that holds the mark of an incomplete one, until the command is done
};

class Fault : public Cli {
 protected:
  // The files that commands read and write. Calls about others, such as the program's own libraries, do not fail.
  std::string there(const std::string& name) const { return path("files/" + name); }
  void SetUp() override {
    Cli::SetUp();
    fs::create_directories(there("in"));
  }

  Outcome run_with(const std::string& faults, const std::string& command) const {
    const std::string shell = "SANDGLASS_FAULT_FOLDER='" + there("") + "' SANDGLASS_FAULT_LOG='" + path("calls") +
                              "' " + faults +
                              " PATH=/nowhere LD_PRELOAD='" SANDGLASS_FAILING_FILES "' '" SANDGLASS_PROGRAM "' " +
                              command + " >'" + path("stdout") + "' 2>'" + path("stderr") + "'";
    const int status = std::system(shell.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(path("stdout")), read(path("stderr"))};
  }

  void put_old(const Faults& faults) const {
    fs::remove_all(there("out"));
    fs::create_directories(there("out"));
    for (const std::string& output : faults.outputs) std::ofstream(output, std::ios::binary) << k_old;
  }

  // What must hold after a run in which `operation` failed.
  void check(const Faults& faults, const std::map<std::string, std::string>& made, const std::string& operation,
             int error, const Outcome& outcome) const {
    const bool done = outcome.code == 0;
    EXPECT_TRUE(done || outcome.code == 2) << "it ends with " << outcome.code << "\n" << outcome.err;
    EXPECT_TRUE(done || error != k_short) << outcome.err;
    if (!done) {
      const size_t line = outcome.err.rfind("sandglass: ");
      EXPECT_TRUE(line != std::string::npos && outcome.err.ends_with(".\n")) << outcome.err;
    }
    for (const auto& [name, bytes] : made) {
      const std::string now = read(name);
      EXPECT_TRUE(now == bytes || (!done && now == k_old)) << name << " has " << now.size() << " bytes";
    }
    for (const auto& entry : fs::recursive_directory_iterator(there("")))
      EXPECT_TRUE(operation == "unlink" || entry.path().string().find(".unfinished.") == std::string::npos)
          << entry.path();
    if (!faults.marked.empty() && done) {
      EXPECT_FALSE(fs::exists(fs::path(faults.marked) / host::k_incomplete));
    }
  }

  // The errors that an operation can end with.
  static std::vector<int> errors_of(const std::string& operation) {
    static const std::map<std::string, std::vector<int>> k_errors = {{"open", {EACCES, EMFILE}},
                                                                     {"opendir", {EACCES}},
                                                                     {"read", {EIO, EINTR, k_short}},
                                                                     {"write", {ENOSPC, EIO, k_short}},
                                                                     {"close", {ENOSPC}},
                                                                     {"stat", {EIO}},
                                                                     {"truncate", {EIO}},
                                                                     {"lock", {ENOLCK}},
                                                                     {"rename", {EACCES}},
                                                                     {"unlink", {EACCES}},
                                                                     {"mkdir", {ENOSPC}}};
    return k_errors.at(operation);
  }

  void every_call_fails(const Faults& faults) const {
    put_old(faults);
    const Outcome undisturbed = run_with("", faults.command);
    ASSERT_EQ(undisturbed.code, 0) << undisturbed.err;
    std::map<std::string, std::string> made;
    for (const std::string& output : faults.outputs) made[output] = read(output);
    std::istringstream calls(read(path("calls")));
    std::map<std::string, int> seen;
    std::set<std::string> operations;
    int number = 0, tried = 0;
    for (std::string line; std::getline(calls, line);) {
      ++number;
      // A file in many pieces: its first two speak for all.
      if (++seen[line] > 2) continue;
      const std::string operation = line.substr(0, line.find(' '));
      operations.insert(operation);
      for (const int error : errors_of(operation)) {
        for (const char* on : {"", " SANDGLASS_FAULT_ON=1"}) {
          if (*on != '\0' && error != ENOSPC) continue;
          put_old(faults);
          const Outcome outcome = run_with(
              "SANDGLASS_FAULT_AT=" + std::to_string(number) + " SANDGLASS_FAULT_ERROR=" + std::to_string(error) + on,
              faults.command);
          SCOPED_TRACE(line + ": " + (error == k_short ? "one byte" : std::strerror(error)) + on);
          // A short write is one that this shim reports and the disk did not say why: as good as a full disk.
          check(faults, made, operation, error == k_short && operation == "write" ? ENOSPC : error, outcome);
          ++tried;
        }
      }
    }
    EXPECT_GE(operations.size(), 3u) << "nothing was watched";
    std::printf("%d calls, %d faults\n", number, tried);
  }
};

TEST_F(Fault, NothingIsLostWhenAnOutputFails) {
  every_call_fails({"sample box --surface --distance 0.3 -o " + there("out/x.ply"), {there("out/x.ply")}, ""});
}

TEST_F(Fault, NothingIsLostWhenARecordingFails) {
  const std::string scene = there("in/tiny.json");
  fs::copy(tiny_scene(), scene);
  every_call_fails(
      {"run " + scene + " --frames 1 --clock virtual --record " + there("out/r.sgrec"), {there("out/r.sgrec")}, ""});
}

TEST_F(Fault, InputsThatFailAreNamed) {
  const std::string scene = there("in/tiny.json");
  fs::copy(tiny_scene(), scene);
  ASSERT_EQ(run("run " + scene + " --frames 1 --record " + there("in/r.sgrec")).code, 0);
  every_call_fails({"run " + scene + " --frames 1 --replay " + there("in/r.sgrec"), {}, ""});
}

// Commands that draw or train, and so take minutes in all.
TEST_F(Fault, NothingIsLostWhenAFolderOrAPictureFails) {
  if (std::getenv("SANDGLASS_EVERY_FAULT") == nullptr) GTEST_SKIP() << "SANDGLASS_EVERY_FAULT is not set";
  const std::string scene = there("in/tiny.json"),
                    sample = "sample box --surface --distance 0.3 -o " + there("out/x.ply");
  fs::copy(tiny_scene(), scene);
  fs::create_directories(there("in/rooms"));
  panorama("files/in/rooms/room.hdr", 20);
  every_call_fails({"dataset " + there("in/rooms/room.hdr") + " -o " + there("out"), {}, there("out")});
  every_call_fails({"run " + scene + " --frames 1 --out " + there("out"), {}, there("out")});
  every_call_fails({sample + " --picture " + there("out/x.png"), {there("out/x.ply"), there("out/x.png")}, ""});
  if (!k_bake) return;
  every_call_fails(
      {"bake box --size 8x1 --steps 1 --quantised-steps 0 --textures 1 --validation-lights 1 --ambient-texels 16 -o " +
           there("out/x.shadow"),
       {there("out/x.shadow"), there("out/x.shadow.png")},
       ""});
}

// The control.
TEST_F(Fault, TheFaultsAreReal) {
  const Outcome outcome = run_with("SANDGLASS_FAULT_AT=1 SANDGLASS_FAULT_ERROR=" + std::to_string(EACCES),
                                   "sample box --surface --distance 0.3 -o " + there("x.ply"));
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  EXPECT_NE(outcome.err.find("x.ply"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(there("x.ply")));
}

// What a command says is a result, too: a full disk behind it is no success.
TEST_F(Fault, WhatIsSaidIsNotLostInSilence) {
  const std::string command =
      "'" SANDGLASS_PROGRAM "' inspect " + tiny_scene() + " >/dev/full 2>'" + path("stderr") + "'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  EXPECT_NE(read(path("stderr")).find("sandglass: "), std::string::npos) << read(path("stderr"));
}

}  // namespace
}  // namespace sandglass
