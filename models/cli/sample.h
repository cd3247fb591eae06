// The sub-command `sandglass sample`: points on a mesh's surface or in its volume, as a PLY file and a picture.
#pragma once

#include <cstdint>
#include <string>

namespace CLI {
class App;
}

namespace sandglass::host {

enum class SampleWhat { surface, volume, lattice };

struct SampleOptions {
  std::string mesh;  // a file, or the name of a generated mesh (see make_named)
  SampleWhat what = SampleWhat::surface;
  double distance = 0;  // metres
  uint64_t seed = 1;
  bool geodesic = false;  // surface only
  std::string picture;    // PNG; empty: none
  std::string output;     // PLY
};

// Returns the exit code: 0 done, 2 bad input with one sentence on stderr. A line on stdout says how many points there
// are and what they lie on.
int sample_command(const SampleOptions& options);

void add_sample_command(CLI::App& program, int* exit_code);

}  // namespace sandglass::host
