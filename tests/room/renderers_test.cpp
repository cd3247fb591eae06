// Estimates, the light of rooms and what systems tell in the terms of renderers, against integrals of the light in double
// and the formulas that the renderers publish. Nothing is lost, nothing counted twice.
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "runtime/light/network/radiometry.h"
#include "sandglass/renderers.h"
#include "tests/reason.h"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

using tests::expect_refused;
using Colour = std::array<double, 3>;
using Nine = std::array<double, 9>;

constexpr double k_pi_double = std::numbers::pi;
constexpr sandglass_light_model k_ambient = SANDGLASS_LIGHT_AMBIENT, k_whole = SANDGLASS_LIGHT_WHOLE;
constexpr float k_nits = 40.0f;

template <class Struct>
Struct sized() {
  Struct s = {};
  s.struct_size = sizeof s;
  return s;
}
double luminance_of(const Colour& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

Nine polynomials(Direction n) {
  return {1, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3 * n.z * n.z - 1, n.x * n.z, n.x * n.x - n.y * n.y};
}
// Y_i / polynomial_i: sqrt(1/4 pi), sqrt(3/4 pi), sqrt(15/4 pi) and the two of them with other factors.
Nine normalisation() {
  const auto root = [](double x) { return std::sqrt(x / (4 * k_pi_double)); };
  return {root(1), root(3), root(3), root(3), root(15), root(15), root(1.25), root(15), root(3.75)};
}
// What the shaders of Filament, Unity and ARCore's samples compute of their nine coefficients.
double sum_of(const float* sh, size_t stride, Direction n) {
  const Nine p = polynomials(n);
  double sum = 0;
  for (size_t i = 0; i < 9; ++i) sum += static_cast<double>(sh[stride * i]) * p[i];
  return sum;
}

// ------------------------------------------------------------------------------------------------------- sources

// An even sky and one light; what is known of them in double.
struct Source {
  std::string name;
  sandglass_light lighting;
  Direction towards;
  Colour sky;     // radiance from everywhere
  Colour facing;  // irradiance of a surface that faces the light
  std::vector<Direction> normals;
  std::vector<Colour> shown;  // by a white surface of each normal, in harmonics
  double tolerance;           // of `shown`, in lights
  std::array<double, 27> sh;
};

std::vector<Direction> normals_with(Direction towards) {
  return {towards, {0, 1, 0}, {0.6, 0.8, 0}, {0, 0, 1}, {-0.48, 0.6, -0.64}, {0, -1, 0}};
}

constexpr Colour k_sky = {0.2, 0.25, 0.35};

sandglass_estimator_light estimate_of(Direction d) {
  auto e = sized<sandglass_estimator_light>();
  e.valid = 1;
  const double v[3] = {d.x, d.y, d.z}, light[3] = {0.9, 0.7, 0.4};
  for (size_t i = 0; i < 3; ++i) {
    e.direction[i] = static_cast<float>(v[i]);
    e.light[i] = static_cast<float>(light[i]);
    e.ambient[i] = static_cast<float>(k_sky[i]);
  }
  e.strength = 2.5f;
  double sh[27];
  estimate_harmonics(e, sh);
  for (size_t i = 0; i < 27; ++i) e.sh[i] = static_cast<float>(sh[i]);
  return e;
}

double gaussian(double cosine) { return std::exp(2 * k_pi_double * (cosine - 1)); }

// The light of an estimate is a lobe as the header describes it in words. The integrals over the sphere are sums over
// rings of equal height.
Source estimated(Direction d) {
  const sandglass_estimator_light e = estimate_of(d);
  Source s = {"estimate", sized<sandglass_light>(), d, k_sky, {}, normals_with(d), {}, 0.03, {}};
  EXPECT_EQ(sandglass_light_of_estimator(&e, &s.lighting, nullptr), SANDGLASS_OK);
  for (size_t c = 0; c < 3; ++c)
    s.facing[c] = k_pi_double * static_cast<double>(e.strength) * static_cast<double>(e.light[c]);
  double facing_gaussian = 0;
  constexpr int k_steps = 200000, k_rings = 400, k_around = 800;
  for (int i = 0; i < k_steps; ++i) {
    const double t = (i + 0.5) / k_steps;
    facing_gaussian += 2 * k_pi_double * t * gaussian(t) / k_steps;
  }
  s.shown.resize(s.normals.size());
  const double omega = 4 * k_pi_double / (k_rings * k_around);
  const Nine norm = normalisation();
  for (int i = 0; i < k_rings; ++i) {
    const double y = -1.0 + (2 * i + 1.0) / k_rings, level = std::sqrt(1.0 - y * y);
    for (int j = 0; j < k_around; ++j) {
      const double phi = 2 * k_pi_double * (j + 0.5) / k_around;
      const Direction v = {level * std::cos(phi), y, level * std::sin(phi)};
      const Nine p = polynomials(v);
      const double lobe = gaussian(cosine(d, v)) / facing_gaussian;
      for (size_t c = 0; c < 3; ++c) {
        const double radiance = s.sky[c] + s.facing[c] * lobe;
        for (size_t k = 0; k < 9; ++k) s.sh[3 * k + c] += radiance * omega * norm[k] * p[k];
        for (size_t k = 0; k < s.normals.size(); ++k)
          s.shown[k][c] += radiance * omega / k_pi_double * std::max(0.0, cosine(v, s.normals[k]));
      }
    }
  }
  return s;
}

constexpr Colour k_lamp = {2.7, 2.1, 1.2};  // irradiance of a surface that faces it

sandglass_room_light lit_room(Direction lamp) {
  auto light = sized<sandglass_room_light>();
  light.valid = 1;
  const double axis[3] = {lamp.x, lamp.y, lamp.z};
  const Nine p = polynomials(lamp), norm = normalisation();
  Colour irradiance;
  for (size_t c = 0; c < 3; ++c) irradiance[c] = k_pi_double * k_sky[c] + k_lamp[c] * lamp.y;
  light.main_share = static_cast<float>(luminance_of(k_lamp) * lamp.y / luminance_of(irradiance));
  for (size_t c = 0; c < 3; ++c) {
    light.main_direction[c] = static_cast<float>(axis[c]);
    light.main_colour[c] = static_cast<float>(k_lamp[c] / luminance_of(k_lamp));
    light.irradiance[c] = static_cast<float>(irradiance[c]);
    for (size_t i = 0; i < 9; ++i)
      light.sh[3 * i + c] =
          static_cast<float>(k_lamp[c] * norm[i] * p[i] + (i == 0 ? k_sky[c] * 2 * std::sqrt(k_pi_double) : 0.0));
  }
  return light;
}

sandglass_light lighting_of(const sandglass_room_light& light) {
  auto lighting = sized<sandglass_light>();
  EXPECT_EQ(sandglass_light_of_room(&light, &lighting, nullptr), SANDGLASS_OK);
  return lighting;
}

// The light of this room is a small lamp. Nine coefficients of one show E / pi (1/4 + cos / 2 + 5/32 (3 cos^2 - 1)), by
// the addition theorem.
Source seen(Direction lamp) {
  const sandglass_room_light light = lit_room(lamp);
  Source s = {"room", lighting_of(light), lamp, k_sky, k_lamp, normals_with(lamp), {}, 0, {}};
  for (const Direction& n : s.normals) {
    const double t = cosine(n, lamp), share = (0.25 + t / 2 + 5.0 / 32 * (3 * t * t - 1)) / k_pi_double;
    s.shown.push_back({k_sky[0] + k_lamp[0] * share, k_sky[1] + k_lamp[1] * share, k_sky[2] + k_lamp[2] * share});
  }
  for (size_t i = 0; i < 27; ++i) s.sh[i] = static_cast<double>(light.sh[i]);
  return s;
}

const std::vector<Source>& sources() {
  static const std::vector<Source> all = {estimated(towards(-59, 54)), estimated({0, 1, 0}), estimated(towards(156, 6)),
                                          estimated(towards(72, -48)), seen(towards(130, 50))};
  return all;
}

TEST(Lighting, IsTheLightOfItsSource) {
  for (const Source& s : sources()) {
    SCOPED_TRACE(s.name);
    const sandglass_light& l = s.lighting;
    EXPECT_NEAR(cosine({l.towards[0], l.towards[1], l.towards[2]}, s.towards), 1.0, 1e-6);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(l.facing[c], s.facing[c], 1e-6 * s.facing[c]);
      EXPECT_NEAR(l.floor[c], k_pi_double * s.sky[c] + s.facing[c] * std::max(0.0, s.towards.y), 2e-6);
      // A surface that faces it gets the same of lobe and directional light.
      if (s.tolerance > 0) {
        EXPECT_NEAR(s.shown[0][c], s.sky[c] + s.facing[c] / k_pi_double, 1e-3);
      }
    }
    for (size_t i = 0; i < 27; ++i) {
      EXPECT_NEAR(l.ambient_sh[i], i < 3 ? 2 * std::sqrt(k_pi_double) * s.sky[i] : 0.0, 2e-6) << i;
      EXPECT_NEAR(l.whole_sh[i], s.sh[i], 2e-4 * (1 + std::fabs(s.sh[i]))) << i;
    }
  }
}

