// The sub-command `sandglass sample`: points on a mesh's surface or in its volume, or of a disk, sphere or ring, as a
// PLY file, a picture and a spectrum.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

class Command;

enum class SampleWhat { surface, volume, lattice, disk, sphere, ring };

struct SampleOptions {
  std::string mesh;  // a file, or the name of a generated mesh (see make_named)
  SampleWhat what = SampleWhat::surface;
  double distance = 0;  // metres; of disk, sphere and ring the mean spacing follows from `count`
  uint32_t count = 0;   // points of a disk, sphere or ring of radius 1
  std::vector<double> polar_deg = {0.0, 45.0};  // of a ring
  uint64_t seed = 1;
  bool geodesic = false;  // surface only
  std::string picture;    // PNG; empty: none
  std::string spectrum;   // PNG of the radial mean of the power spectrum; empty: none
  std::string output;     // PLY
};

// Returns the exit code: 0 done, 2 bad input with one sentence on stderr. A line on stdout says how many points there
// are and what they lie on.
int sample_command(const SampleOptions& options);

void add_sample_command(Command& program, int* exit_code);

}  // namespace sandglass::host
