// A texture at other sizes, and the textures of all lights as one. Texels are mixed in integers. The place of a
// texel and the weight of a light are computed in double.
#include <cstring>

#include "kernels/whole.h"
#include "platform/floating_point.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/math.h"
#include "runtime/shadow/baked/shadow.h"

namespace sandglass {
namespace {

constexpr uint32_t n = k_shadow_size;
constexpr uint32_t k_combined_max = 1024;  // texels a side

// Where a coordinate lies between texel centres: the index of the lower one, -1..n-1, and 256ths of the distance to the
// next. Index -2: outside the texture.
struct Between {
  int32_t index;
  uint32_t part;
};
Between place(double x, double low, double high) {
  const double texel = (x - low) / (high - low) * n - 0.5;
  if (!(texel > -1 && texel < n)) return {-2, 0};
  const int64_t steps = floor_index(texel * 256 + 0.5);
  return {static_cast<int32_t>(steps >> 8), static_cast<uint32_t>(steps & 255)};
}

// Bilinear; 0 outside the texture, 255 * 65536 at full coverage.
uint32_t sample(const uint8_t* texture, Between u, Between v) {
  if (u.index < -1 || v.index < -1) return 0;
  const auto at = [&](int32_t x, int32_t y) -> uint32_t {
    const bool inside = x >= 0 && y >= 0 && x < static_cast<int32_t>(n) && y < static_cast<int32_t>(n);
    return inside ? texture[static_cast<uint32_t>(y) * n + static_cast<uint32_t>(x)] : 0u;
  };
  const uint32_t top = at(u.index, v.index) * (256 - u.part) + at(u.index + 1, v.index) * u.part;
  const uint32_t bottom = at(u.index, v.index + 1) * (256 - u.part) + at(u.index + 1, v.index + 1) * u.part;
  return top * (256 - v.part) + bottom * v.part;
}

bool shines(const ShadowLight& light) { return light.opacity > 0 && light.irradiance > 0; }
bool shades(const ShadowLight& light) { return shines(light) && light.front.valid; }

__attribute__((noinline)) void combine(const Shadow& s, uint32_t size, uint8_t* out, float low[2], float high[2]) {
  ShadowRectangle all = {-s.box.half_x, -s.box.half_z, s.box.half_x, s.box.half_z};
  double irradiance = 0;
  for (uint32_t i = 0; i < s.light_count; ++i) {
    if (!shines(s.lights[i])) continue;
    irradiance += static_cast<double>(s.lights[i].irradiance);
    if (!shades(s.lights[i])) continue;
    const ShadowRectangle& r = s.lights[i].front.rectangle;
    all.low_x = r.low_x < all.low_x ? r.low_x : all.low_x;
    all.low_z = r.low_z < all.low_z ? r.low_z : all.low_z;
    all.high_x = r.high_x > all.high_x ? r.high_x : all.high_x;
    all.high_z = r.high_z > all.high_z ? r.high_z : all.high_z;
  }
  double weight[SANDGLASS_SHADOW_LIGHTS];
  for (uint32_t i = 0; i < s.light_count; ++i) {
    const ShadowLight& l = s.lights[i];
    weight[i] = shades(l) ? static_cast<double>(l.irradiance) * static_cast<double>(l.opacity) / irradiance / 65536 : 0;
  }
  for (uint32_t v = 0; v < size; ++v) {
    const double z = all.low_z + (all.high_z - all.low_z) * (v + 0.5) / size;
    for (uint32_t u = 0; u < size; ++u) {
      const double x = all.low_x + (all.high_x - all.low_x) * (u + 0.5) / size;
      double sum = 0.5;
      for (uint32_t i = 0; i < s.light_count; ++i) {
        if (!(weight[i] > 0)) continue;
        const ShadowTexture& t = s.lights[i].front;
        const Between bu = place(x, t.rectangle.low_x, t.rectangle.high_x);
        const Between bv = place(z, t.rectangle.low_z, t.rectangle.high_z);
        sum += weight[i] * sample(t.coverage, bu, bv);
      }
      out[v * size + u] = to_whole<uint8_t>(sum < 255 ? sum : 255);
    }
  }
  low[0] = static_cast<float>(all.low_x + s.origin[0]);
  low[1] = static_cast<float>(all.low_z + s.origin[2]);
  high[0] = static_cast<float>(all.high_x + s.origin[0]);
  high[1] = static_cast<float>(all.high_z + s.origin[2]);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_shadow_resample(const sandglass_shadow* shadow, uint32_t light, uint8_t* out, uint32_t size,
                                           const char** reason) {
  if (shadow == nullptr || out == nullptr)
    return refuse(reason, "shadow or coverage is NULL: pass the shadow and room for size * size bytes.");
  if (size != 128 && size != 256 && size != 512) return refuse(reason, "size is not 128, 256 or 512.");
  if (light >= shadow->shadow.light_count)
    return refuse(reason, "light is not below the light_count of the description: count from 0.");
  const uint8_t* in = shadow->shadow.lights[light].front.coverage;
  if (size == n) memcpy(out, in, n * n);
  if (size == 128)
    for (uint32_t v = 0; v < 128; ++v)
      for (uint32_t u = 0; u < 128; ++u) {
        const uint8_t* p = in + 2 * (v * n + u);
        out[v * 128 + u] = static_cast<uint8_t>((p[0] + p[1] + p[n] + p[n + 1] + 2) / 4);
      }
  if (size == 512)  // texel centres lie at quarters between the old ones
    for (uint32_t v = 0; v < 512; ++v) {
      const uint32_t v0 = v / 2, v1 = v % 2 == 0 ? (v0 == 0 ? 0 : v0 - 1) : (v0 == n - 1 ? v0 : v0 + 1);
      for (uint32_t u = 0; u < 512; ++u) {
        const uint32_t u0 = u / 2, u1 = u % 2 == 0 ? (u0 == 0 ? 0 : u0 - 1) : (u0 == n - 1 ? u0 : u0 + 1);
        out[v * 512 + u] = static_cast<uint8_t>(
            (9 * in[v0 * n + u0] + 3 * (in[v0 * n + u1] + in[v1 * n + u0]) + in[v1 * n + u1] + 8) / 16);
      }
    }
  return accept(reason);
}

sandglass_status sandglass_shadow_combine(const sandglass_shadow* shadow, uint8_t* coverage, uint32_t size,
                                          float low[2], float high[2], const char** reason) {
  if (shadow == nullptr || coverage == nullptr || low == nullptr || high == nullptr)
    return refuse(
        reason,
        "shadow, coverage, low or high is NULL: pass the shadow, room for size * size bytes and for two floats each.");
  if (size == 0 || size > k_combined_max) return refuse(reason, "size is not in 1..1024.");
  const ExactFloatingPoint exact;
  combine(shadow->shadow, size, coverage, low, high);
  return accept(reason);
}