// The rule that defines strength: the directional light's share of the level floor's irradiance is the contrast.
TEST(Lighting, StrengthMakesTheContrastTheShareOfTheFloor) {
  const auto lum = [](const double* c) { return luminance_of({c[0], c[1], c[2]}); };
  const double light[3] = {0.9, 0.7, 0.4}, ambient[3] = {0.2, 0.25, 0.35};
  for (const double o : {0.0, 0.3, 0.8})
    for (const double up : {0.2, 0.7, 1.0}) {
      const double direction[3] = {std::sqrt(1.0 - up * up), up, 0.0};
      const double s = light_strength(direction, light, ambient, o);
      const double from_light = k_pi_double * s * lum(light) * up, from_rest = k_pi_double * lum(ambient);
      EXPECT_NEAR(from_light / (from_light + from_rest), o, 1e-12);
    }
  const double below[3] = {0.6, -0.8, 0.0}, black[3] = {};
  EXPECT_NEAR(light_strength(below, light, ambient, 1.0), std::min(64.0, lum(ambient) / lum(light) * 19.0 / 0.1), 1e-9);
  EXPECT_EQ(light_strength(below, black, ambient, 0.5), 0.0);
}

// ------------------------------------------------------------------------------------------------------- renderers

template <class Struct, class Convert, class... More>
Struct converted(Convert convert, const sandglass_light& lighting, sandglass_light_model model, More... more) {
  auto out = sized<Struct>();
  const char* reason = nullptr;
  EXPECT_EQ(convert(&lighting, model, more..., &out, &reason), SANDGLASS_OK) << reason;
  return out;
}
sandglass_filament_light filament_of(const sandglass_light& lighting, sandglass_light_model model) {
  return converted<sandglass_filament_light>(sandglass_light_to_filament, lighting, model, k_nits);
}
sandglass_arkit_light arkit_of(const sandglass_light& lighting, sandglass_light_model model) {
  return converted<sandglass_arkit_light>(sandglass_light_to_arkit, lighting, model);
}
sandglass_arcore_light arcore_of(const sandglass_light& lighting, sandglass_light_model model) {
  return converted<sandglass_arcore_light>(sandglass_light_to_arcore, lighting, model);
}
sandglass_unity_light unity_of(const sandglass_light& lighting, sandglass_light_model model) {
  return converted<sandglass_unity_light>(sandglass_light_to_unity, lighting, model);
}

