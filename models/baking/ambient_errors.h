// How far an ambient shadow is from the truth by rays, in rooms that it was not fitted to.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "models/baking/cell_visibility.h"
#include "models/baking/environment.h"
#include "models/files/image.h"

namespace sandglass::host {

// Root mean square errors of the share of light that is left, over the square; the mean of all rooms. The noise of the
// truth is not in them.
struct AmbientErrors {
  uint32_t rooms = 0;
  double none = 0;       // no shadow
  double occlusion = 0;  // ambient occlusion alone: the light of a uniform sky
  double cells = 0;      // the room's own light in its cells, with the visibility as it was traced
  double shipped = 0;    // the same as the runtime draws it
};

// What the errors are measured on. `file` is a baked file with the ambient shadow; `hidden` is what its components were
// found from.
struct AmbientCandidate {
  const EmbreeScene& object;
  const FloorSquare& square;
  std::span<const float> hidden;
  std::span<const uint8_t> file;
};

AmbientErrors measure_ambient(const AmbientCandidate& candidate, std::span<const Environment> rooms, uint64_t seed,
                              ThreadPool& pool);

// The share of the room's light that each texel receives, by `rays` rays a texel.
std::vector<float> trace_ambient(const EmbreeScene& object, const FloorSquare& square, const Environment& room,
                                 uint32_t rays, uint64_t seed, ThreadPool& pool);

// Made-up rooms, small: equal numbers give equal rooms, and no other part of the program uses these seeds.
std::vector<Environment> made_up_environments(uint32_t count, uint32_t threads);

// The interiors of a data folder, in the order of their names; none where the folder is not there.
std::vector<Environment> captured_environments(const std::string& folder);

// Three pictures a room: ray tracing, the runtime's texture, and their difference times 8 around grey.
std::vector<Picture> ambient_pictures(const AmbientCandidate& candidate, std::span<const Environment> rooms,
                                      ThreadPool& pool);

}  // namespace sandglass::host
