// One texture: its directions and its rectangle, the images of all directions, and their count.
//
// All layers share the rectangle, because a receiver slides along the light to the plane before it reads one. So a
// direction's images of two layers are the same, some texels apart, but for what lies between: it is drawn from the
// highest layer down, each part once, and the image moves from layer to layer by whole texels.
//
// Counts are kept as bit planes: word i of plane b holds bit b of the counts of 64 texels. Adding an image is then a
// chain of half adders, 64 texels at a time.
#include <cstring>

#include "runtime/math/math.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr float k_rim = 4;  // texels at the rim of an ambient texture over which it fades: none is drawn beyond

// The smallest number of the form 2^(k / 8) that is not below x, so that a texel keeps its size while a shadow changes
// a little.
double texel_size(double x) {
  constexpr double k_eighth = 1.0905077326652577;
  double size = 1;
  while (size < x) size *= 2;
  while (0.5 * size >= x) size *= 0.5;
  double finer = 0.5 * size;
  while (finer < x) finer *= k_eighth;
  return finer < size ? finer : size;
}

// The smallest and the largest slope of directions along an axis, no steeper than is drawn; and of those that are cut
// for it. And their sum.
struct Slopes {
  double low = 0, high = 0, low_cut = 0, high_cut = 0, sum = 0;
  void include(double slope, bool cut) {
    sum += slope;
    low = slope < low ? slope : low;
    high = slope > high ? slope : high;
    if (!cut) return;
    low_cut = slope < low_cut ? slope : low_cut;
    high_cut = slope > high_cut ? slope : high_cut;
  }
};

// Along one axis, the rectangle of the texture: what the shadows of the triangles' box reach, on a grid that lies
// still. Where the plane ends before, so does the rectangle, with a whole texel; with layers, where what stands there
// slides to, and what moves there between layers. `around`: metres about the box that are in it, too, and fade. False:
// nothing can be seen.
bool fit_along(const CastGathered& g, uint32_t axis, const Slopes& slopes, bool ambient, double around,
               CastTexture* texture, uint32_t texels) {
  const double low = g.low[2 * axis], high = g.high[2 * axis];
  const double steepest = ambient ? k_cast_ambient_slope : slopes.high,
               lowest = ambient ? -k_cast_ambient_slope : slopes.low;
  double from = low - steepest * g.high[1], to = high - lowest * g.high[1];
  bool fades[2] = {ambient, ambient};
  if (around > 0) {
    const double wide[2] = {low - around, high + around};
    fades[0] = wide[0] < from;
    fades[1] = wide[1] > to;
    from = fades[0] ? wide[0] : from;
    to = fades[1] ? wide[1] : to;
  }
  const double highest = static_cast<double>(cast_level(g.frame, g.layers, g.layers - 1)), slide = texture->slide[axis];
  const double bounds[2] = {static_cast<double>(g.frame.low[axis]) - highest * (slide - slopes.low),
                            static_cast<double>(g.frame.high[axis]) + highest * (slopes.high - slide)};
  const bool cut[2] = {from < bounds[0] || from > bounds[1], to > bounds[1] || to < bounds[0]};
  double* const ends[2] = {&from, &to};
  for (double* end : ends) *end = *end < bounds[0] ? bounds[0] : *end > bounds[1] ? bounds[1] : *end;
  const double side_min = 1e-4;
  const double side = to - from > side_min ? to - from : side_min;
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
  const bool goes_on[2] = {slopes.high_cut > k_cast_slope_fade, slopes.low_cut < -k_cast_slope_fade};
  const float fade = static_cast<float>(k_cast_slope_fade * g.high[1] / texel);
  for (int end = 0; end < 2; ++end)
    texture->fade[axis][end] = cut[end] ? 0.0f : fades[end] ? k_rim : goes_on[end] ? fade : 0.0f;
  return to > from;
}