// The vector v turned by a unit quaternion.
Direction turned(const float q[4], Direction v) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const Direction t = {2 * (y * v.z - z * v.y), 2 * (z * v.x - x * v.z), 2 * (x * v.y - y * v.x)};
  return {v.x + w * t.x + y * t.z - z * t.y, v.y + w * t.y + z * t.x - x * t.z, v.z + w * t.z + x * t.y - y * t.x};
}

// Of ARCore's samples and Filament's documentation, for radiance in the basis with the Condon-Shortley phase.
constexpr double k_table[9] = {0.282095,  -0.325735, 0.325735,  -0.325735, 0.273137,
                               -0.273137, 0.078848,  -0.273137, 0.136569};

// What a white surface shows by a renderer's own formula.
struct Shown {
  double by_light, by_harmonics;
};
struct Renderer {
  const char* name;
  Shown (*shown)(const sandglass_light&, sandglass_light_model, Direction normal, size_t colour);
};
const Renderer k_renderers[] = {
    // A directional light of E lux gives a white surface that faces it the luminance E / pi, an IndirectLight of
    // intensity I gives it I x polynomial. Both are nits x the header's radiance.
    {"filament",
     [](const sandglass_light& lighting, sandglass_light_model model, Direction n, size_t c) -> Shown {
       const sandglass_filament_light f = filament_of(lighting, model);
       const double facing = std::max(0.0, -cosine(n, {f.direction[0], f.direction[1], f.direction[2]}));
       return {static_cast<double>(f.intensity * f.colour[c] / k_nits) / k_pi_double * facing,
               static_cast<double>(f.sh_intensity / k_nits) * sum_of(f.sh + c, 3, n)};
     }},
    {"arcore",
     [](const sandglass_light& lighting, sandglass_light_model model, Direction n, size_t c) -> Shown {
       const sandglass_arcore_light a = arcore_of(lighting, model);
       const double facing =
           cosine(n, {a.main_light_direction[0], a.main_light_direction[1], a.main_light_direction[2]});
       const Nine p = polynomials(n);
       double sum = 0;
       for (size_t i = 0; i < 9; ++i) sum += static_cast<double>(a.sh[3 * i + c]) * k_table[i] * p[i];
       return {static_cast<double>(a.main_light_intensity[c]) / k_pi_double * std::max(0.0, facing), sum};
     }},
    // In Unity's world z is turned over. Its light of intensity I shows a white surface I max(0, cos), without 1 / pi.
    {"unity", [](const sandglass_light& lighting, sandglass_light_model model, Direction n, size_t c) -> Shown {
       const sandglass_unity_light u = unity_of(lighting, model);
       const Direction mirrored = {n.x, n.y, -n.z}, forward = turned(u.rotation, {0, 0, 1});
       EXPECT_NEAR(cosine(forward, {u.forward[0], u.forward[1], u.forward[2]}), 1.0, 1e-6);
       return {static_cast<double>(u.intensity * u.colour[c]) * std::max(0.0, -cosine(mirrored, forward)),
               sum_of(u.sh + 9 * c, 1, mirrored)};
     }}};

