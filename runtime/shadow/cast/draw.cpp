// One texture: its directions and its rectangle, the images of all directions, and their count.
//
// Counts are kept as bit planes: word i of plane b holds bit b of the counts of 64 texels. Adding an image is then a chain of
// half adders, 64 texels at a time.
#include <cstring>

#include "runtime/math/math.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr float k_rim = 4;  // texels at the rim of an ambient texture over which it fades: none is drawn beyond

// The least number of the form 2^(k / 8) that is not below x, so that a texel keeps its size while a shadow changes a
// little.
double texel_size(double x) {
  constexpr double k_eighth = 1.0905077326652577;
  double size = 1;
  while (size < x) size *= 2;
  while (0.5 * size >= x) size *= 0.5;
  double finer = 0.5 * size;
  while (finer < x) finer *= k_eighth;
  return finer < size ? finer : size;
}

// The rectangle of the texture: what the shadows of the triangles' box reach, on a grid that lies still. Where the
// plane ends before, so does the rectangle, with a whole texel. False: nothing can be seen.
bool fit(const CastState& c, const CastDirection* directions, CastTexture* texture, uint32_t texels) {
  bool seen = true;
  double low[2] = {0, 0}, high[2] = {0, 0}, low_cut[2] = {0, 0}, high_cut[2] = {0, 0};  // of slopes, and of those cut
  const bool ambient = c.target == k_cast_ambient;
  for (uint32_t i = 0; i < c.direction_count && !ambient; ++i) {
    const double x = static_cast<double>(directions[i].slope[0]), z = static_cast<double>(directions[i].slope[1]);
    const double length = square_root(x * x + z * z), cut = length > k_cast_slope_most ? k_cast_slope_most / length : 1;
    const double slopes[2] = {x * cut, z * cut};
    for (uint32_t axis = 0; axis < 2; ++axis) {
      low[axis] = slopes[axis] < low[axis] ? slopes[axis] : low[axis];
      high[axis] = slopes[axis] > high[axis] ? slopes[axis] : high[axis];
      if (!(cut < 1)) continue;
      low_cut[axis] = slopes[axis] < low_cut[axis] ? slopes[axis] : low_cut[axis];
      high_cut[axis] = slopes[axis] > high_cut[axis] ? slopes[axis] : high_cut[axis];
    }
  }
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const uint32_t of_box = 2 * axis;
    const double most = ambient ? k_cast_ambient_slope : high[axis],
                 least = ambient ? -k_cast_ambient_slope : low[axis];
    double from = c.low[of_box] - most * c.high[1], to = c.high[of_box] - least * c.high[1];
    bool fades[2] = {ambient, ambient};
    if (!ambient && c.in_shade && c.share > 0) {  // what the ambient texture cannot hold is in this one
      const double around = k_cast_ambient_slope * c.high[1],
                   wide[2] = {c.low[of_box] - around, c.high[of_box] + around};
      fades[0] = wide[0] < from;
      fades[1] = wide[1] > to;
      from = fades[0] ? wide[0] : from;
      to = fades[1] ? wide[1] : to;
    }
    const double bounds[2] = {static_cast<double>(c.gathered_frame.low[axis]),
                              static_cast<double>(c.gathered_frame.high[axis])};
    const bool cut[2] = {from < bounds[0] || from > bounds[1], to > bounds[1] || to < bounds[0]};
    double* const ends[2] = {&from, &to};
    for (double* end : ends) *end = *end < bounds[0] ? bounds[0] : *end > bounds[1] ? bounds[1] : *end;
    seen = seen && to > from;
    const double least_side = 1e-4;
    const double side = to - from > least_side ? to - from : least_side;
    const double texel = cut[0] && cut[1] ? side / texels : texel_size(side / (texels - 2));
    texture->texel[axis] = texel;
    texture->low[axis] = cut[0]   ? from
                         : cut[1] ? to - texel * texels
                                  : static_cast<double>(floor_index(from / texel)) * texel;
    // Nor do the texels beyond what was asked for pass the plane's end.
    const double last = texture->low[axis] + texel * texels;
    if (texture->low[axis] < bounds[0] || last > bounds[1]) {
      texture->low[axis] = texture->low[axis] < bounds[0] ? bounds[0] : texture->low[axis];
      texture->texel[axis] = ((last > bounds[1] ? bounds[1] : last) - texture->low[axis]) / texels;
    }
    // A shadow that goes on ends softly.
    const bool goes_on[2] = {high_cut[axis] > k_cast_slope_fade, low_cut[axis] < -k_cast_slope_fade};
    const float fade = static_cast<float>(k_cast_slope_fade * c.high[1] / texel);
    for (int end = 0; end < 2; ++end)
      texture->fade[axis][end] = cut[end] ? 0.0f : fades[end] ? k_rim : goes_on[end] ? fade : 0.0f;
  }
  return seen;
}