// The rectangle. False: nothing can be seen.
bool fit(const CastDrawing& drawing, const CastState& c, CastTexture* texture, uint32_t texels) {
  const bool ambient = c.progress.target == k_cast_ambient;
  Slopes slopes[2];
  for (uint32_t i = 0; i < drawing.direction_count && !ambient; ++i) {
    const float* slope = drawing.directions[i].slope;
    const double x = static_cast<double>(slope[0]), z = static_cast<double>(slope[1]);
    const double length = square_root(x * x + z * z), part = length > k_cast_slope_max ? k_cast_slope_max / length : 1;
    slopes[0].include(x * part, part < 1);
    slopes[1].include(z * part, part < 1);
  }
  for (uint32_t axis = 0; axis < 2; ++axis)
    texture->slide[axis] = drawing.direction_count != 0 ? slopes[axis].sum / drawing.direction_count : 0;
  // What the ambient texture cannot hold is in that of the light.
  const bool holds_shade = !ambient && c.progress.in_shade && drawing.share > 0;
  const double around = holds_shade ? k_cast_ambient_slope * c.gathered.high[1] : 0;
  bool seen = true;
  for (uint32_t axis = 0; axis < 2; ++axis)
    seen = fit_along(c.gathered, axis, slopes[axis], ambient, around, texture, texels) && seen;
  return seen;
}

// Written out because the popcount of baseline x86-64 is a library call.
uint64_t bits_of(uint64_t x) {
  x -= x >> 1 & 0x5555555555555555u;
  x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
  x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
  return x * 0x0101010101010101u >> 56;
}

// Adds an image to the counts, and clears it unless it is kept. Returns how many bits were set.
uint64_t count_image(uint64_t* image, uint64_t* counts, uint64_t words, bool kept) {
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
    if (!kept) image[i] = 0;
  }
  return bits;
}

// Moves an image by whole texels. What leaves it is gone.
void move_image(uint64_t* image, uint32_t texels, const int64_t by[2]) {
  constexpr uint32_t k_most = 4;  // words of a row
  const uint32_t words = cast_words(texels);
  const int64_t side = texels, whole = by[0] >> 6;  // rounds down
  const auto part = static_cast<uint32_t>(by[0] & 63);
  for (int64_t i = 0; i < side; ++i) {
    const int64_t row = by[1] > 0 ? side - 1 - i : i, source = row - by[1];
    uint64_t from[k_most] = {};
    if (source >= 0 && source < side) memcpy(from, image + source * words, words * sizeof from[0]);
    for (int64_t word = 0; word < words; ++word) {
      const auto at = [&](int64_t k) { return k >= 0 && k < words ? from[k] : 0; };
      const uint64_t moved = at(word - whole) << part;
      image[row * words + word] = part == 0 ? moved : moved | at(word - whole - 1) >> (64 - part);
    }
  }
}

// Texels from a layer's image to the floor's: whole ones, by which its grid is shifted by half a texel at most, too.
int64_t aside(const CastDirection& d, const CastTexture& texture, uint32_t axis, double level) {
  if (!(level > 0)) return 0;
  const double texels = level * (static_cast<double>(d.slope[axis]) - texture.slide[axis]) / texture.texel[axis];
  return floor_index(texels - static_cast<double>(d.shift[axis]) + 0.5);
}

// Whether all of a direction's images can be moved: all that reaches the plane of the app begins in the rectangle.
bool moves(const CastDirection& d, const CastTexture& texture, const CastGathered& g, uint32_t texels) {
  const double highest = static_cast<double>(cast_level(g.frame, g.layers, g.layers - 1));
  bool holds = true;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const double slide = texture.slide[axis], past = slide - static_cast<double>(d.slope[axis]);
    const double still = k_cast_still * texture.texel[axis];
    const double first = texture.low[axis] - still, last = texture.low[axis] + texture.texel[axis] * texels + still;
    const double from = g.low[2 * axis] - (slide > 0 ? slide * g.high[1] : 0),
                 to = g.high[2 * axis] - (slide < 0 ? slide * g.high[1] : 0);
    const double back = slide > past ? slide : past, ahead = slide < past ? slide : past;
    const double low = static_cast<double>(g.frame.low[axis]) - (back > 0 ? back * highest : 0),
                 high = static_cast<double>(g.frame.high[axis]) - (ahead < 0 ? ahead * highest : 0);
    holds = holds && (from >= first || low >= first) && (to <= last || high <= last);
  }
  return holds;
}