// The claim: harmonics and directional light together are the light, and with WHOLE the harmonics alone. The control:
// with the harmonics of everything beside the directional light, the light is there twice.
TEST(Renderers, ShowAllOfTheLightOnce) {
  for (const Source& s : sources())
    for (const Renderer& renderer : k_renderers)
      for (size_t k = 0; k < s.normals.size(); ++k)
        for (size_t c = 0; c < 3; ++c) {
          const double facing = cosine(s.normals[k], s.towards);
          const double truth = s.sky[c] + s.facing[c] / k_pi_double * std::max(0.0, facing);
          const Shown ambient = renderer.shown(s.lighting, k_ambient, s.normals[k], c);
          const Shown whole = renderer.shown(s.lighting, k_whole, s.normals[k], c);
          EXPECT_NEAR(ambient.by_harmonics + ambient.by_light, truth, 1e-5) << s.name << renderer.name << k;
          EXPECT_EQ(whole.by_light, 0.0) << s.name << renderer.name;
          // Nine coefficients hold a lobe to 3 %: odd l above 1 vanish, and l = 4 has the factor -1/24.
          EXPECT_NEAR(whole.by_harmonics, s.shown[k][c],
                      s.tolerance > 0 ? 0.001 + s.tolerance * s.facing[c] / k_pi_double : 1e-5)
              << s.name << renderer.name << k;
          if (facing > 0.5) {
            EXPECT_GT(whole.by_harmonics + ambient.by_light, 1.3 * truth) << "the control: counted twice";
          }
        }
}

