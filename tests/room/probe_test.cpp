// Cubes and harmonics into a room: every format, frame and handedness, what a mirrored cube would do, and that camera
// images stay what they were.
#include <array>
#include <cstring>
#include <utility>

#include "runtime/light/harmonics.h"
#include "runtime/light/room/room.h"
#include "sandglass/sandglass.hpp"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

const Direction k_lamp = towards(40, 50);
Direction same(Direction d) { return d; }

// A cube is made from the table of the OpenGL specification, read backwards: s to the right, t down, in -1..1.
Direction face_direction(int face, double s, double t) {
  const Direction d[] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}};
  const double n = std::sqrt(1 + s * s + t * t);
  return {d[face].x / n, d[face].y / n, d[face].z / n};
}

struct Cube {
  std::vector<uint8_t> bytes[6];
  sandglass_cube cube;
};

uint16_t half_of(float x) {  // of normal numbers
  uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return static_cast<uint16_t>(((bits >> 23) - 112) << 10 | (bits >> 13 & 1023));
}

// `to_room`: a direction of the cube's frame in the room. Red is half and blue a quarter of green.
Cube cube_of(const Radiance& radiance, sandglass_cube_format format, uint32_t size,
             const std::function<Direction(Direction)>& to_room = same, double red = 0.5) {
  constexpr uint32_t k_texel[] = {4, 4, 8, 12, 16};
  Cube made;
  sandglass_cube_default(&made.cube);
  made.cube.format = format;
  made.cube.size = size;
  made.cube.stride = static_cast<int32_t>(size * k_texel[format] + 8);
  for (int face = 0; face < 6; ++face) {
    made.bytes[face].resize(size_t{size} * static_cast<uint32_t>(made.cube.stride));
    made.cube.faces[face] = made.bytes[face].data();
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        double grey = 0;
        for (int k = 0; k < 16; ++k)
          grey += radiance(to_room(face_direction(face, 2 * (x + (k % 4 + 0.5) / 4) / size - 1,
                                                  2 * (y + (k / 4 + 0.5) / 4) / size - 1))) /
                  16;
        const float rgb[3] = {static_cast<float>(red * grey), static_cast<float>(grey), static_cast<float>(grey / 4)};
        uint8_t* p = made.bytes[face].data() + y * static_cast<uint32_t>(made.cube.stride) + x * k_texel[format];
        for (int c = 0; c < 3; ++c) {
          const double linear = std::min(static_cast<double>(rgb[c]), 1.0);
          const double coded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
          const uint16_t half = half_of(rgb[c]);
          if (format == SANDGLASS_CUBE_RGBA16F) std::memcpy(p + 2 * c, &half, 2);
          else if (format >= SANDGLASS_CUBE_RGB32F) std::memcpy(p + 4 * c, &rgb[c], 4);
          else p[format == SANDGLASS_CUBE_BGRA8 ? 2 - c : c] = static_cast<uint8_t>(std::lround(255 * coded));
        }
      }
  }
  return made;
}

cpp::Room room_with_probe() {
  cpp::Room room;
  sandglass_room_desc desc = cpp::room_desc();
  desc.probe = 1;
  desc.interval = 0;
  EXPECT_TRUE(room.create(desc));
  return room;
}
sandglass_room_light light_of(const cpp::Room& room) {
  const float place[3] = {0, 0, 0};
  return room.light_at(place);
}
bool takes(const cpp::Room& room, const sandglass_cube& cube, const char** reason = nullptr) {
  return sandglass_room_set_cube(room.get(), &cube, reason) == SANDGLASS_OK;
}

bool takes(const cpp::Room& room, const sandglass_harmonics& harmonics) {
  return sandglass_room_set_harmonics(room.get(), &harmonics, nullptr) == SANDGLASS_OK;
}

