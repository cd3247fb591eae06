// Bullet, a rigid-body engine, on a scene of ours: what a general engine makes of the same spheres, for the granular
// benchmark. It is set up in Bullet's favour. Bullet works badly at centimetre scale, so lengths, and gravity with
// them, are scaled by 100. A frame is stepped in parts of at most 5 ms. Its pools have room for all contacts of the
// scene.
#pragma once

#include <cstdint>

#include "models/simulation/scene_file.h"
#include "tests/laboratory/sand/granular_bench.h"

namespace sandglass::host {

// Whether this build found Bullet; without it bench_bullet is a Failure that says so.
bool bullet_available();

// The particles of the scene as rigid spheres, its half-spaces as static planes, from the same start, on one thread.
// No grains: `ms_solver` is all of the time. The scene is a column of sand at rest on a floor, as in column14k.
BenchRow bench_bullet(SceneFile scene, uint32_t frames, const BenchStep& step);

}  // namespace sandglass::host