// What a system tells of a light that is known: radiance 0.6 + b.d + m (xy + yz / 2 - xz + x^2 - z^2) and a lamp. Each face
// of a white cube shows it to 0.5 %, in every renderer. Controls that are wrong by more than a tenth: the harmonics' phase
// not told, everything beside the lamp, and the lamp over pi.
TEST(Renderers, AWhiteCubeInThreeKnownLights) {
  constexpr Direction k_faces[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  constexpr int k_rings = 100, k_around = 200;
  const struct {
    Direction b, lamp;
    double m;
  } lights[] = {{{0.2, 0.3, -0.15}, towards(40, 50), 0.1},
                {{-0.3, -0.1, 0.2}, towards(-120, 30), -0.15},
                {{0, 0.4, 0.1}, towards(170, 75), 0.05}};
  for (const auto& [b, lamp, m] : lights) {
    sandglass_harmonics given;
    sandglass_harmonics_default(&given);
    given.kind = SANDGLASS_HARMONICS_AMBIENT;
    given.with_phase = 1;
    const double axis[3] = {lamp.x, lamp.y, lamp.z},
                 of_polynomials[9] = {0.6, -b.y, b.z, -b.x, m, -m / 2, -m / 2, m, m / 2};
    for (size_t i = 0; i < 27; ++i) given.sh[i] = static_cast<float>(of_polynomials[i / 3] / normalisation()[i / 3]);
    for (size_t c = 0; c < 3; ++c) {
      given.main_direction[c] = static_cast<float>(2 * axis[c]);  // of any length
      given.main_irradiance[c] = static_cast<float>(k_lamp[c]);
    }
    auto lighting = sized<sandglass_light>(), signs = lighting;
    ASSERT_EQ(sandglass_light_of_harmonics(&given, &lighting, nullptr), SANDGLASS_OK);
    given.with_phase = 0;
    ASSERT_EQ(sandglass_light_of_harmonics(&given, &signs, nullptr), SANDGLASS_OK);
    for (const Renderer& renderer : k_renderers) {
      std::array<double, 4> worst = {};
      for (const Direction& n : k_faces)
        for (size_t c = 0; c < 3; ++c) {
          double truth = k_lamp[c] / k_pi_double * std::max(0.0, cosine(n, lamp));
          for (int i = 0; i < k_rings * k_around; ++i) {
            const double y = -1 + (2 * (i / k_around) + 1.0) / k_rings, level = std::sqrt(1 - y * y);
            const double phi = 2 * k_pi_double * (i % k_around + 0.5) / k_around;
            const Direction d = {level * std::cos(phi), y, level * std::sin(phi)};
            const double form = d.x * d.y + d.y * d.z / 2 - d.x * d.z + d.x * d.x - d.z * d.z;
            truth += 4.0 / (k_rings * k_around) * (0.6 + cosine(d, b) + m * form) * std::max(0.0, cosine(n, d));
          }
          const auto [sun, sky] = renderer.shown(lighting, k_ambient, n, c);
          const double shown[4] = {sun + sky, sun + renderer.shown(signs, k_ambient, n, c).by_harmonics,
                                   sun + renderer.shown(lighting, k_whole, n, c).by_harmonics, sun / k_pi_double + sky};
          for (size_t i = 0; i < 4; ++i) worst[i] = std::max(worst[i], std::fabs(shown[i] / truth - 1));
          if (n.y == 1) {
            EXPECT_NEAR(lighting.floor[c], k_pi_double * truth, 0.005 * truth);
          }
        }
      EXPECT_LT(worst[0], 0.005) << renderer.name;
      EXPECT_GT(*std::min_element(worst.begin() + 1, worst.end()), 0.1) << renderer.name << ": a control";
    }
  }
}

TEST(Renderers, FilamentsUnitsAndTableOfFactors) {
  for (const Source& s : sources()) {
    const sandglass_filament_light f = filament_of(s.lighting, k_ambient), whole = filament_of(s.lighting, k_whole);
    EXPECT_EQ(f.sh_intensity, k_nits);
    EXPECT_EQ(std::max({f.colour[0], f.colour[1], f.colour[2]}), 1.0f);
    for (size_t i = 0; i < 27; ++i) {
      const double phase = i / 3 % 2 == 1 ? -1.0 : 1.0;  // indices 1, 3, 5, 7: odd m
      EXPECT_NEAR(whole.sh[i], phase * s.lighting.whole_sh[i] * k_table[i / 3], 3e-6) << i;
    }
  }
}

// Lumens: 1000 are irradiance pi of a facing surface, or radiance 1 from everywhere.
TEST(Renderers, ArkitsLayoutAndLumensAndItsNodeShinesAlongItsAxis) {
  for (const Source& s : sources()) {
    const sandglass_arkit_light a = arkit_of(s.lighting, k_ambient), w = arkit_of(s.lighting, k_whole);
    const double lamp = luminance_of(s.facing) / k_pi_double, up = std::max(0.0, s.towards.y);
    EXPECT_NEAR(a.primary_light_intensity, 1000 * lamp, 1e-3);
    EXPECT_NEAR(a.ambient_intensity, 1000 * luminance_of(s.sky), 1e-3);
    EXPECT_EQ(w.primary_light_intensity, 0.0f);
    EXPECT_NEAR(w.ambient_intensity, 1000 * (luminance_of(s.sky) + lamp * up), 1e-3);
    EXPECT_GT(a.ambient_colour_temperature, 6600.0f) << "the sky is blue";
    for (size_t i = 0; i < 9; ++i)
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(a.sh[9 * c + i], s.lighting.ambient_sh[3 * i + c]);
        EXPECT_EQ(w.sh[9 * c + i], s.lighting.whole_sh[3 * i + c]);
      }
    const float* d = a.primary_light_direction;
    EXPECT_NEAR(cosine({d[0], d[1], d[2]}, s.towards), -1.0, 1e-6);
    EXPECT_NEAR(cosine(turned(a.orientation, {0, 0, -1}), s.towards), -1.0, 1e-6);
  }
}