TEST(Probe, EveryFormatFindsTheLampAndItsColour) {
  for (int format = SANDGLASS_CUBE_RGBA8; format <= SANDGLASS_CUBE_RGBA32F; ++format) {
    SCOPED_TRACE(format);
    const cpp::Room room = room_with_probe();
    const bool bytes = format <= SANDGLASS_CUBE_BGRA8;
    Cube made = cube_of(lamp_room(k_lamp, 8, bytes ? 0.95 : 30, bytes ? 0.02 : 0.2), format, 32);
    ASSERT_TRUE(takes(room, made.cube));
    const sandglass_room_light light = light_of(room);
    EXPECT_EQ(light.valid, 1u);
    EXPECT_NEAR(light.seen, 1, 1e-6);
    EXPECT_LT(angle_deg(main_of(light), k_lamp), 4);
    EXPECT_NEAR(light.irradiance[0] / light.irradiance[1], 0.5, 0.02);
    EXPECT_NEAR(light.irradiance[2] / light.irradiance[1], 0.25, 0.02);
    // The lower row first, by a negative stride: the same cube.
    const uint64_t hash = room.hash();
    const size_t row = static_cast<size_t>(made.cube.stride), rows = made.cube.size;
    for (int face = 0; face < 6; ++face) {
      std::vector<uint8_t> turned;
      for (size_t y = rows; y-- > 0;)
        turned.insert(turned.end(), made.bytes[face].begin() + static_cast<std::ptrdiff_t>(y * row),
                      made.bytes[face].begin() + static_cast<std::ptrdiff_t>((y + 1) * row));
      made.bytes[face] = turned;
      made.cube.faces[face] = made.bytes[face].data() + (rows - 1) * row;
    }
    made.cube.stride = -made.cube.stride;
    ASSERT_TRUE(takes(room, made.cube));
    EXPECT_EQ(room.hash(), hash);
  }
}

// The test that a converter for a system must pass: a lamp on one side, and a cube as that system hands it over.
TEST(Probe, FrameAndHandednessAreThoseOfTheSampler) {
  const Radiance lit = lamp_room(k_lamp, 8, 30);
  const auto turned = [](Direction d) {  // the cube's frame is turned by 70 degrees about y
    const double c = std::cos(degrees(70)), s = std::sin(degrees(70));
    return Direction{c * d.x + s * d.z, d.y, c * d.z - s * d.x};
  };
  const auto left = [](Direction d) { return Direction{d.x, d.y, -d.z}; };
  Cube plain = cube_of(lit, SANDGLASS_CUBE_RGBA16F, 16), in_frame = cube_of(lit, SANDGLASS_CUBE_RGBA16F, 16, turned);
  Cube of_unity = cube_of(lit, SANDGLASS_CUBE_RGBA16F, 16, left);
  const auto off = [](const Cube& made) {
    const cpp::Room room = room_with_probe();
    EXPECT_TRUE(takes(room, made.cube));
    return angle_deg(main_of(light_of(room)), k_lamp);
  };
  EXPECT_LT(off(plain), 4);
  EXPECT_GT(off(in_frame), 30) << "the control: its frame left out";
  EXPECT_GT(off(of_unity), 30) << "the control: taken for right-handed";
  in_frame.cube.orientation[1] = static_cast<float>(std::sin(degrees(35)));
  in_frame.cube.orientation[3] = static_cast<float>(std::cos(degrees(35)));
  of_unity.cube.left_handed = 1;
  EXPECT_LT(off(in_frame), 4);
  EXPECT_LT(off(of_unity), 4);
}

// By the table that cubes are made from above, which is the specification's: the direction of every place of a texel leads
// to that texel, and turned around in z to that of a left-handed cube.
TEST(Probe, ADirectionLeadsToTheTexelOfTheTable) {
  constexpr int k_size = 8, k_places = 4;  // texels of a side; places of a texel's side
  std::vector<float> texels(3 * 6 * k_size * k_size);
  sandglass_cube cube = cpp::cube();
  cube.format = SANDGLASS_CUBE_RGB32F;
  cube.size = k_size;
  cube.stride = 12 * k_size;
  for (int i = 0; i < 6 * k_size * k_size; ++i) {
    texels[static_cast<size_t>(3 * i)] = static_cast<float>(i);
    cube.faces[i / (k_size * k_size)] = &texels[static_cast<size_t>(3 * (i - i % (k_size * k_size)))];
  }
  for (cube.left_handed = 0; cube.left_handed < 2; ++cube.left_handed)
    for (int i = 0; i < 6 * k_size * k_size * k_places * k_places; ++i) {
      constexpr int k_row = k_size * k_places;
      const int face = i / (k_row * k_row), row = i / k_row % k_row, column = i % k_row;
      const Direction d = face_direction(face, 2 * (column + 0.5) / k_row - 1, 2 * (row + 0.5) / k_row - 1);
      const double towards[3] = {d.x, d.y, cube.left_handed != 0 ? -d.z : d.z};
      double texel[3];
      (void)room_cube_texel(cube, towards, texel);
      ASSERT_EQ(texel[0], (face * k_size + row / k_places) * k_size + column / k_places);
    }
}

