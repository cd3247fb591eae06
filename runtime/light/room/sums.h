// All sums over the sphere of a room, at a place, of what was seen and what is to be expected elsewhere.
//
// Each part of the sphere counts with
//   X = seen * L * (1 + boost * clipped) + (1 - seen) * fill * (1 + what the network says)
// where L is its radiance beside the geometric mean of all that was seen. It is moved to the object: a part in the
// direction D of the sphere lies in the direction q = D - x from the object at x (in radii), and its solid angle there
// is that of the sphere times (1 - D . x) / |q|^3, by (5.15) to (5.17) of the dissertation. A cell is the mean of X
// over it, weighted by the cosine.
#pragma once

#include "runtime/light/harmonics.h"
#include "runtime/light/room/room.h"

namespace sandglass {

// All sums over the sphere.
struct RoomSums {
  double cells[k_light_cells][3];         // irradiance of the level floor from each cell
  double even[k_light_cells];             // the same of an even sky of radiance 1, as far as the pieces fill the cell
  double seen[k_light_cells];             // luminance of the part of `cells` that was seen
  double moments[k_light_cells][3];       // the same times the direction
  double even_moments[k_light_cells][3];  // `even` times the direction
  double sh[3 * k_harmonics];
  double lasting[k_light_cells];       // luminance of `cells`, if what was seen lasts
  double all_lasting;                  // of the even sky, the part that was seen, if that lasts
  double all_even, all_seen, clipped;  // even sky, the seen part of it; luminance that comes through clipped pixels
};

// What was seen, on the whole.
struct RoomOverview {
  double level;      // geometric mean of the luminance
  double colour[3];  // of luminance 1
  double floor;      // mean luminance of what lies below; 0: not seen
};

// What counts of each part: the share that the camera has seen, as far as it is remembered, and what a probe adds.
struct RoomMemory {
  double seen[k_room_parts];
  double confidence, probe_scale[3];

  double with_probe(double share) const { return share + (1 - share) * confidence; }
  double known(uint32_t i) const { return with_probe(seen[i]); }
};
void room_remember(const Room& room, RoomMemory* memory);
// In the white balance of the last image.
RoomPart room_part_of(const Room& room, const RoomMemory& memory, uint32_t i);
RoomOverview room_overview(const Room& room, const RoomMemory& memory);

// The direction of the network's light in the sphere's frame, and how much it counts.
struct RoomHint {
  double direction[3], weight;
};
RoomHint room_hint(const Room& room, const RoomModel& model, const sandglass_estimator_light* estimate);

// A part as it is known: what it sends out where it was seen, beside the geometric mean, and the shares of it that
// count as seen, now and for the level.
struct KnownPart {
  double lit[3], bright;  // bright: luminance of `lit`
  double clipped;         // share of the pixels that were clipped
  double seen, lasting;
  double up, aside;  // how its light is tilted
};
KnownPart room_known_part(const Room& room, const RoomMemory& memory, uint32_t i, const RoomModel& model,
                          const RoomOverview& all);

// The plane whose light is asked for: a level one, whose azimuth 0 is `yaw` turns away; or its axes (along, normal,
// across) in the sphere's frame.
struct RoomFacing {
  bool level;
  double yaw, axes[3][3];

  void turn(const double sphere[3], double local[3]) const {
    for (int k = 0; k < 3; ++k)
      local[k] = level ? sphere[k] : axes[k][0] * sphere[0] + axes[k][1] * sphere[1] + axes[k][2] * sphere[2];
  }
};
// The cell in whose direction something is, where azimuth 0 is `yaw` turns away.
uint32_t room_cell_of(const double direction[3], double yaw);

void sums_add_sphere(const Room& room, const RoomMemory& memory, const RoomModel& model, const RoomOverview& all,
                     const RoomHint& hint, const double at[3], const RoomFacing& plane, RoomSums* sums);
// A cell is the mean over it, however many pieces lie in it. Far from the sphere's middle a cell may hold none: it is
// then as the next one around that holds some.
void sums_even_out(RoomSums* sums);
// The far light of a probe (probe.cpp), as far as the camera has not seen where it is. It is no piece of the sphere, so
// it does not fill a cell: it is added to cells that were evened out. It moves with the place where the app gives how
// far away the walls are.
void sums_add_far_light(const Room& room, const RoomMemory& memory, const RoomOverview& all, const RoomFacing& plane,
                        const double at[3], RoomSums* sums);

}  // namespace sandglass