// McCamy's formula is within 2 K of D65, and within 1 % of illuminant A at 2856 K (x = 0.4476, y = 0.4074).
TEST(Renderers, ColourTemperaturesOfKnownIlluminants) {
  const double x = 0.4476, y = 0.4074, X = x / y, Z = (1.0 - x - y) / y;  // Y = 1; to linear sRGB
  const Colour incandescent = {3.2404542 * X - 1.5371385 - 0.4985314 * Z, -0.9692660 * X + 1.8760108 + 0.0415560 * Z,
                               0.0556434 * X - 0.2040259 + 1.0572252 * Z};
  const auto kelvin = [](const Colour& ambient) {
    sandglass_estimator_light e = estimate_of(towards(-59, 54));
    for (size_t c = 0; c < 3; ++c) e.ambient[c] = static_cast<float>(0.3 * ambient[c]);
    auto lighting = sized<sandglass_light>();
    EXPECT_EQ(sandglass_light_of_estimator(&e, &lighting, nullptr), SANDGLASS_OK);
    return arkit_of(lighting, k_ambient).ambient_colour_temperature;
  };
  EXPECT_NEAR(kelvin({1, 1, 1}), 6504, 10);
  EXPECT_NEAR(kelvin(incandescent), 2856, 28);
  EXPECT_EQ(kelvin({0, 0, 0}), 6500.0f);
}

// A lamp near the horizon: its strength stops at 10 times what it gives the floor, and what is drawn is what is taken
// out of the harmonics.
TEST(Renderers, ALowLampIsNotStrongerThanTheRuleAllows) {
  const Direction low = towards(20, 2);
  const sandglass_room_light light = lit_room(low);
  const sandglass_arcore_light a = arcore_of(lighting_of(light), k_ambient);
  for (size_t c = 0; c < 3; ++c) {
    const double drawn = static_cast<double>(a.main_light_intensity[c]);
    EXPECT_NEAR(drawn, k_lamp[c] * low.y / 0.1, 1e-5);
    EXPECT_NEAR(static_cast<double>(a.sh[c]), light.sh[c] - drawn * normalisation()[0], 1e-5);
  }
}