TEST(Probe, CameraImagesStayWhatTheyWereAndNullForgetsTheProbe) {
  const cpp::Room room = room_with_probe(), alone = room_with_probe();
  const Cube made = cube_of(lamp_room(towards(200, 60), 8, 30), SANDGLASS_CUBE_RGB32F, 16);
  for (int i = 0; i < 6; ++i) {
    const Photograph p =
        photograph(lamp_room(k_lamp, 8, 30), 20.0 * i, 10, 1, 1 + 200'000'000ull * static_cast<uint64_t>(i));
    ASSERT_EQ(sandglass_room_set_image(room.get(), &p.image, nullptr, nullptr), SANDGLASS_OK);
    ASSERT_EQ(sandglass_room_set_image(alone.get(), &p.image, nullptr, nullptr), SANDGLASS_OK);
    if (i == 2) {
      ASSERT_TRUE(takes(room, made.cube));
    }
  }
  EXPECT_GT(light_of(room).seen, light_of(alone).seen);
  EXPECT_NE(room.hash(), alone.hash());
  ASSERT_EQ(sandglass_room_set_cube(room.get(), nullptr, nullptr), SANDGLASS_OK);
  EXPECT_EQ(room.hash(), alone.hash());
  const sandglass_room_light a = light_of(room), b = light_of(alone);
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

// What is refused changes nothing that an app would draw again for.
TEST(Probe, TheVersionGrowsWithWhatIsTakenAlone) {
  const cpp::Room room = room_with_probe();
  const uint64_t& version = room.get()->version;
  auto grows = [&, before = version]() mutable { return std::exchange(before, version) != version; };
  Cube made = cube_of(lamp_room(k_lamp, 8, 30), SANDGLASS_CUBE_RGB32F, 16);
  const float tilted[4] = {0.1f, 0, 0, 0.995f}, turned[4] = {0, 0.6f, 0, 0.8f}, nowhere[3] = {};
  const Photograph p = photograph(lamp_room(k_lamp, 8, 30), 0, 10, 1, 1'000'000'000);
  ASSERT_EQ(sandglass_room_set_image(room.get(), &p.image, nullptr, nullptr), SANDGLASS_OK);
  EXPECT_TRUE(grows());
  int32_t taken = 1;
  ASSERT_EQ(sandglass_room_set_image(room.get(), &p.image, &taken, nullptr), SANDGLASS_OK);
  EXPECT_EQ(taken, 0);  // the same once more
  EXPECT_FALSE(grows());
  EXPECT_NE(sandglass_room_move(room.get(), tilted, nowhere, nullptr), SANDGLASS_OK);
  EXPECT_FALSE(grows());
  EXPECT_EQ(sandglass_room_move(room.get(), turned, nowhere, nullptr), SANDGLASS_OK);
  EXPECT_TRUE(grows());
  ASSERT_TRUE(takes(room, made.cube));
  EXPECT_TRUE(grows());
  made.cube.size = 2;
  EXPECT_NE(sandglass_room_set_cube(room.get(), &made.cube, nullptr), SANDGLASS_OK);
  EXPECT_FALSE(grows());
}

// Beside camera images a probe of unknown exposure takes their scale, and one of another white balance their hue.
TEST(Probe, ItsScaleAndBalanceAreFoundFromWhatBothShow) {
  const Radiance lit = lamp_room(k_lamp, 8, 30);
  // pi * 0.2 of the dim sphere, and the lamp's 30 within 8 degrees at 50 degrees above the floor
  const double lamp = (30 - 0.2) * std::numbers::pi * std::pow(std::sin(degrees(8)), 2) * std::sin(degrees(50));
  for (const double times : {1.0, 100.0})
    for (const double red : {0.8, 1.25}) {
      const cpp::Room room = room_with_probe();
      const Cube made = cube_of([&](Direction d) { return times * lit(d); }, SANDGLASS_CUBE_RGB32F, 16, same, red);
      const Photograph p = photograph(lit, 220, -35, 1, 1);  // grey
      ASSERT_EQ(sandglass_room_set_image(room.get(), &p.image, nullptr, nullptr), SANDGLASS_OK);
      ASSERT_TRUE(takes(room, made.cube));
      const sandglass_room_light light = light_of(room);
      EXPECT_NEAR(light.irradiance[1] / (0.2 * std::numbers::pi + lamp), 1, 0.15) << times;
      EXPECT_NEAR(light.irradiance[0] / light.irradiance[1], 1, 0.05) << red;
    }
}

// A cube that is mirrored, or turned by quarters, is told once the camera has looked around a little.
TEST(Probe, ItsFitTellsAMirroredOrTurnedCube) {
  const Radiance lit = [](Direction d) {
    return 0.3 + 0.2 * d.x + 0.12 * std::sin(3 * d.z + 1) + (d.y < 0 ? -0.05 : 0);
  };
  for (uint32_t variant = 0; variant < 8; ++variant) {
    const cpp::Room room = room_with_probe();
    for (int i = 0; i < 6; ++i) {
      const Photograph p = photograph(lit, 30.0 * i, 0, 1, 1 + 200'000'000ull * static_cast<uint64_t>(i));
      ASSERT_EQ(sandglass_room_set_image(room.get(), &p.image, nullptr, nullptr), SANDGLASS_OK);
    }
    const auto wrong = [variant](Direction d) {
      const double turns[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};  // cosine and sine
      const double c = turns[variant % 4][0], s = turns[variant % 4][1], z = variant < 4 ? d.z : -d.z;
      return Direction{c * d.x - s * z, d.y, c * z + s * d.x};
    };
    const Cube made = cube_of(lit, SANDGLASS_CUBE_RGB32F, 16, wrong);
    uint32_t turn_deg = 7;
    int32_t mirrored = 7;
    EXPECT_EQ(sandglass_room_probe_fit(room.get(), &turn_deg, &mirrored), 0) << "there is none yet";
    EXPECT_EQ(turn_deg, 7u);
    ASSERT_TRUE(takes(room, made.cube));
    ASSERT_EQ(sandglass_room_probe_fit(room.get(), &turn_deg, &mirrored), 1);
    EXPECT_EQ(mirrored, variant < 4 ? 0 : 1) << variant;
    EXPECT_EQ(turn_deg == 0 && mirrored == 0, variant == 0) << variant;
  }
}

// The nine numbers of what a room expects from its parts, each of them even.
std::array<double, 27> harmonics_of_parts(const sandglass_room& room) {
  constexpr uint32_t k_fine = 4;  // along each side of a part
  static float parts[k_room_parts][3];
  room_radiance(room.room, k_room_model, parts);
  std::array<double, 27> sums = {};
  for (uint32_t i = 0; i < k_room_parts * k_fine * k_fine; ++i) {
    const uint32_t part = i / (k_fine * k_fine), column = part % k_room_columns, row = part / k_room_columns;
    double d[3], y[k_harmonics];
    room_direction(row + (i / k_fine % k_fine + 0.5) / k_fine, column + (i % k_fine + 0.5) / k_fine, d);
    harmonic_polynomials(d, y);
    const double area =
        2 * std::numbers::pi * std::numbers::pi * std::sqrt(1 - d[1] * d[1]) / (k_room_parts * k_fine * k_fine);
    for (size_t k = 0; k < 27; ++k)
      sums[k] += area * k_harmonic_factors[k / 3] * y[k / 3] * static_cast<double>(parts[part][k % 3]);
  }
  return sums;
}

TEST(Probe, HarmonicsComeBackAndTheMainLightWithThem) {
  const float dim = 0.2f, irradiance = 2.0f;
  sandglass_harmonics h;
  sandglass_harmonics_default(&h);
  h.kind = SANDGLASS_HARMONICS_AMBIENT;
  const double toward[3] = {k_lamp.x, k_lamp.y, k_lamp.z};
  for (int c = 0; c < 3; ++c) {
    h.main_direction[c] = static_cast<float>(toward[c]);
    h.sh[c] = dim / 0.282095f;
    h.main_irradiance[c] = irradiance;
  }
  const cpp::Room room = room_with_probe();
  ASSERT_EQ(sandglass_room_set_harmonics(room.get(), &h, nullptr), SANDGLASS_OK);
  const sandglass_room_light light = light_of(room);
  EXPECT_LT(angle_deg(main_of(light), k_lamp), 3);
  const double floor = dim * std::numbers::pi + irradiance * k_lamp.y;
  EXPECT_NEAR(light.irradiance[1] / floor, 1, 0.03);
  EXPECT_NEAR(light.main_share, irradiance * k_lamp.y / floor, 0.15);
  // All of it as nine numbers: greatest entropy brings back the nine numbers, as the sum over its parts.
  sandglass_harmonics total;
  sandglass_harmonics_default(&total);
  std::memcpy(total.sh, light.sh, sizeof total.sh);
  const cpp::Room other = room_with_probe();
  ASSERT_EQ(sandglass_room_set_harmonics(other.get(), &total, nullptr), SANDGLASS_OK);
  const sandglass_room_light again = light_of(other);
  const std::array<double, 27> back = harmonics_of_parts(*other.get());
  for (size_t i = 0; i < 27; ++i) EXPECT_NEAR(back[i], light.sh[i], 0.05 * light.sh[0]) << i;
  // With the Condon-Shortley phase: the same where that is told; else, the control, the light comes from elsewhere.
  for (const int j : {1, 3, 5, 7})
    for (int c = 0; c < 3; ++c) total.sh[3 * j + c] *= -1;
  ASSERT_EQ(sandglass_room_set_harmonics(other.get(), &total, nullptr), SANDGLASS_OK);
  EXPECT_LT(light_of(other).irradiance[1], 0.8f * again.irradiance[1]);
  total.with_phase = 1;
  ASSERT_EQ(sandglass_room_set_harmonics(other.get(), &total, nullptr), SANDGLASS_OK);
  EXPECT_EQ(light_of(other).irradiance[1], again.irradiance[1]);
}

// The main light that is told is far: at every place it comes from there, also from the zenith, with all of its light
// (a lamp at `radius` would be seen 18 degrees off from 1 m away, and the middle of a part lies 5.6 beside the zenith),
// from a room that is saved and turned, too. What the camera has seen there is the camera's.
TEST(Probe, TheMainLightBesideHarmonicsIsFar) {
  for (const Direction to : {Direction{0, 1, 0}, k_lamp, towards(200, 20)}) {
    sandglass_harmonics h = cpp::harmonics();
    h.kind = SANDGLASS_HARMONICS_AMBIENT;
    const double toward[3] = {to.x, to.y, to.z}, ambient = 0.5;
    for (int c = 0; c < 3; ++c) {
      h.main_direction[c] = static_cast<float>(toward[c]);
      h.sh[c] = static_cast<float>(ambient / 0.282095);
      h.main_irradiance[c] = 1.5f;
    }
    cpp::Room room = room_with_probe(), restored = room_with_probe();
    ASSERT_TRUE(takes(room, h));
    std::vector<std::byte> saved;
    ASSERT_TRUE(room.save(&saved));
    ASSERT_TRUE(restored.restore(saved));
    EXPECT_EQ(restored.hash(), room.hash());
    for (const cpp::Room* of : {&room, &restored})
      for (const float x : {0.0f, 1.0f, 2.0f}) {
        const float place[3] = {x, 0, 0};
        const sandglass_room_light light = of->light_at(place);
        EXPECT_LT(angle_deg(main_of(light), to), 0.5) << x;
        EXPECT_NEAR(light.main_share * light.irradiance[1], 1.5 * to.y, 0.03 * 1.5) << x;
        EXPECT_NEAR(light.irradiance[1], ambient * std::numbers::pi + 1.5 * to.y, 0.03) << x;
        EXPECT_EQ(light.valid, 1u);
      }
    const float quarter[4] = {0, std::numbers::sqrt2_v<float> / 2, 0, std::numbers::sqrt2_v<float> / 2}, none[3] = {};
    ASSERT_EQ(sandglass_room_move(room.get(), quarter, none, nullptr), SANDGLASS_OK);
    EXPECT_LT(angle_deg(main_of(light_of(room)), Direction{to.z, to.y, -to.x}), 0.5);
    // A camera that looks around and sees no lamp.
    for (int i = 0; i < 36; ++i) {
      const Photograph dark = photograph([&](Direction) { return ambient; }, 30 * i,
                                         i < 12   ? 10
                                         : i < 24 ? 50
                                                  : 85,
                                         1, static_cast<uint64_t>(i + 1) * 200'000'000);
      int32_t taken = 0;
      ASSERT_EQ(sandglass_room_set_image(room.get(), &dark.image, &taken, nullptr), SANDGLASS_OK);
    }
    EXPECT_LT(light_of(room).main_share, 0.02f);
  }
}

// In work units of a frame, as in one call: the same bytes, and the governor knows of them.
TEST(Probe, AFrameReadsItInUnits) {
  const cpp::Room whole = room_with_probe(), in_units = room_with_probe();
  Cube made = cube_of(lamp_room(k_lamp, 8, 30), SANDGLASS_CUBE_RGBA16F, 16);
  sandglass_harmonics h;
  sandglass_harmonics_default(&h);
  for (int i = 0; i < 27; ++i) h.sh[i] = i < 3 ? 1.0f : 0.1f;
  cpp::Scene scene;
  ASSERT_TRUE(scene.create(cpp::scene_desc()));
  for (const bool cube : {true, false}) {
    made.cube.in_frame = h.in_frame = 0;
    ASSERT_TRUE(cube ? takes(whole, made.cube) : takes(whole, h));
    made.cube.in_frame = h.in_frame = 1;
    ASSERT_TRUE(cube ? takes(in_units, made.cube) : takes(in_units, h));
    EXPECT_NE(whole.hash(), in_units.hash()) << "not yet";
    sandglass_frame_input input = cpp::frame_input();
    input.room = in_units.get();
    input.time_step = 1.0f / 60;
    sandglass_frame_report report = cpp::frame_report();
    ASSERT_TRUE(scene.frame(input, &report));
    EXPECT_GE(report.stages[SANDGLASS_STAGE_LIGHT].units, 16u);
    EXPECT_EQ(whole.hash(), in_units.hash());
    // One that is believed nothing ends one under way.
    ASSERT_TRUE(takes(in_units, made.cube));
    sandglass_cube nothing = made.cube;
    nothing.confidence = 0;
    ASSERT_TRUE(takes(in_units, nothing));
    ASSERT_TRUE(scene.frame(input, &report));
    EXPECT_EQ(report.stages[SANDGLASS_STAGE_LIGHT].units, 0u);
    EXPECT_EQ(light_of(in_units).valid, 0u);
  }
}

TEST(Probe, ASavedRoomKeepsIt) {
  const cpp::Room room = room_with_probe();
  ASSERT_TRUE(takes(room, cube_of(lamp_room(k_lamp, 8, 30), SANDGLASS_CUBE_RGBA16F, 16).cube));
  std::vector<std::byte> saved;
  ASSERT_TRUE(room.save(&saved));
  cpp::Room other = room_with_probe(), without;
  ASSERT_TRUE(without.create());
  ASSERT_TRUE(other.restore(saved));
  EXPECT_EQ(other.hash(), room.hash());
  const sandglass_room_light a = light_of(room), b = light_of(other);
  EXPECT_EQ(a.irradiance[1], b.irradiance[1]);
  EXPECT_EQ(std::memcmp(a.cells, b.cells, sizeof a.cells), 0);
  ASSERT_TRUE(without.restore(saved)) << "a room that keeps no probe takes the rest";
}

TEST(Probe, WhatIsNoCubeIsRefused) {
  const cpp::Room room = room_with_probe();
  const Cube made = cube_of(lamp_room(k_lamp, 8, 30), SANDGLASS_CUBE_RGB32F, 16);
  const auto refused = [&](const std::function<void(sandglass_cube*)>& spoil) {
    sandglass_cube cube = made.cube;
    spoil(&cube);
    const char* reason = nullptr;
    return !takes(room, cube, &reason) && reason != nullptr;
  };
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->struct_size = 0; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->format = 9; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->size = 2; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->stride = 12; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->stride = -12; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->faces[3] = nullptr; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->orientation[3] = 0; }));
  EXPECT_TRUE(refused([](sandglass_cube* c) { c->confidence = 2; }));
  EXPECT_FALSE(refused([](sandglass_cube*) {}));
  cpp::Room without;
  ASSERT_TRUE(without.create());
  const char* reason = nullptr;
  EXPECT_FALSE(takes(without, made.cube, &reason));
  EXPECT_NE(std::string(reason).find("desc.probe"), std::string::npos);
  // Numbers of a texture that are none do no harm.
  Cube odd = made;
  for (int face = 0; face < 6; ++face) {
    const float bad[3] = {NAN, INFINITY, -1};
    std::memcpy(odd.bytes[face].data(), bad, sizeof bad);
    odd.cube.faces[face] = odd.bytes[face].data();
  }
  ASSERT_TRUE(takes(room, odd.cube));
  for (const float q : light_of(room).cells) EXPECT_TRUE(std::isfinite(q));
}

