// What has departed: particles that can reach nothing before the interval ends. They fall and fly as all do, but the
// sub-steps are not chosen for their speed, lists are not built for their ways, and they wake nobody. So one fast
// particle does not drive all. Before each interval of simulated time the particles are looked through, where one is
// fast enough to matter. A particle has departed
//
//   below   where it falls, lower than all that is there, with nothing under it. What falls there together keeps the
//           contacts that its lists know.
//   beside  where it is fast, and its way clear of the box that holds all the others, of each collider, and of the ways
//           of the other fast ones. That is for few: from k_fast_most on they are a flow.
//
// What comes back counts again before it touches anything: lists are built then. What has fallen by `lowest`, or is
// beyond the coordinate limit, is gone: the drains take it out.
#pragma once

#include "kernels/kernels.h"
#include "runtime/core/layout.h"
#include "runtime/granular/particles.h"

namespace sandglass {

struct Granular;

// From the highest to the lowest of a body's particles, along gravity; and whether it has departed.
struct BodySpan {
  float top, bottom;
  bool below;
};

constexpr uint32_t k_fast_most = 64;

struct Departed {
  uint32_t count;      // particles, as the last look found
  bool known;          // the look at the interval that begins is done
  bool gone;           // something has to be taken out
  bool grains_go;      // the grains' drain looks for some
  double next_grains;  // simulated time of its next look
  // Of the frame. Depths are along gravity, metres from the origin.
  bool falls;        // there is something to fall from, and no half-space under it
  bool open;         // no collider fills all space beyond it
  bool bounded;      // a collider has an end
  float bottom;      // depth of the lowest thing that is there
  float gone_depth;  // what is deeper is taken out
  // Of the look under way.
  BodySpan* spans;  // one a body
  float below;      // depth from which on sand has departed
  float horizon;    // seconds
  Bounds others, fast_ones;
  float others_speed2, fast_speed2;
  uint32_t found, fast_count;
  uint32_t fast[k_fast_most];
  bool returned;  // one that had departed has not any more
};

void departed_layout(Departed* departed, const sandglass_granular_desc& desc, Layout* layout);
void departed_reset(Departed* departed);
// Nothing has departed, for all that is known. Finds what rests.
void departed_forget(Granular* granular);

// Takes a frame's colliders and gravity.
void departed_begin_frame(Granular* granular);

// The phase before an interval.
bool departed_due(const Granular& granular);
uint32_t departed_items(const Granular& granular);
bool departed_run(Granular* granular);

// After a sweep: whether grains are to be looked for that are gone.
bool departed_takes_grains(Granular* granular);
// Whether it has left what is there, so that a move may lose it. Rigid bodies and the boundary never have.
bool departed_has_left(const Granular& granular, const Particle& particle);
bool departed_has_left(const Granular& granular, const Grain& grain);
// Whether what is here has fallen too far, or flown.
bool departed_is_gone(const Granular& granular, const float position[3]);

}  // namespace sandglass
