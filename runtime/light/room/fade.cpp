// A light that was shown, on its way to the light that is known now.
//
// Floor shadows are linear in the cells, so a mixture of two lights casts the mixture of their shadows: nothing jumps.
// The sharp shadow has one direction and cannot be mixed. Where the main light is now another one, the old one fades
// into its cells before the new one comes out of its own; its shadow never sweeps across the floor.
#include "platform/floating_point.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "sandglass/room.h"

namespace sandglass {
namespace {

constexpr double k_seconds = 0.5;              // time constant
constexpr float k_not_visible = 0.01f;         // a share of the floor's light: two or three steps of a byte
constexpr double k_same_light = 0.9396926208;  // cosine of 20 degrees: nearer directions are one light

template <uint32_t count>
void mix(float (&shown)[count], const float (&now)[count], float share) {
  for (uint32_t i = 0; i < count; ++i) shown[i] += share * (now[i] - shown[i]);
}

double cosine_between(const float a[3], const float b[3]) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += static_cast<double>(a[k]) * static_cast<double>(b[k]);
  return sum;
}

void turn(float shown[3], const float now[3], float share) {
  double direction[3];
  for (int k = 0; k < 3; ++k) direction[k] = static_cast<double>(shown[k] + share * (now[k] - shown[k]));
  const double squared = square_of(direction);
  for (int k = 0; k < 3; ++k) shown[k] = static_cast<float>(direction[k] / square_root(squared));
}

bool finite(const sandglass_room_light& l) {
  return all_finite(l.cells, SANDGLASS_LIGHT_CELLS) && all_finite(l.ambient_cells, SANDGLASS_LIGHT_CELLS) &&
         all_finite(l.main_direction, 3) && is_finite(l.main_share) && all_finite(l.main_colour, 3) &&
         all_finite(l.irradiance, 3) && all_finite(l.sh, 27) && all_finite(l.floor, 3) && is_finite(l.white) &&
         is_finite(l.main_angular_diameter) && all_finite(l.balance, 3);
}

__attribute__((noinline)) void fade(sandglass_room_light* shown, const sandglass_room_light& now, float seconds) {
  const auto share = static_cast<float>(1 - exponential(static_cast<double>(-seconds) / k_seconds));
  const bool invisible = shown->main_share <= k_not_visible;
  const bool other = !invisible && now.main_share > k_not_visible &&
                     cosine_between(shown->main_direction, now.main_direction) < k_same_light;
  if (invisible) {
    memcpy(shown->main_direction, now.main_direction, sizeof now.main_direction);
    memcpy(shown->main_colour, now.main_colour, sizeof now.main_colour);
    shown->main_angular_diameter = now.main_angular_diameter;
  } else if (!other && now.main_share > k_not_visible) {
    turn(shown->main_direction, now.main_direction, share);
    mix(shown->main_colour, now.main_colour, share);
    // A size that was not known does not grow out of nothing.
    float* size = &shown->main_angular_diameter;
    const bool both = *size > 0 && now.main_angular_diameter > 0;
    *size = both ? *size + share * (now.main_angular_diameter - *size) : now.main_angular_diameter;
  }
  mix(shown->cells, now.cells, share);
  mix(shown->ambient_cells, other ? now.cells : now.ambient_cells, share);
  shown->main_share += share * ((other ? 0 : now.main_share) - shown->main_share);
  // The shown level, in the scale of the image that is now the last. Where the unit is another one, after a reset or the
  // first exposure that was given, the picture on the screen is still the same.
  const bool same = shown->valid != 0 && shown->unit == now.unit;
  const float scale = same && now.white > 0 ? shown->white / now.white : 1;
  for (int c = 0; c < 3; ++c) {
    const float balance = same && shown->balance[c] > 0 ? now.balance[c] / shown->balance[c] : 1;
    shown->irradiance[c] *= scale * balance;
    shown->floor[c] *= scale * balance;
    for (uint32_t i = 0; i < 9; ++i) shown->sh[3 * i + c] *= scale * balance;
    shown->balance[c] = now.balance[c];
  }
  mix(shown->irradiance, now.irradiance, share);
  mix(shown->sh, now.sh, share);
  mix(shown->floor, now.floor, share);
  shown->white = now.white;
  shown->exposure_known = now.exposure_known;
  shown->unit = now.unit;
  shown->valid = now.valid;
  shown->seen = now.seen;
  shown->clipped = now.clipped;
  shown->short_exposure = now.short_exposure;
  shown->main_angular_error = now.main_angular_error;
  memcpy(shown->look, now.look, sizeof now.look);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_room_fade(sandglass_room_light* shown, const sandglass_room_light* now, float seconds) {
  if (shown == nullptr || now == nullptr || now->struct_size < sizeof *now) return;
  if (shown->struct_size < sizeof *shown) {
    *shown = *now;
    return;
  }
  // A new room, of which there is no image yet: what is shown stays.
  if (now->valid == 0 && shown->valid != 0) return;
  // What is shown is mixed with what was: one number that is none would stay.
  if (!within(seconds, 0.0f, 3600.0f) || !finite(*now)) return;
  const ExactFloatingPoint exact;
  fade(shown, *now, seconds);
}