// One texel of 6144 that no cube can hold: the room's light stays what it is, to what that texel's part may add, and it
// says that it is clipped. As a number of 65000 it would be 200 times as bright, which the control shows.
TEST(Probe, ATexelBeyondTheRangeIsClampedAndSaid) {
  const auto lit = [](float value, sandglass_cube_format format) {
    const cpp::Room room = room_with_probe();
    Cube made = cube_of(lamp_room(k_lamp, 8, 30), format, 32);
    uint8_t* texel = made.bytes[2].data() + 10 * static_cast<uint32_t>(made.cube.stride);
    const uint16_t half = std::isinf(value) ? 0x7c00 : std::isnan(value) ? 0x7e01 : half_of(value);
    for (size_t c = 0; c < 3; ++c) {
      if (format == SANDGLASS_CUBE_RGBA16F) std::memcpy(texel + 8 * 20 + 2 * c, &half, 2);
      else std::memcpy(texel + 12 * 20 + 4 * c, &value, 4);
    }
    EXPECT_TRUE(takes(room, made.cube));
    return light_of(room);
  };
  for (const sandglass_cube_format format : {SANDGLASS_CUBE_RGB32F, SANDGLASS_CUBE_RGBA16F}) {
    const sandglass_room_light as_it_is = lit(0.2f, format);
    EXPECT_EQ(as_it_is.clipped, 0);
    for (const float beyond : {INFINITY, 65504.0f, 1e30f}) {
      if (format == SANDGLASS_CUBE_RGBA16F && beyond > 1e6f && !std::isinf(beyond)) continue;
      const sandglass_room_light light = lit(beyond, format);
      EXPECT_NEAR(light.irradiance[1] / as_it_is.irradiance[1], 1, 0.03) << beyond;
      EXPECT_NEAR(light.main_share, as_it_is.main_share, 0.03) << beyond;
      EXPECT_LT(angle_deg(main_of(light), main_of(as_it_is)), 2) << beyond;
      EXPECT_GT(light.clipped, 0) << beyond;
    }
    EXPECT_NEAR(lit(NAN, format).irradiance[1] / as_it_is.irradiance[1], 1, 0.01);
    EXPECT_GT(lit(64000, format).irradiance[1] / as_it_is.irradiance[1], 20) << "a number that may be told";
  }
  // None at all, and the room is what it was without.
  const cpp::Room room = room_with_probe();
  for (const float value : {NAN, INFINITY}) {
    Cube none = cube_of(lamp_room(k_lamp, 8, 30), SANDGLASS_CUBE_RGB32F, 16);
    for (auto& face : none.bytes)
      for (size_t at = 0; at + 4 <= face.size(); at += 4) std::memcpy(face.data() + at, &value, 4);
    const char* reason = nullptr;
    EXPECT_FALSE(takes(room, none.cube, &reason));
    EXPECT_NE(std::string(reason).find("no texel"), std::string::npos);
    EXPECT_EQ(light_of(room).irradiance[1], light_of(room_with_probe()).irradiance[1]);
    Cube black = cube_of([](Direction) { return 0.0; }, SANDGLASS_CUBE_RGB32F, 16);
    EXPECT_TRUE(takes(room, black.cube)) << "the control: a dark room is one";
  }
}

}  // namespace
}  // namespace sandglass
