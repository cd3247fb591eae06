// The one format that scripts read: an array of flat objects {suite, case, metric, value, unit, isa, threads}; verify's
// objects also carry truth, limit, pass and control.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sandglass::host {

struct Measurement {
  std::string suite, scene, metric, unit, isa;
  double value = 0.0;
  uint32_t threads = 1;
  struct Judgement {
    double truth, limit;
    bool pass, control;
  };
  std::optional<Judgement> judgement;
};

// Numbers that are not finite become null.
std::string measurements_json(const std::vector<Measurement>& measurements);

}  // namespace sandglass::host
