// Sand on the heights that a relief gathers from a recording.
#pragma once

#include "tests/laboratory/relief/depth_table.h"
#include "tests/laboratory/relief/relief_take.h"

namespace sandglass::host {

// Where and when sand is poured: along a curve over all things, from 3 to 5 s; onto the box before it is taken away; where
// it will be put.
enum class Pouring { everywhere, onto_the_box, where_it_comes };

struct SandOnRelief {
  double awake = 0;    // of 100 particles, once the pile has lain for 6 s
  double floats = 0;   // particles where the box stood, at the end, that touch nothing, or only what is not there
  double fastest = 0;  // m/s, from when the box is put there
};

// `dense`: beside a body of five times the density of sand. Then sand leaves what it is in 25 times as fast.
SandOnRelief sand_on_relief(const DepthRecording& recording, uint64_t seed, Pouring pouring, Left left = Left::nothing,
                            bool dense = false);

}  // namespace sandglass::host