// Written out because the popcount of baseline x86-64 is a library call.
uint64_t bits_of(uint64_t x) {
  x -= x >> 1 & 0x5555555555555555u;
  x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
  x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
  return x * 0x0101010101010101u >> 56;
}

// Adds an image to the counts, and clears it. Returns how many bits were set.
uint64_t count_image(uint64_t* image, uint64_t* counts, uint64_t words) {
  uint64_t bits = 0;
  for (uint64_t i = 0; i < words; ++i) {
    uint64_t carry = image[i];
    bits += bits_of(carry);
    for (uint32_t plane = 0; carry != 0 && plane < k_cast_planes; ++plane) {
      uint64_t* sum = counts + plane * words + i;
      const uint64_t both = *sum & carry;
      *sum ^= carry;
      carry = both;
    }
    image[i] = 0;
  }
  return bits;
}

void end_direction(CastState* c) {
  const uint64_t texels = c->targets[c->target].texels, words = texels * cast_words(c->targets[c->target].texels);
  const uint32_t light = c->direction < c->direction_count ? 0 : 1;
  if (cast_masks(*c)) {
    for (uint64_t i = 0; i < words; ++i) c->image[i] &= ~c->mask[i];
    count_image(c->mask, c->mask_counts[light], words);
  }
  c->covered += count_image(c->image, c->counts[light], words);
  ++c->direction;
  c->group = 0;
  c->cursor = 0;
}

// Directions of the main light or of the cells, in the gathered frame.
uint32_t directions_of(const CastState& c, uint32_t which, uint32_t count, CastDirection* out) {
  if (which == k_cast_ambient) return cast_cell_directions(c.cells, count, out);
  double light[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double* to = c.gathered_frame.axes[axis];
    light[axis] = to[0] * c.light[0] + to[1] * c.light[1] + to[2] * c.light[2];
  }
  return cast_light_directions(light, c.half, count, out);
}

}  // namespace

double cast_share(const CastState& c) {
  constexpr double k_step = 1.0 / 255;  // of a texel: less does not show
  if (!cast_masks(c) || !c.light_known || c.targets[0].texels == 0 || c.targets[1].texels == 0) return 0;
  double share = 1;
  for (const float cell : c.cells) share -= static_cast<double>(cell);
  return share > k_step && share < 1 - k_step ? share : 0;
}

