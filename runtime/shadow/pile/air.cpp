// The shadow of sand that flies beside a skin. It is no column: what lies between it and the floor is air, and a stream
// is as thin as it is.
//
// Each particle in the air is followed along the light to where it meets the sand under the skin, or the floor. There
// it leaves the shadow of its outline, k_loose_outline * pi * radius^2 / sine of the light's elevation in all, spread
// over the ellipse that the light's own width makes of it, and never finer than texels. What several hide is taken as
// independent.
#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/shadow/pile/pile.h"

namespace sandglass {
namespace {

constexpr float k_rolls = 3;    // radii over the sand: what is lower rolls on it, and is lit together with it
constexpr float k_widest = 16;  // texels: half the width of a shadow; wider ones are darker than they should be

struct Landing {
  float x, z;  // in texels
  float fall;  // metres of height from the particle down to it
};

// False: it lies on the sand, or its shadow leaves the texture.
bool follow(const Pile& p, const float* position, Landing* landing, uint32_t* steps) {
  const float n = static_cast<float>(p.rectangle.texels),
              light[3] = {static_cast<float>(p.lighting.made_for[0]), static_cast<float>(p.lighting.made_for[1]),
                          static_cast<float>(p.lighting.made_for[2])};
  const float height = position[1] - p.rectangle.height;
  if (!(height > 0 && height < k_pile_highest)) return false;
  const float from[2] = {(position[0] - p.rectangle.low[0]) / p.rectangle.texel[0],
                         (position[2] - p.rectangle.low[1]) / p.rectangle.texel[1]};
  const float slope[2] = {-light[0] / (light[1] * p.rectangle.texel[0]), -light[2] / (light[1] * p.rectangle.texel[1])};
  const auto top_at = [&](float x, float z) {
    if (!(x >= 0 && z >= 0 && x < n && z < n)) return 0.0f;
    const float sand = p.columns.tops[to_whole<int64_t>(z) * p.columns.pitch + to_whole<int64_t>(x)];
    const float ground = ground_at(p.ground, x, z);
    return sand > ground ? sand : ground;
  };
  if (height - k_rolls * p.request.source.radius < top_at(from[0], from[1])) return false;
  // Only what is lower than the highest sand or ground can meet any.
  const float highest = p.columns.top > p.ground.highest ? p.columns.top : p.ground.highest;
  const float flat = __builtin_sqrtf(slope[0] * slope[0] + slope[1] * slope[1]);
  const float all = flat * height, step = flat > 0 ? 1 / flat : height;  // in texels; metres of height for a texel
  float fall = height > highest ? height - highest : 0;
  for (uint32_t i = 0; i < 2 * p.rectangle.texels && fall < height && all > 0; ++i, fall += step, ++*steps) {
    const float top = top_at(from[0] + slope[0] * fall, from[1] + slope[1] * fall);
    if (height - fall < top) break;
  }
  if (!(fall < height)) {
    const float top = top_at(from[0] + slope[0] * height, from[1] + slope[1] * height);
    fall = top > 0 ? height - top : height;
  }
  *landing = {from[0] + slope[0] * fall, from[1] + slope[1] * fall, fall};
  return true;
}

}  // namespace

void air_begin(PileAir* air, uint32_t texels) {
  if (air->any)
    for (uint32_t i = 0; i < texels * texels; ++i) air->shares[i] = 1;
  air->any = false;
}

bool pile_put_flying(PileAir* air, const Pile& p, const sandglass_skin_loose& loose, uint32_t* visits) {
  Landing landing;
  uint32_t steps = 0;
  if ((p.progress.making & k_ask_light) == 0 || !follow(p, loose.position, &landing, &steps)) return true;
  const float lx = static_cast<float>(p.lighting.made_for[0]), ly = static_cast<float>(p.lighting.made_for[1]);
  const float lz = static_cast<float>(p.lighting.made_for[2]), radius = p.request.source.radius;
  const float flat = __builtin_sqrtf(lx * lx + lz * lz);
  const float cosine = flat > 0 ? lx / flat : 1, sine = flat > 0 ? lz / flat : 0;
  const float texel = p.rectangle.texel[0] > p.rectangle.texel[1] ? p.rectangle.texel[0] : p.rectangle.texel[1];
  const float smaller = p.rectangle.texel[0] < p.rectangle.texel[1] ? p.rectangle.texel[0] : p.rectangle.texel[1];
  // The ellipse's half axes, across the light and along it.
  float across = radius + landing.fall / ly * static_cast<float>(p.lighting.half_sine / p.lighting.half_cosine);
  across = across > texel ? across : texel;
  across = across < k_widest * ly * smaller ? across : k_widest * ly * smaller;
  const float along = across / ly;
  const float half[2] = {
      __builtin_sqrtf(along * along * cosine * cosine + across * across * sine * sine) / p.rectangle.texel[0],
      __builtin_sqrtf(along * along * sine * sine + across * across * cosine * cosine) / p.rectangle.texel[1]};
  const float middle[2] = {landing.x, landing.z}, n = static_cast<float>(p.rectangle.texels);
  int32_t first[2], last[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const float low = middle[axis] - half[axis] - 0.5f, high = middle[axis] + half[axis] - 0.5f;
    // All of it counts for the sum: shadows at the edge are cut off there.
    if (!(low < n && high >= 0)) return true;
    first[axis] = static_cast<int32_t>(ceiling_index(static_cast<double>(low)));
    last[axis] = static_cast<int32_t>(floor_index(static_cast<double>(high)));
  }
  if (last[0] < first[0] || last[1] < first[1]) return true;
  const uint32_t texels = static_cast<uint32_t>((last[0] - first[0] + 1) * (last[1] - first[1] + 1));
  if (*visits < steps + 2 * texels) return false;
  *visits -= steps + 2 * texels;
  const auto share_at = [&](int32_t column, int32_t row) {
    const float x = (static_cast<float>(column) + 0.5f - middle[0]) * p.rectangle.texel[0];
    const float z = (static_cast<float>(row) + 0.5f - middle[1]) * p.rectangle.texel[1];
    const float a = (x * cosine + z * sine) / along, b = (z * cosine - x * sine) / across;
    const float share = 1 - a * a - b * b;
    return share > 0 ? share : 0.0f;
  };
  float sum = 0;
  for (int32_t row = first[1]; row <= last[1]; ++row)
    for (int32_t column = first[0]; column <= last[0]; ++column) sum += share_at(column, row);
  if (!(sum > 0)) return true;
  const float outline =
      k_loose_outline * 3.14159265f * (radius / p.rectangle.texel[0]) * (radius / p.rectangle.texel[1]) / ly;
  const float scale = loose.weight * outline / sum;
  const int32_t end = static_cast<int32_t>(p.rectangle.texels);
  for (int32_t row = first[1] > 0 ? first[1] : 0; row <= last[1] && row < end; ++row)
    for (int32_t column = first[0] > 0 ? first[0] : 0; column <= last[0] && column < end; ++column) {
      const float hidden = scale * share_at(column, row);
      air->shares[static_cast<int64_t>(row) * end + column] *= 1 - (hidden < 1 ? hidden : 1);
    }
  air->any = true;
  return true;
}

}  // namespace sandglass
