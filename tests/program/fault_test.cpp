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

  // The command that estimates the light of a photograph, by a network of random numbers, into a folder.
  std::string light() const {
    write("files/in/random.light", random_network());
    host::write_png(there("in/photo.png"), host::Picture(64, 48, {90, 120, 40}));
    return "light " + there("in/photo.png") + " --fov 60 --network " + there("in/random.light") + " -o " + there("out");
  }

  // In the next run the call that this line of the last one's list begins with has no permission.
  std::string denied_at(const std::string& beginning) const {
    std::istringstream calls(read(path("calls")));
    int number = 1;
    for (std::string line; std::getline(calls, line) && !line.starts_with(beginning);) ++number;
    EXPECT_TRUE(calls) << "no call was: " << beginning;
    return "SANDGLASS_FAULT_AT=" + std::to_string(number) + " SANDGLASS_FAULT_ERROR=" + std::to_string(EACCES);
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
    if (faults.marked.empty()) return;
    const bool marked = fs::exists(fs::path(faults.marked) / host::k_incomplete);
    if (done) EXPECT_FALSE(marked);
    // It failed before it began the folder, or the mark stays.
    else EXPECT_TRUE(marked || !fs::exists(faults.marked) || fs::is_empty(faults.marked)) << outcome.err;
  }

  // The errors that an operation can end with.
  static std::vector<int> errors_of(const std::string& operation) {
    static const std::map<std::string, std::vector<int>> k_errors = {{"open", {EACCES, EMFILE}},
                                                                     {"read", {EIO, EINTR, k_short}},
                                                                     {"write", {ENOSPC, EIO, k_short}},
                                                                     {"close", {ENOSPC}},
                                                                     {"stat", {EIO}},
                                                                     {"access", {EACCES}},
                                                                     {"realpath", {EACCES}},
                                                                     {"readdir", {EIO}},
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
          if (*on != '\0' && error != ENOSPC && operation != "stat") continue;
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

// Everything is done but one: the mark of the folder cannot be removed. The command says so, and the mark stays.
TEST_F(Fault, AMarkThatCannotBeRemovedIsSaid) {
  const std::string command = light(), mark = there("out/") + host::k_incomplete;
  put_old({});
  ASSERT_EQ(run_with("", command).code, 0) << read(path("stderr"));
  const std::string answer = read(there("out/photo.json"));
  EXPECT_FALSE(answer.empty());
  const std::string denied = denied_at("unlink " + mark);
  put_old({});
  const Outcome outcome = run_with(denied, command);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("cannot remove \"" + mark), std::string::npos) << outcome.err;
  EXPECT_TRUE(fs::exists(mark));
  EXPECT_EQ(read(there("out/photo.json")), answer);
}

// Commands that draw, trace or train, and so take minutes in all: `./sg test --full` sets the variable.
class EveryFault : public Fault {
 protected:
  void SetUp() override {
    Fault::SetUp();
    if (std::getenv("SANDGLASS_EVERY_FAULT") == nullptr) GTEST_SKIP() << "SANDGLASS_EVERY_FAULT is not set";
  }
};

TEST_F(EveryFault, OfADataset) {
  fs::create_directories(there("in/rooms"));
  panorama("files/in/rooms/room.hdr", 20);
  every_call_fails({"dataset " + there("in/rooms") + " -o " + there("out"), {}, there("out")});
}

TEST_F(EveryFault, OfARunWithReports) {
  const std::string scene = there("in/tiny.json");
  fs::copy(tiny_scene(), scene);
  every_call_fails({"run " + scene + " --frames 1 --out " + there("out"), {}, there("out")});
}

TEST_F(EveryFault, OfAPicture) {
  every_call_fails({"sample box --surface --distance 0.3 -o " + there("out/x.ply") + " --picture " + there("out/x.png"),
                    {there("out/x.ply"), there("out/x.png")},
                    ""});
}

TEST_F(EveryFault, OfLight) { every_call_fails({light(), {}, there("out")}); }

TEST_F(EveryFault, OfARoom) {
  if (!k_embree) GTEST_SKIP() << "needs a room, and this build has no Embree to trace one";
  const std::string hdr = there("out/room.hdr"), png = there("out/room.png");
  every_call_fails({"room --seed 3 --width 64 --samples 1 -o " + hdr + " --picture " + png, {hdr, png}, ""});
}

TEST_F(EveryFault, OfABake) {
  if (!k_bake) GTEST_SKIP() << "this build bakes no shadows";
  every_call_fails(
      {"bake box --size 8x1 --steps 1 --quantised-steps 0 --textures 1 --validation-lights 1 --ambient-texels 16 -o " +
           there("out/x.shadow"),
       {there("out/x.shadow"), there("out/x.shadow.png")},
       ""});
}

// The control.
TEST_F(Fault, TheFaultsAreReal) {
  const std::string command = "sample box --surface --distance 0.3 -o " + there("x.ply");
  ASSERT_EQ(run_with("", command).code, 0);
  fs::remove(there("x.ply"));
  const Outcome outcome = run_with(denied_at("open " + there("x.unfinished.")), command);
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