// A whole session, in a dim room with a lamp that gives the floor most of its light. What AMBIENT and the directional
// light give the floor is the level that the room says, within what nine coefficients can hold of the rest.
TEST(Renderers, ASessionsLightKeepsTheFloorsLevel) {
  MadeUpRoom room;
  const Radiance radiance = lamp_room(towards(126, 50), 5.0, 60.0);
  for (int turn = 0; turn < 3; ++turn) room.look_everywhere(radiance, 1.0 / 64);
  const sandglass_room_light light = room.light();
  ASSERT_GT(light.main_share, 0.3f);
  const sandglass_light lighting = lighting_of(light);
  for (size_t c = 0; c < 3; ++c) {
    const Shown ambient = k_renderers[0].shown(lighting, k_ambient, {0, 1, 0}, c);
    const Shown whole = k_renderers[0].shown(lighting, k_whole, {0, 1, 0}, c);
    EXPECT_NEAR(k_pi_double * (ambient.by_harmonics + ambient.by_light), light.irradiance[c],
                0.1 * light.irradiance[c]);
    EXPECT_GT(k_pi_double * (whole.by_harmonics + ambient.by_light), 1.25 * light.irradiance[c]) << "counted twice";
  }
}

// ------------------------------------------------------------------------------------------------------- refusals

using Fields = std::vector<std::pair<size_t, size_t>>;  // where floats begin, and how many

// `convert` reads `good` and a struct that is longer. It refuses NULL, a struct without a size, each number that is
// none, and an Out that cannot be filled, and then fills nothing. `first` is a number of Out.
template <class Out, class Given, class Convert>
void expect_checked(const Given& good, const Fields& fields, float (*first)(const Out&), Convert&& convert) {
  const auto call = [&](const Given* given, const char** why) {
    auto out = sized<Out>();
    const sandglass_status status = convert(given, &out, why);
    EXPECT_EQ(status == SANDGLASS_OK, first(out) != 0.0f);
    return status;
  };
  Given newer = good, unset = good;
  newer.struct_size += 40;
  unset.struct_size = 8;
  EXPECT_EQ(call(&good, nullptr), SANDGLASS_OK);
  EXPECT_EQ(call(&newer, nullptr), SANDGLASS_OK);
  expect_refused("NULL", [&](const char** why) { return call(nullptr, why); });
  expect_refused("struct_size", [&](const char** why) { return call(&unset, why); });
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    for (const auto& [begin, count] : fields)
      for (size_t i = 0; i < count; ++i) {
        Given spoiled = good;
        memcpy(reinterpret_cast<char*>(&spoiled) + begin + i * sizeof bad, &bad, sizeof bad);
        expect_refused("not finite", [&](const char** why) { return call(&spoiled, why); });
      }
  Out small = {};
  small.struct_size = 4;
  expect_refused("struct_size", [&](const char** why) { return convert(&good, &small, why); });
  expect_refused("NULL", [&](const char** why) { return convert(&good, static_cast<Out*>(nullptr), why); });
  EXPECT_EQ(first(small), 0.0f);
}

TEST(Lighting, OfWhatIsWrongIsRefusedWithASentence) {
  const auto first = [](const sandglass_light& l) { return l.whole_sh[0]; };
  expect_checked<sandglass_light>(estimate_of({0, 1, 0}),
                                  {{offsetof(sandglass_estimator_light, direction), 3},
                                   {offsetof(sandglass_estimator_light, light), 3},
                                   {offsetof(sandglass_estimator_light, strength), 1},
                                   {offsetof(sandglass_estimator_light, ambient), 3},
                                   {offsetof(sandglass_estimator_light, sh), 27}},
                                  first, sandglass_light_of_estimator);
  expect_checked<sandglass_light>(lit_room({0, 1, 0}),
                                  {{offsetof(sandglass_room_light, main_direction), 3},
                                   {offsetof(sandglass_room_light, main_share), 1},
                                   {offsetof(sandglass_room_light, main_colour), 3},
                                   {offsetof(sandglass_room_light, irradiance), 3},
                                   {offsetof(sandglass_room_light, sh), 27}},
                                  first, sandglass_light_of_room);
  sandglass_harmonics desc;
  sandglass_harmonics_default(&desc);
  desc.sh[0] = 1;
  expect_checked<sandglass_light>(desc, {{offsetof(sandglass_harmonics, sh), 33}}, first, sandglass_light_of_harmonics);
  desc.kind = SANDGLASS_HARMONICS_AMBIENT;
  desc.main_direction[1] = 0;
  auto lighting = sized<sandglass_light>();
  expect_refused("main_direction",
                 [&](const char** why) { return sandglass_light_of_harmonics(&desc, &lighting, why); });
}

