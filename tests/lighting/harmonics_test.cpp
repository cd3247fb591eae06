// Harmonics and renderers against numerical integration of the light model in double, and against the formulas that
// Filament, SceneKit and Unity evaluate, which are written here.
#include "runtime/light/harmonics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "models/lighting/labels.h"
#include "models/rooms/panorama.h"
#include "tests/reason.h"

namespace sandglass {
namespace {

using host::Vec3;
using tests::expect_refused;
constexpr double k_circle = 2.0 * std::numbers::pi;

sandglass_light_estimate estimate_of(Vec3 direction, float contrast = 0.6f) {
  sandglass_light_estimate e = {};
  e.struct_size = sizeof e;
  e.valid = 1;
  const Vec3 d = host::normalised(direction);
  const double v[3] = {d.x, d.y, d.z};
  for (int i = 0; i < 3; ++i) e.direction[i] = static_cast<float>(v[i]);
  e.light[0] = 0.9f, e.light[1] = 0.7f, e.light[2] = 0.4f;
  e.ambient[0] = 0.2f, e.ambient[1] = 0.25f, e.ambient[2] = 0.35f;
  e.contrast = contrast;
  e.strength = 2.5f;
  return e;
}

template <class Struct>
Struct sized() {
  Struct s = {};
  s.struct_size = sizeof s;
  return s;
}

sandglass_light_filament filament_of(const sandglass_light_estimate& e, sandglass_light_model model, float nits) {
  sandglass_light_filament f = sized<sandglass_light_filament>();
  EXPECT_EQ(sandglass_light_to_filament(&e, model, nits, &f, nullptr), SANDGLASS_OK);
  return f;
}
sandglass_light_arkit arkit_of(const sandglass_light_estimate& e) {
  sandglass_light_arkit a = sized<sandglass_light_arkit>();
  EXPECT_EQ(sandglass_light_to_arkit(&e, SANDGLASS_LIGHT_MODEL_WHOLE, &a, nullptr), SANDGLASS_OK);
  return a;
}
std::array<float, 27> harmonics_of(const sandglass_light_estimate& e, sandglass_light_model model) {
  std::array<float, 27> sh = {};
  EXPECT_EQ(sandglass_light_harmonics(&e, model, sh.data(), nullptr), SANDGLASS_OK);
  return sh;
}

const Vec3 k_directions[] = {{0.3, 0.8, -0.5}, {0, 1, 0}, {-0.9, 0.1, 0.4}, {0.2, -0.7, 0.6}};

Vec3 towards(const sandglass_light_estimate& e) { return {e.direction[0], e.direction[1], e.direction[2]}; }

double gaussian(double cosine) { return std::exp(k_circle * (cosine - 1.0)); }

double irradiance_facing_gaussian() {
  double sum = 0.0;
  constexpr int k_steps = 200000;
  for (int i = 0; i < k_steps; ++i) {
    const double t = (i + 0.5) / k_steps;
    sum += k_circle * t * gaussian(t) / k_steps;
  }
  return sum;
}

// The radiance of a model from a direction, in one colour, as the header describes it in words.
double radiance(const sandglass_light_estimate& e, sandglass_light_model model, Vec3 from, int colour) {
  const double a = e.ambient[colour], c = e.light[colour], g = gaussian(host::dot(towards(e), from));
  if (model == SANDGLASS_LIGHT_MODEL_AMBIENT) return a;
  if (model == SANDGLASS_LIGHT_MODEL_PICTURE) return 1.0 - (1.0 - g * c) * (1.0 - a);
  static const double k_height = std::numbers::pi / irradiance_facing_gaussian();
  return a + k_height * e.strength * c * g;
}

// The integral over the sphere, in rings of equal height: exact for the low harmonics.
template <class Function>
void integrate(Function&& add) {
  constexpr int k_rings = 400, k_around = 800;
  for (int i = 0; i < k_rings; ++i) {
    const double y = -1.0 + (2 * i + 1.0) / k_rings, s = std::sqrt(1.0 - y * y);
    for (int j = 0; j < k_around; ++j) {
      const double phi = k_circle * (j + 0.5) / k_around;
      add(Vec3{s * std::cos(phi), y, s * std::sin(phi)}, 2.0 * k_circle / (k_rings * k_around));
    }
  }
}

// The basis as the header writes it.
void basis(Vec3 v, double y[9]) {
  y[0] = 0.5 / std::sqrt(std::numbers::pi);
  const double one = std::sqrt(3.0 / (4.0 * std::numbers::pi)), two = std::sqrt(15.0 / (4.0 * std::numbers::pi));
  y[1] = one * v.y, y[2] = one * v.z, y[3] = one * v.x;
  y[4] = two * v.x * v.y, y[5] = two * v.y * v.z, y[7] = two * v.x * v.z;
  y[6] = std::sqrt(5.0 / (16.0 * std::numbers::pi)) * (3.0 * v.z * v.z - 1.0);
  y[8] = 0.5 * two * (v.x * v.x - v.y * v.y);
}

TEST(Harmonics, AreTheIntegralsOfTheModelOverTheSphere) {
  for (const sandglass_light_model model :
       {SANDGLASS_LIGHT_MODEL_AMBIENT, SANDGLASS_LIGHT_MODEL_WHOLE, SANDGLASS_LIGHT_MODEL_PICTURE})
    for (const Vec3& direction : k_directions) {
      const sandglass_light_estimate e = estimate_of(direction);
      double expected[27] = {};
      integrate([&](Vec3 v, double omega) {
        double y[9];
        basis(v, y);
        for (int c = 0; c < 3; ++c) {
          const double l = radiance(e, model, v, c) * omega;
          for (int i = 0; i < 9; ++i) expected[3 * i + c] += l * y[i];
        }
      });
      const auto sh = harmonics_of(e, model);
      for (size_t i = 0; i < 27; ++i)
        EXPECT_NEAR(sh[i], expected[i], 2e-4 * (1.0 + std::fabs(expected[i]))) << model << " " << i;
    }
}

// The model PICTURE is the map that `sandglass light` draws.
TEST(Harmonics, PictureIsTheEnvironmentMapOfTheSource) {
  const sandglass_light_estimate e = estimate_of(k_directions[0]);
  host::LightLabels labels = {};
  labels.direction = towards(e);
  labels.light = {e.light[0], e.light[1], e.light[2]}, labels.ambient = {e.ambient[0], e.ambient[1], e.ambient[2]};
  const host::RadianceMap map = host::environment_of(labels, 128, 64);
  for (int v = 0; v < 64; v += 5)
    for (int u = 0; u < 128; u += 7)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(map.at(u, v)[c],
                    radiance(e, SANDGLASS_LIGHT_MODEL_PICTURE, host::panorama_direction(u, v, 128, 64), c), 1e-6);
}

// The irradiance of a surface with this normal by the model, divided by pi.
double diffuse(const sandglass_light_estimate& e, sandglass_light_model model, Vec3 normal, int colour) {
  double sum = 0.0;
  integrate([&](Vec3 v, double omega) {
    sum += std::max(0.0, host::dot(v, normal)) * radiance(e, model, v, colour) * omega;
  });
  return sum / std::numbers::pi;
}

// The header's directional light and the lobe of WHOLE give a surface that faces them the same irradiance.
TEST(Harmonics, WholeGivesAFacingSurfaceWhatTheDirectionalLightGives) {
  const sandglass_light_estimate e = estimate_of(k_directions[0]);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(diffuse(e, SANDGLASS_LIGHT_MODEL_WHOLE, towards(e), c), e.ambient[c] + e.strength * e.light[c], 1e-3);
}

// The rule that defines strength: the directional light's share of the level floor's irradiance is the contrast.
TEST(Harmonics, StrengthMakesTheContrastTheShareOfTheFloor) {
  const auto lum = [](const double* c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; };
  const double light[3] = {0.9, 0.7, 0.4}, ambient[3] = {0.2, 0.25, 0.35};
  for (const double o : {0.0, 0.3, 0.8})
    for (const double up : {0.2, 0.7, 1.0}) {
      const double direction[3] = {std::sqrt(1.0 - up * up), up, 0.0};
      const double s = light_strength(direction, light, ambient, o);
      const double from_light = std::numbers::pi * s * lum(light) * up, from_rest = std::numbers::pi * lum(ambient);
      EXPECT_NEAR(from_light / (from_light + from_rest), o, 1e-12);
    }
  const double below[3] = {0.6, -0.8, 0.0}, black[3] = {};
  EXPECT_NEAR(light_strength(below, light, ambient, 1.0), std::min(64.0, lum(ambient) / lum(light) * 19.0 / 0.1), 1e-9);
  EXPECT_EQ(light_strength(below, black, ambient, 0.5), 0.0);
}

// ------------------------------------------------------------------------------------------------------- renderers

// Filament's and Unity's shaders evaluate this polynomial with their nine coefficients.
double polynomial(const float* sh, int stride, Vec3 n) {
  const double terms[9] = {
      1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y};
  double sum = 0.0;
  for (int i = 0; i < 9; ++i) sum += sh[stride * i] * terms[i];
  return sum;
}

// The irradiance of the radiance's harmonics up to l = 2, divided by pi: 2 pi x the lobe's cosine factors, by
// quadrature. The rest is below 3 % of the lobe (odd l above 1 vanish, l = 4 has the factor -1/24).
void expect_diffuse(const sandglass_light_estimate& e, sandglass_light_model model, const float* sh, int stride,
                    int colour, bool mirrored) {
  for (const Vec3& normal : {Vec3{0, 1, 0}, Vec3{0.6, 0.8, 0}, Vec3{0, 0, 1}, Vec3{-0.48, 0.6, -0.64}, towards(e)}) {
    const Vec3 n = host::normalised(normal);
    const Vec3 drawn = mirrored ? Vec3{n.x, n.y, -n.z} : n;
    const double lobe = model == SANDGLASS_LIGHT_MODEL_WHOLE ? e.strength * e.light[colour] : 0.0;
    EXPECT_NEAR(polynomial(sh + colour, stride, drawn), diffuse(e, model, n, colour), 0.001 + 0.03 * lobe) << colour;
  }
}

TEST(Renderers, FilamentsShaderGetsIrradianceOverPi) {
  for (const sandglass_light_model model : {SANDGLASS_LIGHT_MODEL_AMBIENT, SANDGLASS_LIGHT_MODEL_WHOLE}) {
    const sandglass_light_estimate e = estimate_of(k_directions[0]);
    const sandglass_light_filament f = filament_of(e, model, 40.0f);
    for (int c = 0; c < 3; ++c) expect_diffuse(e, model, f.sh, 3, c, false);
  }
}

// Filament's documented table is for radiance in the basis with the Condon-Shortley phase. The product is the same.
TEST(Renderers, FilamentsTableOfFactorsGivesTheSameCoefficients) {
  const double table[9] = {0.282095,  -0.325735, 0.325735,  -0.325735, 0.273137,
                           -0.273137, 0.078848,  -0.273137, 0.136569};
  const sandglass_light_estimate e = estimate_of(k_directions[3]);
  const sandglass_light_filament f = filament_of(e, SANDGLASS_LIGHT_MODEL_WHOLE, 1.0f);
  const auto sh = harmonics_of(e, SANDGLASS_LIGHT_MODEL_WHOLE);
  for (size_t i = 0; i < 27; ++i) {
    const double phase = i / 3 % 2 == 1 ? -1.0 : 1.0;  // indices 1, 3, 5, 7: odd m
    EXPECT_NEAR(f.sh[i], phase * sh[i] * table[i / 3], 3e-6) << i;
  }
}

// A directional light of E lux gives a white diffuse surface that faces it the luminance E / pi. An IndirectLight of
// intensity I gives it the luminance I x polynomial. Both must be nits x the header's radiance.
TEST(Renderers, FilamentsLightsAreInOneUnit) {
  const sandglass_light_estimate e = estimate_of(k_directions[0]);
  const sandglass_light_filament f = filament_of(e, SANDGLASS_LIGHT_MODEL_AMBIENT, 40.0f);
  for (int c = 0; c < 3; ++c) {
    const double luminance = f.intensity * f.colour[c] / std::numbers::pi + f.sh_intensity * f.sh[c];
    EXPECT_NEAR(luminance, 40.0 * (e.strength * e.light[c] + e.ambient[c]), 1e-3);
    EXPECT_EQ(f.direction[c], -e.direction[c]);
  }
  EXPECT_EQ(std::max({f.colour[0], f.colour[1], f.colour[2]}), 1.0f);
}

// The vector v turned by a unit quaternion.
Vec3 turned(const float q[4], Vec3 v) {
  const Vec3 u = {q[0], q[1], q[2]};
  const auto cross = [](Vec3 a, Vec3 b) {
    return Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const Vec3 t = cross(u, v) * 2.0;
  return v + t * q[3] + cross(u, t);
}

TEST(Renderers, ArkitsLayoutIsPlanarAndItsNodeShinesAlongItsAxis) {
  for (const Vec3& direction : k_directions) {
    const sandglass_light_estimate e = estimate_of(direction);
    const sandglass_light_arkit a = arkit_of(e);
    const auto sh = harmonics_of(e, SANDGLASS_LIGHT_MODEL_WHOLE);
    for (size_t i = 0; i < 9; ++i)
      for (size_t c = 0; c < 3; ++c) EXPECT_EQ(a.sh[9 * c + i], sh[3 * i + c]);
    const Vec3 shines = turned(a.orientation, {0, 0, -1});
    EXPECT_NEAR(host::length(shines + towards(e)), 0.0, 1e-6);
    EXPECT_NEAR(a.primary_light_intensity, 1000 * 2.5 * (0.2126 * 0.9 + 0.7152 * 0.7 + 0.0722 * 0.4), 0.01);
    EXPECT_NEAR(a.ambient_intensity, 1000 * (0.2126 * 0.2 + 0.7152 * 0.25 + 0.0722 * 0.35), 0.01);
  }
}

// McCamy's formula is within 2 K of D65, and within 1 % of illuminant A at 2856 K (x = 0.4476, y = 0.4074).
TEST(Renderers, ColourTemperaturesOfKnownIlluminants) {
  sandglass_light_estimate e = estimate_of(k_directions[0]);
  e.ambient[0] = e.ambient[1] = e.ambient[2] = 0.4f;
  EXPECT_NEAR(arkit_of(e).ambient_colour_temperature, 6504, 10);
  const double x = 0.4476, y = 0.4074, X = x / y, Z = (1.0 - x - y) / y;  // Y = 1; to linear sRGB
  e.ambient[0] = static_cast<float>(0.3 * (3.2404542 * X - 1.5371385 - 0.4985314 * Z));
  e.ambient[1] = static_cast<float>(0.3 * (-0.9692660 * X + 1.8760108 + 0.0415560 * Z));
  e.ambient[2] = static_cast<float>(0.3 * (0.0556434 * X - 0.2040259 + 1.0572252 * Z));
  EXPECT_NEAR(arkit_of(e).ambient_colour_temperature, 2856, 28);
  e.ambient[0] = e.ambient[1] = e.ambient[2] = 0.0f;
  EXPECT_EQ(arkit_of(e).ambient_colour_temperature, 6500.0f);
}

TEST(Renderers, UnitysProbeInItsMirroredWorld) {
  for (const Vec3& direction : k_directions) {
    const sandglass_light_estimate e = estimate_of(direction);
    sandglass_light_unity u = sized<sandglass_light_unity>();
    ASSERT_EQ(sandglass_light_to_unity(&e, SANDGLASS_LIGHT_MODEL_WHOLE, &u, nullptr), SANDGLASS_OK);
    for (int c = 0; c < 3; ++c) expect_diffuse(e, SANDGLASS_LIGHT_MODEL_WHOLE, u.sh + 8 * c, 1, c, true);
    const Vec3 forward = turned(u.rotation, {0, 0, 1});
    EXPECT_NEAR(host::length(forward - Vec3{-e.direction[0], -e.direction[1], e.direction[2]}), 0.0, 1e-6);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(u.intensity * u.colour[c], e.strength * e.light[c], 1e-6);
  }
}

TEST(Renderers, WhatIsWrongIsRefusedWithASentence) {
  sandglass_light_estimate e = estimate_of({0, 1, 0});
  sandglass_light_filament f = sized<sandglass_light_filament>();
  sandglass_light_arkit a = sized<sandglass_light_arkit>();
  sandglass_light_unity u = sized<sandglass_light_unity>();
  float sh[27];
  expect_refused("NULL", [&](const char** why) { return sandglass_light_harmonics(nullptr, 0, sh, why); });
  expect_refused("model", [&](const char** why) { return sandglass_light_harmonics(&e, 3, sh, why); });
  expect_refused("nits", [&](const char** why) { return sandglass_light_to_filament(&e, 0, NAN, &f, why); });
  expect_refused("struct", [&](const char** why) { return sandglass_light_to_filament(&e, 0, 1.0f, nullptr, why); });
  expect_refused("model", [&](const char** why) { return sandglass_light_to_arkit(&e, -1, &a, why); });
  f.struct_size = a.struct_size = u.struct_size = 4;
  const char* const no_size = "struct to fill has no struct_size";
  expect_refused(no_size, [&](const char** why) { return sandglass_light_to_filament(&e, 0, 1.0f, &f, why); });
  expect_refused(no_size, [&](const char** why) { return sandglass_light_to_arkit(&e, 0, &a, why); });
  expect_refused(no_size, [&](const char** why) { return sandglass_light_to_unity(&e, 0, &u, why); });
  EXPECT_EQ(f.sh[0] + a.sh[0] + u.sh[0], 0.0f) << "a refused call must not fill its result";
  u.struct_size = sizeof u, e.struct_size = 4;
  expect_refused("estimate.struct_size", [&](const char** why) { return sandglass_light_to_unity(&e, 0, &u, why); });
}

// Of an estimate of a newer header, the fields that this one knows are read.
TEST(Renderers, AnEstimateOfANewerHeaderIsRead) {
  sandglass_light_estimate e = estimate_of(k_directions[0]);
  const auto known = harmonics_of(e, SANDGLASS_LIGHT_MODEL_WHOLE);
  e.struct_size += 40;
  EXPECT_EQ(harmonics_of(e, SANDGLASS_LIGHT_MODEL_WHOLE), known);
}

TEST(CameraPose, MatricesBecomeQuaternionsThatTurnTheSameWay) {
  const float half = std::sqrt(0.5f);
  // Columns: where the camera's x, y and z axes point in the world.
  const float matrices[4][16] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1},
                                 {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1},
                                 {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1},
                                 {half, half, 0, 0, 0, 0, 1, 0, half, -half, 0, 0, 0, 0, 0, 1}};
  for (const auto& m : matrices) {
    float q[4];
    ASSERT_EQ(sandglass_camera_orientation(m, q), 1);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 unit = {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
      const Vec3 expected = {m[4 * axis], m[4 * axis + 1], m[4 * axis + 2]};
      EXPECT_NEAR(host::length(turned(q, unit) - expected), 0.0, 1e-6);
    }
  }
  float q[4];
  const float mirror[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
  const float broken[16] = {NAN, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_EQ(sandglass_camera_orientation(mirror, q), 0);
  EXPECT_EQ(sandglass_camera_orientation(broken, q), 0);
  EXPECT_EQ(q[3], 1.0f);
}

TEST(CameraPose, FocalLengthOfAFieldOfView) {
  EXPECT_NEAR(sandglass_camera_focal(256, 192, 85.0f), 160.0 / std::tan(42.5 * std::numbers::pi / 180), 1e-4);
  EXPECT_EQ(sandglass_camera_focal(256, 192, 180.0f), 0.0f);
  EXPECT_EQ(sandglass_camera_focal(256, 192, NAN), 0.0f);
}

}  // namespace
}  // namespace sandglass
