// The program as a script sees it, for the tests of this folder: exit code, output, one line on stderr when it refuses.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

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
  return std::string(SANDGLASS_EMULATOR) + " '" + (laboratory ? SANDGLASS_LAB : SANDGLASS_PROGRAM) + "' " + arguments;
}

// The program while it runs.
class Running {
 public:
  Running(const std::string& arguments, const std::string& out, const std::string& err) {
    const std::string command = "exec " + command_line(arguments) + " >'" + out + "' 2>'" + err + "'";
    child_ = ::fork();
    if (child_ == 0) {
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
  }
  ~Running() {
    if (child_ > 0) ::kill(child_, SIGKILL), ::waitpid(child_, nullptr, 0);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  // False when the program ends, or 30 s pass, before the file is there.
  bool makes(const fs::path& file) const {
    for (const auto from = Clock::now(); Clock::now() - from < std::chrono::seconds(30);) {
      if (fs::exists(file)) return true;
      if (::kill(child_, 0) != 0) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
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

  std::string path(const std::string& name) const { return place / name; }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }
  static std::string read(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  Outcome run(const std::string& arguments) const {
    const std::string command = command_line(arguments) + " >'" + path("stdout") + "' 2>'" + path("stderr") + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(path("stdout")), read(path("stderr"))};
  }
  // Expects exit code 2 and one line on stderr. It starts with the program's name, contains `named` and ends in a full stop.
  void expect_refused(const std::string& arguments, const std::string& named) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.out << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("sandglass") && outcome.err.ends_with(".\n")) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out.find("hash"), std::string::npos);
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
  std::string panorama(const std::string& name, int lamp, double blue = 0.2) const {
    host::RadianceMap map(64, 32);
    for (int v = 0; v < 32; ++v)
      for (int u = 0; u < 64; ++u) map.set(u, v, {0.3, 0.4, u == lamp && v == 5 ? 90.0 : blue});
    fs::create_directories((folder / name).parent_path());
    host::write_hdr(path(name), map);
    return path(name);
  }
  std::string tiny_scene(const std::string& more = "") const {
    return write(
        "tiny.json",
        R"({"frames": 3, "particle_radius": 0.01, )" + more +
            R"("bodies": [{"shape": "box", "size": [0.06, 0.08, 0.06], "grains": 200, "position": [0, 0.02, 0]}],
                                  "colliders": [{"shape": "half_space"}]})");
  }
  // The content of a lighting network of random numbers.
  static std::string random_network() {
    const std::vector<uint8_t> bytes = host::light_file_bytes(host::random_light_file(3));
    return {bytes.begin(), bytes.end()};
  }
  std::string mesh_scene() const {
    return write("mesh.json", R"({"frames": 2, "particle_radius": 0.01, "bodies": [{"shape": "mesh", "size": 0.1}]})");
  }
};

#ifdef SANDGLASS_HAVE_ASSIMP
constexpr bool k_assimp = true;
#else
constexpr bool k_assimp = false;
#endif
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