// Counts what is drawn of a layer. Its images move to the next one, or are cleared.
void end_layer(CastDrawing* drawing, const CastTexture& texture, const CastGathered& gathered, uint32_t texels,
               bool moves_on) {
  const uint64_t words = uint64_t{texels} * cast_words(texels), at = drawing->layer * k_cast_planes * words;
  const uint32_t light = drawing->direction < drawing->direction_count ? 0 : 1;
  const bool masks = cast_masks(gathered);
  if (masks) {
    for (uint64_t i = 0; i < words; ++i) drawing->image[i] &= ~drawing->mask[i];
    count_image(drawing->mask, drawing->mask_counts[light] + at, words, moves_on);
  }
  const uint64_t bits = count_image(drawing->image, drawing->counts[light] + at, words, moves_on);
  drawing->group = 0;
  drawing->triangle = 0;
  if (drawing->layer == 0) {
    drawing->covered += bits;
    ++drawing->direction;
    drawing->layer = gathered.layers - 1;
    return;
  }
  --drawing->layer;
  if (!moves_on) return;
  const CastDirection& d = drawing->directions[drawing->direction];
  int64_t by[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const auto level = [&](uint32_t k) { return static_cast<double>(cast_level(gathered.frame, gathered.layers, k)); };
    by[axis] = aside(d, texture, axis, level(drawing->layer)) - aside(d, texture, axis, level(drawing->layer + 1));
  }
  move_image(drawing->image, texels, by);
  if (masks) move_image(drawing->mask, texels, by);
}

// Directions of the main light or of the cells, in the gathered frame.
uint32_t directions_of(const CastState& c, uint32_t which, uint32_t count, CastDirection* out) {
  if (which == k_cast_ambient) return cast_cell_directions(c.request.cells, count, out);
  double light[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double* to = c.gathered.frame.axes[axis];
    light[axis] = to[0] * c.request.light[0] + to[1] * c.request.light[1] + to[2] * c.request.light[2];
  }
  return cast_light_directions(light, c.request.half, count, out);
}

}  // namespace

double cast_share(const CastState& c) {
  constexpr double k_step = 1.0 / 255;  // of a texel: less does not show
  if (!cast_masks(c.gathered) || !c.request.light_known || c.targets[0].texels == 0 || c.targets[1].texels == 0)
    return 0;
  double share = 1;
  for (const float cell : c.request.cells) share -= static_cast<double>(cell);
  return share > k_step && share < 1 - k_step ? share : 0;
}

void cast_begin_draw(CastDrawing* drawing, CastTarget* target, const CastState& c) {
  const uint32_t which = c.progress.target;
  CastTexture* texture = &target->back;
  texture->frame = c.gathered.frame;
  texture->left_out = c.gathered.left_out;
  texture->too_far = c.gathered.too_far;
  for (uint32_t axis = 0; axis < 3; ++axis) texture->light[axis] = c.request.light[axis];
  const bool draft = target->draft && c.comparison.triangles > k_cast_draft_triangles;
  uint32_t count = k_cast_ambient_directions;
  if (which == k_cast_light) {
    count = draft ? k_cast_draft_directions : c.desc.directions;
    target->draft = false;
  } else {
    memcpy(drawing->cells, c.request.cells, sizeof drawing->cells);
  }
  target->asked = draft || c.comparison.stale;  // meshes have changed while they were gathered
  drawing->direction_count = directions_of(c, which, count, drawing->directions);
  texture->directions = drawing->direction_count;
  drawing->share = cast_share(c);
  drawing->other_count = 0;
  if (drawing->share > 0)
    drawing->other_count = directions_of(c, 1 - which, draft ? k_cast_draft_directions : k_cast_other_directions,
                                         drawing->directions + drawing->direction_count);
  if (!c.gathered.darkens) drawing->direction_count = 0;
  if (!fit(*drawing, c, texture, target->texels)) drawing->direction_count = 0;
  if (drawing->direction_count == 0) drawing->other_count = 0;
  const bool masks = cast_masks(c.gathered);
  const uint64_t bytes = sizeof(uint64_t) * target->texels * cast_words(target->texels);
  memset(drawing->image, 0, bytes);
  if (masks) memset(drawing->mask, 0, bytes);
  for (uint32_t light = 0; light < (drawing->other_count != 0 ? 2u : 1u); ++light) {
    memset(drawing->counts[light], 0, c.gathered.layers * k_cast_planes * bytes);
    if (masks) memset(drawing->mask_counts[light], 0, c.gathered.layers * k_cast_planes * bytes);
  }
  drawing->covered = drawing->drawn = drawing->rows = 0;
  drawing->direction = drawing->group = drawing->triangle = 0;
  drawing->layer = c.gathered.layers - 1;
}