// Even white light that shows white as 1 has the irradiance pi and 2 sqrt(pi) in coefficient 0. All is linear.
TEST(Lighting, AThingMayKeepItsOwnColours) {
  for (const Source& source : sources()) {
    for (const float strength : {0.0f, 0.3f, 1.0f})
      for (const int32_t keep : {0, 1}) {
        sandglass_light l = source.lighting;
        ASSERT_EQ(sandglass_light_adapt(&l, strength, keep, &l, nullptr), SANDGLASS_OK);
        const double s = static_cast<double>(strength);
        const auto expect = [&](const float* now, const float* then, double white) {
          const Colour before = {static_cast<double>(then[0]), static_cast<double>(then[1]),
                                 static_cast<double>(then[2])};
          for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(now[c], s * (keep == 1 ? luminance_of(before) : before[c]) + (1 - s) * white, 1e-5)
                << source.name;
        };
        expect(l.facing, source.lighting.facing, 0);
        expect(l.floor, source.lighting.floor, k_pi_double);
        for (size_t i = 0; i < 9; ++i) {
          expect(l.whole_sh + 3 * i, source.lighting.whole_sh + 3 * i, i == 0 ? 2 * std::sqrt(k_pi_double) : 0);
          expect(l.ambient_sh + 3 * i, source.lighting.ambient_sh + 3 * i, i == 0 ? 2 * std::sqrt(k_pi_double) : 0);
        }
        EXPECT_EQ(memcmp(l.towards, source.lighting.towards, sizeof l.towards), 0);
      }
    sandglass_light same = source.lighting;
    ASSERT_EQ(sandglass_light_adapt(&same, 1, 0, &same, nullptr), SANDGLASS_OK);
    EXPECT_EQ(memcmp(&same, &source.lighting, sizeof same), 0);
  }
  sandglass_light l = sources()[0].lighting;
  for (const float bad : {-0.1f, 1.1f, std::numeric_limits<float>::quiet_NaN()})
    expect_refused("strength", [&](const char** why) { return sandglass_light_adapt(&l, bad, 0, &l, why); });
  expect_refused("keep_chroma", [&](const char** why) { return sandglass_light_adapt(&l, 1, 2, &l, why); });
  expect_refused("NULL", [&](const char** why) { return sandglass_light_adapt(nullptr, 1, 0, &l, why); });
  l.struct_size = 0;
  expect_refused("struct_size", [&](const char** why) { return sandglass_light_adapt(&l, 1, 0, &l, why); });
  l = sources()[0].lighting;
  l.facing[1] = std::numeric_limits<float>::infinity();
  expect_refused("not finite", [&](const char** why) { return sandglass_light_adapt(&l, 1, 0, &l, why); });
}

template <class Out, class Convert, class... More>
void expect_renderer_checked(Convert to, More... more) {
  const sandglass_light& good = sources()[0].lighting;
  constexpr size_t k_first = offsetof(sandglass_light, towards);
  const auto with = [=](sandglass_light_model model) {
    return [=](const sandglass_light* l, Out* out, const char** why) { return to(l, model, more..., out, why); };
  };
  expect_checked<Out>(
      good, {{k_first, (sizeof good - k_first) / sizeof(float)}}, [](const Out& out) { return out.sh[0]; },
      with(k_ambient));
  auto out = sized<Out>();
  for (const sandglass_light_model model : {-1, 2})
    expect_refused("model", [&](const char** why) { return with(model)(&good, &out, why); });
}

TEST(Renderers, WhatIsWrongIsRefusedWithASentence) {
  expect_renderer_checked<sandglass_filament_light>(sandglass_light_to_filament, k_nits);
  expect_renderer_checked<sandglass_arkit_light>(sandglass_light_to_arkit);
  expect_renderer_checked<sandglass_arcore_light>(sandglass_light_to_arcore);
  expect_renderer_checked<sandglass_unity_light>(sandglass_light_to_unity);
  auto filament = sized<sandglass_filament_light>();
  for (const float nits : {0.0f, 2e9f, std::numeric_limits<float>::quiet_NaN()})
    expect_refused("nits", [&](const char** why) {
      return sandglass_light_to_filament(&sources()[0].lighting, k_whole, nits, &filament, why);
    });
}

}  // namespace
}  // namespace sandglass
