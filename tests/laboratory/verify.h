// What the suites of `sandglass_lab verify` share: claims as a table on the terminal and for --json.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/files/measurement_json.h"
#include "models/program/command_line.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// Of all suites; verify.cpp says which takes what.
struct VerifyOptions {
  std::string json, isa = "automatic", manifest, estimates, network, folder, picture, plain;
  std::vector<std::string> cases, panoramas, meshes;
  bool quick = false;
  uint64_t seed = 0;
  uint32_t threads = 1;
};

// One function a suite (verify.cpp ...); each returns the exit code.
int verify_granular_command(const VerifyOptions& options);
int verify_follow_command(const VerifyOptions& options);
int verify_carried_command(const VerifyOptions& options);
int verify_lighting_command(const VerifyOptions& options);
int verify_room_command(const VerifyOptions& options);
int verify_shot_command(const VerifyOptions& options);
int verify_colour_command(const VerifyOptions& options);
int verify_look_command(const VerifyOptions& options);
int verify_files_command(const VerifyOptions& options);
int verify_cast_command(const VerifyOptions& options);
int verify_day_command(const VerifyOptions& options);
std::vector<Command> verify_suites();

// Prints the table, and writes it and `more` where it is asked for. Returns the exit code.
int tell(const VerifyOptions& options, const char* suite, const std::string& isa, const std::vector<Verdict>& rows,
         const std::vector<Measurement>& more = {});
uint32_t count_failed(const std::vector<Verdict>& rows);
std::vector<Measurement> measurements_of(const std::string& suite, const std::string& isa, uint32_t threads,
                                         const std::vector<Verdict>& rows);

// The panoramas that are named, or these of the data folder. A Failure where there is neither: a suite would check nothing,
// and pass. `what` it checks.
std::vector<std::string> panoramas_of(const VerifyOptions& options, const char* what,
                                      std::vector<std::string> in_data = {"indoor", "studio"});
// Which of them show the same place; empty: none.
std::string manifest_of(const VerifyOptions& options);

}  // namespace sandglass::host