void cast_begin_draw(CastState* c) {
  CastTarget* target = &c->targets[c->target];
  CastTexture* texture = &target->back;
  texture->frame = c->gathered_frame;
  texture->left_out = c->left_out;
  texture->too_far = c->too_far;
  for (uint32_t axis = 0; axis < 3; ++axis) texture->light[axis] = c->light[axis];
  const bool draft = target->draft && c->triangles > k_cast_draft_triangles;
  uint32_t count = k_cast_ambient_directions;
  if (c->target == k_cast_light) {
    count = draft ? k_cast_draft_directions : c->directions_of_light;
    target->draft = false;
  } else {
    memcpy(c->cells_made, c->cells, sizeof c->cells);
  }
  target->asked = draft || c->stale;  // meshes have changed while they were gathered
  c->direction_count = directions_of(*c, c->target, count, c->directions);
  texture->directions = c->direction_count;
  c->share = cast_share(*c);
  c->other_count = 0;
  if (c->share > 0)
    c->other_count = directions_of(*c, 1 - c->target, draft ? k_cast_draft_directions : k_cast_other_directions,
                                   c->directions + c->direction_count);
  if (c->low[0] > c->high[0]) {  // no triangle darkens the plane
    for (uint32_t axis = 0; axis < 3; ++axis) c->low[axis] = c->high[axis] = 0;
    c->direction_count = 0;
  }
  if (!fit(*c, c->directions, texture, target->texels)) c->direction_count = 0;
  if (c->direction_count == 0) c->other_count = 0;
  const uint64_t bytes = sizeof(uint64_t) * target->texels * cast_words(target->texels);
  memset(c->image, 0, bytes);
  if (cast_masks(*c)) memset(c->mask, 0, bytes);
  for (uint32_t light = 0; light < (c->other_count != 0 ? 2u : 1u); ++light) {
    memset(c->counts[light], 0, k_cast_planes * bytes);
    if (cast_masks(*c)) memset(c->mask_counts[light], 0, k_cast_planes * bytes);
  }
  c->covered = c->drawn = c->rows = 0;
  c->direction = c->group = c->cursor = 0;
  c->phase = CastPhase::draw;
}

bool cast_draw(CastState* c) {
  const CastTarget& target = c->targets[c->target];
  const CastTexture& texture = target.back;
  CastTrianglesArgs args = {};
  for (uint32_t i = 0; i < 9; ++i) args.corners[i] = c->corners[i];
  args.texels = target.texels;
  args.words = cast_words(target.texels);
  uint32_t spent = 0;
  const uint32_t directions = c->direction_count + c->other_count;
  while (c->direction < directions) {
    const CastDirection& d = c->directions[c->direction];
    for (uint32_t axis = 0; axis < 2; ++axis) {
      const double scale = 1 / texture.texel[axis];
      args.scale[axis] = static_cast<float>(scale);
      args.shear[axis] = static_cast<float>(static_cast<double>(d.slope[axis]) * scale);
      args.offset[axis] = static_cast<float>(static_cast<double>(d.shift[axis]) - 0.5 - texture.low[axis] * scale);
    }
    for (; c->group < k_cast_groups; ++c->group) {
      const uint32_t end = c->starts[c->group + 1];
      c->cursor = c->cursor < c->starts[c->group] ? c->starts[c->group] : c->cursor;
      const bool masks = c->group < k_cast_virtual_closed && cast_masks(*c);
      args.image = masks ? c->mask : c->image;
      args.closed = c->group == k_cast_real_closed || c->group == k_cast_virtual_closed ? 1 : 0;
      while (c->cursor < end) {
        if (spent >= k_cast_unit_rows) {
          c->rows += spent;
          return false;
        }
        const uint32_t to = c->cursor + k_cast_step < end ? c->cursor + k_cast_step : end;
        CastExtent extent = {0, 0, ~0u, 0};
        c->kernels->cast_triangles(&args, c->cursor, to, &extent);
        spent += extent.rows + (to - c->cursor);
        if (!masks) c->drawn += extent.texels;
        c->cursor = to;
      }
    }
    end_direction(c);
    spent += target.texels * args.words / 8;
    if (spent >= k_cast_unit_rows) break;
  }
  c->rows += spent;
  if (c->direction < directions) return false;
  c->targets[c->target].rows = c->rows;
  // Of what the meshes' own surface throws onto the plane, the share that is not thrown twice is seen by the light.
  c->targets[c->target].back.open =
      c->drawn != 0 && !cast_masks(*c) ? static_cast<float>(c->covered) / static_cast<float>(c->drawn) : 1.0f;
  return true;
}

}  // namespace sandglass
