// What the suites of `sandglass_lab verify` share: claims as a table on the terminal and for --json.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/files/measurement_json.h"
#include "tests/laboratory/sand/granular_verdicts.h"
#include "tests/laboratory/suite.h"

namespace sandglass::host {

// Of several suites. One that takes more inherits these.
struct VerifyOptions {
  std::string json, isa = "automatic", manifest, network, picture;
  std::vector<std::string> cases, panoramas, meshes;
  bool quick = false;
  uint64_t seed = 0;
  uint32_t threads = 1;
};

CommandOption cases_option(VerifyOptions& o, const char* help, const std::vector<std::string>& all);
CommandOption panoramas_option(VerifyOptions& o, const char* standard_text = "the interiors of SANDGLASS_DATA_DIR");
CommandOption manifest_option(VerifyOptions& o);
CommandOption network_option(VerifyOptions& o, const char* help);

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
