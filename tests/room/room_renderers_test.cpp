// The light of a room in the terms of renderers, against the formulas that these publish, for an even sky with one small
// lamp, whose harmonics and irradiance are known in double: nothing is lost, and nothing is counted twice.
#include <array>
#include <limits>
#include <string>

#include "made_up_room.h"

namespace sandglass {
namespace {

constexpr double k_pi_double = std::numbers::pi;
using Colour = std::array<double, 3>;
using Nine = std::array<double, 9>;

constexpr Colour k_sky = {0.2, 0.25, 0.35};    // radiance from everywhere
constexpr Colour k_lamp = {2.7, 2.1, 1.2};     // irradiance of a surface that faces the lamp
const Direction k_towards = towards(130, 50);  // the lamp
constexpr sandglass_light_model k_ambient = SANDGLASS_LIGHT_MODEL_AMBIENT, k_whole = SANDGLASS_LIGHT_MODEL_WHOLE;

double luminance(const Colour& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

Nine polynomials(Direction n) {
  return {1, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3 * n.z * n.z - 1, n.x * n.z, n.x * n.x - n.y * n.y};
}
// Y_i / polynomial_i: sqrt(1/4 pi), sqrt(3/4 pi), sqrt(15/4 pi) and the two of them with other factors.
Nine normalisation() {
  const auto root = [](double x) { return std::sqrt(x / (4 * k_pi_double)); };
  return {root(1), root(3), root(3), root(3), root(15), root(15), root(1.25), root(15), root(3.75)};
}

sandglass_room_light lit_room(Direction lamp = k_towards) {
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  light.valid = 1;
  const double axis[3] = {lamp.x, lamp.y, lamp.z};
  const Nine p = polynomials(lamp), norm = normalisation();
  Colour irradiance;
  for (size_t c = 0; c < 3; ++c) irradiance[c] = k_pi_double * k_sky[c] + k_lamp[c] * lamp.y;
  const double share = luminance(k_lamp) * lamp.y / luminance(irradiance);
  light.main_share = static_cast<float>(share);
  for (size_t c = 0; c < 3; ++c) {
    light.main_direction[c] = static_cast<float>(axis[c]);
    light.main_colour[c] = static_cast<float>(k_lamp[c] / luminance(k_lamp));
    light.irradiance[c] = static_cast<float>(irradiance[c]);
    for (size_t i = 0; i < 9; ++i)
      light.sh[3 * i + c] =
          static_cast<float>(k_lamp[c] * norm[i] * p[i] + (i == 0 ? k_sky[c] * 2 * std::sqrt(k_pi_double) : 0.0));
  }
  return light;
}

template <class Struct, class Convert, class... More>
Struct converted(Convert convert, const sandglass_room_light& light, sandglass_light_model model, More... more) {
  Struct out = {};
  out.struct_size = sizeof out;
  const char* reason = nullptr;
  EXPECT_EQ(convert(&light, model, more..., &out, &reason), SANDGLASS_OK) << reason;
  return out;
}
constexpr float k_nits = 40.0f;
sandglass_light_filament filament_of(const sandglass_room_light& light, sandglass_light_model model) {
  return converted<sandglass_light_filament>(sandglass_room_to_filament, light, model, k_nits);
}

// What the shaders of Filament, Unity and ARCore's samples compute of their nine coefficients.
double sum_of(const float* sh, size_t stride, Direction n) {
  const Nine p = polynomials(n);
  double sum = 0;
  for (size_t i = 0; i < 9; ++i) sum += static_cast<double>(sh[stride * i]) * p[i];
  return sum;
}

// Irradiance over pi that nine coefficients of a lamp give, E (1/4 + cos / 2 + 5/32 (3 cos^2 - 1)) by the addition
// theorem, against the exact E max(0, cos) / pi.
double lamp_in_harmonics(size_t colour, double cosine) {
  return k_lamp[colour] / k_pi_double * (0.25 + cosine / 2 + 5.0 / 32 * (3 * cosine * cosine - 1));
}
double lamp_exact(size_t colour, double cosine) { return k_lamp[colour] / k_pi_double * std::max(0.0, cosine); }

const Direction k_normals[] = {{0, 1, 0}, {0.6, 0.8, 0}, {0, 0, 1}, {-0.48, 0.6, -0.64}, {0, -1, 0}, k_towards};

TEST(RoomRenderers, AmbientIsTheSkyAloneAndWholeHasTheLampToo) {
  const sandglass_room_light light = lit_room();
  float ambient[27], whole[27];
  ASSERT_EQ(sandglass_room_harmonics(&light, k_ambient, ambient, nullptr), SANDGLASS_OK);
  ASSERT_EQ(sandglass_room_harmonics(&light, k_whole, whole, nullptr), SANDGLASS_OK);
  for (size_t i = 0; i < 27; ++i) {
    EXPECT_NEAR(ambient[i], i < 3 ? 2 * std::sqrt(k_pi_double) * k_sky[i] : 0.0, 2e-6) << i;
    EXPECT_EQ(whole[i], light.sh[i]);
  }
}

// The claim: harmonics and directional light together are the room. The control: with the whole room's harmonics beside
// the same light, the lamp is there twice.
TEST(RoomRenderers, FilamentGetsTheLampOnce) {
  const sandglass_room_light light = lit_room();
  const sandglass_light_filament ambient = filament_of(light, k_ambient), whole = filament_of(light, k_whole);
  EXPECT_EQ(ambient.sh_intensity, k_nits);
  EXPECT_EQ(whole.intensity, 0.0f) << "the harmonics have the lamp already";
  EXPECT_NEAR(ambient.direction[0], -k_towards.x, 1e-6);
  EXPECT_NEAR(ambient.direction[1], -k_towards.y, 1e-6);
  EXPECT_NEAR(ambient.direction[2], -k_towards.z, 1e-6);
  EXPECT_EQ(std::max({ambient.colour[0], ambient.colour[1], ambient.colour[2]}), 1.0f);
  for (size_t c = 0; c < 3; ++c) {
    // Lux on a facing surface; a white one shows 1 / pi of it.
    const double lux = static_cast<double>(ambient.intensity) * static_cast<double>(ambient.colour[c]);
    EXPECT_NEAR(lux, k_nits * k_lamp[c], 1e-4);
    for (const Direction& n : k_normals) {
      const double facing = cosine(n, k_towards), drawn = lux / k_nits / k_pi_double * std::max(0.0, facing);
      const double truth = k_sky[c] + lamp_exact(c, facing);
      EXPECT_NEAR(sum_of(ambient.sh + c, 3, n) + drawn, truth, 1e-5);
      EXPECT_NEAR(sum_of(whole.sh + c, 3, n), k_sky[c] + lamp_in_harmonics(c, facing), 1e-5);
      if (facing > 0.5) {
        EXPECT_GT(sum_of(whole.sh + c, 3, n) + drawn, 1.3 * truth);
      }
    }
  }
}

// Lumens: 1000 are irradiance pi of a facing surface, or radiance 1 from everywhere.
TEST(RoomRenderers, ArkitsLayoutAndLumens) {
  const sandglass_room_light light = lit_room();
  const auto a = converted<sandglass_light_arkit>(sandglass_room_to_arkit, light, k_ambient);
  const auto w = converted<sandglass_light_arkit>(sandglass_room_to_arkit, light, k_whole);
  EXPECT_NEAR(a.primary_light_intensity, 1000 * luminance(k_lamp) / k_pi_double, 1e-3);
  EXPECT_NEAR(a.ambient_intensity, 1000 * luminance(k_sky), 1e-3);
  EXPECT_EQ(w.primary_light_intensity, 0.0f);
  EXPECT_NEAR(w.ambient_intensity, 1000 * (luminance(k_sky) + luminance(k_lamp) * k_towards.y / k_pi_double), 1e-3);
  EXPECT_GT(a.ambient_colour_temperature, 6600.0f) << "the sky is blue";
  for (size_t i = 0; i < 9; ++i)
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(w.sh[9 * c + i], light.sh[3 * i + c]);
  EXPECT_NEAR(a.primary_light_direction[2], -k_towards.z, 1e-6);
}

// ARCore's samples multiply its coefficients by this table, sum, and add intensity / pi * max(0, n . direction).
TEST(RoomRenderers, ArcoresShaderShowsTheRoom) {
  constexpr double k_table[9] = {0.282095,  -0.325735, 0.325735,  -0.325735, 0.273137,
                                 -0.273137, 0.078848,  -0.273137, 0.136569};
  const sandglass_room_light light = lit_room();
  const auto a = converted<sandglass_light_arcore>(sandglass_room_to_arcore, light, k_ambient);
  const auto w = converted<sandglass_light_arcore>(sandglass_room_to_arcore, light, k_whole);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(a.main_light_intensity[c], k_lamp[c], 1e-5);
    EXPECT_EQ(a.main_light_direction[c], light.main_direction[c]);
    EXPECT_EQ(w.main_light_intensity[c], 0.0f);
    for (const Direction& n : k_normals) {
      const auto shown = [&](const sandglass_light_arcore& arcore) {
        const Nine p = polynomials(n);
        double sum =
            static_cast<double>(arcore.main_light_intensity[c]) / k_pi_double * std::max(0.0, cosine(n, k_towards));
        for (size_t i = 0; i < 9; ++i) sum += static_cast<double>(arcore.sh[3 * i + c]) * k_table[i] * p[i];
        return sum;
      };
      EXPECT_NEAR(shown(a), k_sky[c] + lamp_exact(c, cosine(n, k_towards)), 1e-5);
      EXPECT_NEAR(shown(w), k_sky[c] + lamp_in_harmonics(c, cosine(n, k_towards)), 1e-5);
    }
  }
}

// In Unity's world z is turned over. Its light of intensity I shows a white surface I max(0, cos), without 1 / pi.
TEST(RoomRenderers, UnitysWorldIsMirrored) {
  const sandglass_room_light light = lit_room();
  const auto a = converted<sandglass_light_unity>(sandglass_room_to_unity, light, k_ambient);
  const auto w = converted<sandglass_light_unity>(sandglass_room_to_unity, light, k_whole);
  EXPECT_NEAR(a.forward[0], -k_towards.x, 1e-6);
  EXPECT_NEAR(a.forward[2], k_towards.z, 1e-6);
  EXPECT_EQ(w.intensity, 0.0f);
  for (size_t c = 0; c < 3; ++c)
    for (const Direction& n : k_normals) {
      const Direction mirrored = {n.x, n.y, -n.z};
      const double facing = cosine(n, k_towards);
      const double lamp = static_cast<double>(a.intensity) * static_cast<double>(a.colour[c]) * std::max(0.0, facing);
      EXPECT_NEAR(sum_of(a.sh + 9 * c, 1, mirrored) + lamp, k_sky[c] + lamp_exact(c, facing), 1e-5);
      EXPECT_NEAR(sum_of(w.sh + 9 * c, 1, mirrored), k_sky[c] + lamp_in_harmonics(c, facing), 1e-5);
    }
}

// A lamp near the horizon: its strength stops at 10 times what it gives the floor, and what is drawn is what is taken
// out of the harmonics.
TEST(RoomRenderers, ALowLampIsNotStrongerThanTheRuleAllows) {
  const Direction low = towards(20, 2);
  const sandglass_room_light light = lit_room(low);
  const auto a = converted<sandglass_light_arcore>(sandglass_room_to_arcore, light, k_ambient);
  for (size_t c = 0; c < 3; ++c) {
    const double drawn = static_cast<double>(a.main_light_intensity[c]);
    EXPECT_NEAR(drawn, k_lamp[c] * low.y / 0.1, 1e-5);
    EXPECT_NEAR(static_cast<double>(a.sh[c]), light.sh[c] - drawn * normalisation()[0], 1e-5);
  }
}

// A whole session, in a dim room with a lamp that gives the floor most of its light. What AMBIENT and the directional
// light give the floor is the level that the room says, within what nine coefficients can hold of the rest.
TEST(RoomRenderers, ASessionsLightKeepsTheFloorsLevel) {
  MadeUpRoom room;
  const Radiance radiance = lamp_room(towards(126, 50), 5.0, 60.0);
  for (int turn = 0; turn < 3; ++turn) room.look_everywhere(radiance, 1.0 / 64);
  const sandglass_room_light light = room.light();
  ASSERT_GT(light.main_share, 0.3f);
  const sandglass_light_filament f = filament_of(light, k_ambient);
  for (size_t c = 0; c < 3; ++c) {
    const double lamp = static_cast<double>(f.intensity) * static_cast<double>(f.colour[c]) / k_nits *
                        static_cast<double>(light.main_direction[1]);
    const double floor = k_pi_double * sum_of(f.sh + c, 3, {0, 1, 0}) + lamp;
    EXPECT_NEAR(floor, light.irradiance[c], 0.1 * light.irradiance[c]);
    const double twice = k_pi_double * sum_of(filament_of(light, k_whole).sh + c, 3, {0, 1, 0}) + lamp;
    EXPECT_GT(twice, 1.25 * light.irradiance[c]) << "the control: counted twice";
  }
}

TEST(RoomRenderers, WhatIsWrongIsRefusedWithASentence) {
  const auto refused = [](const sandglass_room_light& light, sandglass_light_model model, const char* word) {
    float sh[27];
    sandglass_light_filament f = {};
    sandglass_light_arkit k = {};
    sandglass_light_arcore c = {};
    sandglass_light_unity u = {};
    f.struct_size = sizeof f, k.struct_size = sizeof k, c.struct_size = sizeof c, u.struct_size = sizeof u;
    const char* reasons[5] = {};
    const sandglass_status all[5] = {sandglass_room_harmonics(&light, model, sh, &reasons[0]),
                                     sandglass_room_to_filament(&light, model, k_nits, &f, &reasons[1]),
                                     sandglass_room_to_arkit(&light, model, &k, &reasons[2]),
                                     sandglass_room_to_arcore(&light, model, &c, &reasons[3]),
                                     sandglass_room_to_unity(&light, model, &u, &reasons[4])};
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(all[i], SANDGLASS_ERROR_INVALID_ARGUMENT) << i;
      ASSERT_NE(reasons[i], nullptr);
      EXPECT_NE(std::string(reasons[i]).find(word), std::string::npos) << reasons[i];
    }
    EXPECT_EQ(f.sh[0] + k.sh[0] + c.sh[0] + u.sh[0], 0.0f) << "a refused call must not fill its result";
  };
  const sandglass_room_light good = lit_room();
  refused(good, SANDGLASS_LIGHT_MODEL_PICTURE, "model");
  refused(good, -1, "model");
  sandglass_room_light bad = good;
  bad.struct_size = 8;
  refused(bad, k_whole, "struct_size");
  float* const numbers[] = {bad.main_direction, &bad.main_share, bad.main_colour, bad.irradiance, bad.sh + 26};
  for (float* number : numbers) {
    bad = good;
    *number = std::numeric_limits<float>::quiet_NaN();
    refused(bad, k_ambient, "not finite");
  }
  sandglass_room_light newer = good;
  newer.struct_size += 40;
  float sh[27];
  EXPECT_EQ(sandglass_room_harmonics(&newer, k_whole, sh, nullptr), SANDGLASS_OK);
}

}  // namespace
}  // namespace sandglass