bool cast_draw(CastDrawing* drawing, CastTarget* target, const CastState& c) {
  CastTrianglesArgs args = {};
  for (uint32_t i = 0; i < 9; ++i) args.corners[i] = c.gathered.corners[i];
  args.texels = target->texels;
  args.words = cast_words(target->texels);
  uint32_t spent = 0;
  const uint32_t directions = drawing->direction_count + drawing->other_count, layers = c.gathered.layers;
  while (drawing->direction < directions) {
    const CastDirection& d = drawing->directions[drawing->direction];
    const auto level = static_cast<double>(cast_level(c.gathered.frame, layers, drawing->layer));
    const bool once = layers > 1 && moves(d, target->back, c.gathered, target->texels);
    for (uint32_t axis = 0; axis < 2; ++axis) {
      const double scale = 1 / target->back.texel[axis];
      args.scale[axis] = static_cast<float>(scale);
      args.shear[axis] = static_cast<float>(static_cast<double>(d.slope[axis]) * scale);
      args.offset[axis] = static_cast<float>(static_cast<double>(d.shift[axis]) - 0.5 - target->back.low[axis] * scale +
                                             static_cast<double>(aside(d, target->back, axis, level)));
    }
    for (; drawing->group < k_cast_groups; ++drawing->group) {
      const uint32_t* starts = c.gathered.starts + drawing->group * layers;
      const uint32_t begin = starts[drawing->layer], end = starts[once ? drawing->layer + 1 : layers];
      drawing->triangle = drawing->triangle < begin ? begin : drawing->triangle;
      const bool masks = drawing->group < k_cast_virtual_closed && cast_masks(c.gathered);
      args.image = masks ? drawing->mask : drawing->image;
      args.closed = drawing->group == k_cast_real_closed || drawing->group == k_cast_virtual_closed ? 1 : 0;
      while (drawing->triangle < end) {
        if (spent >= k_cast_unit_rows) {
          drawing->rows += spent;
          return false;
        }
        const uint32_t to = drawing->triangle + k_cast_step < end ? drawing->triangle + k_cast_step : end;
        CastExtent extent = {0, 0, ~0u, 0};
        c.kernels->cast_triangles(&args, drawing->triangle, to, &extent);
        spent += extent.rows + (to - drawing->triangle);
        if (!masks && (once || drawing->layer == 0)) drawing->drawn += extent.texels;
        drawing->triangle = to;
      }
    }
    const bool moves_on = once && drawing->layer != 0;
    end_layer(drawing, target->back, c.gathered, target->texels, moves_on);
    spent += target->texels * args.words / 8 + (moves_on ? target->texels : 0);
    if (spent >= k_cast_unit_rows) break;
  }
  drawing->rows += spent;
  if (drawing->direction < directions) return false;
  target->rows = drawing->rows;
  // The share of the meshes' own surface that the light sees: covered texels, over the texels that all triangles draw.
  const bool shares = drawing->drawn != 0 && !cast_masks(c.gathered);
  target->back.open = shares ? static_cast<float>(drawing->covered) / static_cast<float>(drawing->drawn) : 1.0f;
  return true;
}

}  // namespace sandglass
