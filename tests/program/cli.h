// The program as a script sees it, for the tests of this folder: exit code, output, one line on stderr when it refuses.
// It runs in a folder of the test's own, so commands name their files without one.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "models/files/image.h"
#include "models/lighting/light_file.h"
#include "models/rooms/panorama_file.h"
#include "tests/temporary_folder.h"

namespace sandglass {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;
  std::string out, err;
};

// Suites of the laboratory are its own program's.
inline std::string command_line(const std::string& arguments) {
  const bool laboratory = arguments.starts_with("verify ") || arguments.starts_with("bench ");
  return std::string(SANDGLASS_EMULATOR) + " '" + (laboratory ? SANDGLASS_LAB : SANDGLASS_PROGRAM) + "' " + arguments +
         " >stdout 2>stderr";
}

// The program while it runs.
class Running {
 public:
  Running(const fs::path& folder, const std::string& arguments) {
    const std::string command = "cd '" + folder.string() + "' && exec " + command_line(arguments);
    child_ = ::fork();
    if (child_ == 0) {
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
  }
  ~Running() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  // Waits until something holds. False when the program ends, or a minute passes, before that.
  template <class Condition>
  bool reaches(const Condition& holds) const {
    for (const auto from = Clock::now(); Clock::now() - from < std::chrono::minutes(1);) {
      if (holds()) return true;
      siginfo_t ended = {};
      if (::waitid(P_PID, static_cast<id_t>(child_), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 || ended.si_pid != 0)
        return holds();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  // Waits until it has used so much CPU time: then it is in the middle of its work, on a busy machine too.
  bool works(double seconds) const {
    return reaches([&] {
      clockid_t clock;
      timespec used = {};
      if (::clock_getcpuclockid(child_, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return false;
      return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec) >= seconds;
    });
  }
  void interrupt() {
    ::kill(child_, SIGINT);
    interrupted_ = Clock::now();
  }
  // The exit code, or minus the signal that ended it. *seconds gets the time since interrupt().
  int wait(double* seconds = nullptr) {
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = -1;
    if (seconds != nullptr) *seconds = std::chrono::duration<double>(Clock::now() - interrupted_).count();
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  using Clock = std::chrono::steady_clock;
  pid_t child_ = -1;
  Clock::time_point interrupted_;
};

class Cli : public ::testing::Test {
 protected:
  const tests::TemporaryFolder place;
  const fs::path& folder = place.path;
  void SetUp() override { ::unsetenv("SANDGLASS_DATA_DIR"); }  // a test that needs a data folder makes one

  void write(const std::string& name, const std::string& content) const {
    fs::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << content;
  }
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder / name, std::ios::binary).rdbuf();
    return text.str();
  }
  bool exists(const std::string& name) const { return fs::exists(folder / name); }
  // What lies in the folder, without what the test's own calls write.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path().filename().string());
    std::erase_if(all, [](const std::string& name) { return name == "stdout" || name == "stderr"; });
    std::sort(all.begin(), all.end());
    return all;
  }
  Outcome run(const std::string& arguments) const {
    const int status = std::system(("cd '" + folder.string() + "' && " + command_line(arguments)).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read("stdout"), read("stderr")};
  }
  Outcome done(const std::string& arguments) const {
    Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
    return outcome;
  }
  // Expects exit code 2 and one line on stderr. It starts with the program's name, contains `named` and ends in a full
  // stop.
  void expect_refused(const std::string& arguments, const std::string& named) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.out << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("sandglass") && outcome.err.ends_with(".\n")) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << arguments << "\n" << named << "\n" << outcome.err;
    EXPECT_EQ(outcome.out.find("hash"), std::string::npos);
  }
  // Each line of the table is a command and what its refusal says, "run nowhere | no file". No command leaves a file, or
  // changes one.
  void expect_refusals(const std::string& table) const {
    const std::vector<std::string> before = names();
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
      const size_t bar = line.find(" | ");
      if (bar == std::string::npos) continue;
      expect_refused(line.substr(0, bar), line.substr(bar + 3));
      EXPECT_EQ(names(), before) << line;
    }
  }
  // The names that a command's help lists: commands, suites, or options.
  std::vector<std::string> listed(const std::string& command) const {
    std::vector<std::string> names;
    std::istringstream lines(run(command + " --help").out);
    for (std::string line, name; std::getline(lines, line);)
      if (line.starts_with("  ") && line[2] != ' ' && std::istringstream(line) >> name) names.push_back(name);
    return names;
  }
  // A small room with a lamp in a column of its panorama.
  void panorama(const std::string& name, int lamp, double blue = 0.2) const {
    host::RadianceMap map(64, 32);
    for (int v = 0; v < 32; ++v)
      for (int u = 0; u < 64; ++u) map.set(u, v, {0.3, 0.4, u == lamp && v == 5 ? 90.0 : blue});
    fs::create_directories((folder / name).parent_path());
    host::write_hdr(place / name, map);
  }
  void photograph(const std::string& name, host::Colour colour = {90, 120, 40}, int width = 64) const {
    host::write_png(place / name, host::Picture(width, std::max(1, width * 3 / 4), colour));
  }
  // The scene tiny.json; `more` are further keys of it.
  void tiny_scene(const std::string& more = "", const std::string& name = "tiny.json") const {
    write(name,
          R"({"frames": 3, "particle_radius": 0.01, )" + more +
              R"("bodies": [{"shape": "box", "size": [0.06, 0.08, 0.06], "grains": 200, "position": [0, 0.02, 0]}],
                                  "colliders": [{"shape": "half_space"}]})");
  }
  void mesh_scene() const {
    write("mesh.json", R"({"frames": 2, "particle_radius": 0.01, "bodies": [{"shape": "mesh", "size": 0.1}]})");
  }
  // random.light, a lighting network of random numbers; and its content.
  std::string random_network() const {
    const std::vector<uint8_t> bytes = host::light_file_bytes(host::random_light_file(3));
    write("random.light", {bytes.begin(), bytes.end()});
    return {bytes.begin(), bytes.end()};
  }
};

#ifdef SANDGLASS_HAVE_EMBREE
constexpr bool k_embree = true;  // Embree traces rooms
#else
constexpr bool k_embree = false;
#endif
#ifdef SANDGLASS_HAVE_BAKE
constexpr bool k_bake = true;  // Embree traces, Eigen trains
#else
constexpr bool k_bake = false;
#endif

constexpr const char* k_cube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

}  // namespace sandglass
