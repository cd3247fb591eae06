// What a shiny object reflects: the faces show what the camera saw where a sampler looks it up, in a plain made-up room.
#include <array>
#include <string>

#include "tests/reason.h"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

constexpr uint32_t k_size = SANDGLASS_ROOM_CUBE_SIZE;

using Face = std::array<uint16_t, 4 * k_size * k_size>;

double from_half(uint16_t h) {
  const int exponent = h >> 10 & 31, mantissa = h & 1023;
  return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
}

struct Cube {
  std::array<Face, 6> faces;

  explicit Cube(const MadeUpRoom& room, std::array<float, 3> position = {0, 0, 0}, bool left_handed = false,
                float height = 0) {
    for (uint32_t f = 0; f < 6; ++f)
      EXPECT_EQ(sandglass_room_get_cube(room.handle(), position.data(), height, f, left_handed ? 1 : 0, faces[f].data(),
                                        nullptr),
                SANDGLASS_OK);
  }
  double at(uint32_t face, uint32_t row, uint32_t column, uint32_t channel) const {
    return from_half(faces[face][4 * (row * k_size + column) + channel]);
  }
};

// By the table of section 8.13 of the specification of OpenGL 4.6: (sc, tc, ma) of each face, turned around.
Direction direction_of(uint32_t face, uint32_t row, uint32_t column) {
  const double sc = 2 * (column + 0.5) / k_size - 1, tc = 2 * (row + 0.5) / k_size - 1;
  const Direction of_faces[6] = {{1, -tc, -sc}, {-1, -tc, sc}, {sc, 1, tc},
                                 {sc, -1, -tc}, {sc, -tc, 1},  {-sc, -tc, -1}};
  const Direction d = of_faces[face];
  const double n = std::sqrt(1 + sc * sc + tc * tc);
  return {d.x / n, d.y / n, d.z / n};
}

// No two axes alike, and nothing clipped.
double slanted(Direction d) { return 0.4 + 0.25 * d.x + 0.1 * d.y - 0.05 * d.z + 0.1 * d.x * d.z; }

double rmse_of(const Cube& cube, const Radiance& truth) {
  double squares = 0;
  for (uint32_t f = 0; f < 6; ++f)
    for (uint32_t i = 0; i < k_size * k_size; ++i) {
      const double off = cube.at(f, i / k_size, i % k_size, 1) - truth(direction_of(f, i / k_size, i % k_size));
      squares += off * off / (6 * k_size * k_size);
    }
  return std::sqrt(squares);
}

MadeUpRoom room_with_reflections() { return MadeUpRoom(1e6f, false, true); }

TEST(RoomReflections, ShowWhatASamplerLooksUp) {
  MadeUpRoom room = room_with_reflections();
  room.look_everywhere(slanted);
  const Cube cube(room);
  // A step of a byte is 1 / 255 of sRGB, which is at most 0.0082 of linear light, evenly spread: 0.0024. Nothing of a
  // smooth room is between the points of a texel.
  EXPECT_LT(rmse_of(cube, slanted), 0.003);
  for (uint32_t f = 0; f < 6; ++f) EXPECT_EQ(cube.at(f, 16, 16, 3), 1) << f;
  EXPECT_GT(rmse_of(cube, [](Direction d) { return slanted({-d.x, d.y, d.z}); }), 0.1);  // a control
}

TEST(RoomReflections, OfALeftHandedEngineHaveZReversed) {
  MadeUpRoom room = room_with_reflections();
  room.look_everywhere(slanted);
  const Cube cube(room, {0, 0, 0}, true);
  EXPECT_LT(rmse_of(cube, [](Direction d) { return slanted({d.x, d.y, -d.z}); }), 0.003);
}

TEST(RoomReflections, AreExpectedLightWhereNothingWasSeen) {
  MadeUpRoom room = room_with_reflections();
  const Cube before(room);
  EXPECT_EQ(before.at(0, 16, 16, 3), 0);
  EXPECT_GT(before.at(0, 16, 16, 1), 0);
  room.look([](Direction) { return 0.3; }, 0, 0);  // towards +x
  const Cube after(room);
  EXPECT_EQ(after.at(0, 16, 16, 3), 1);
  EXPECT_NEAR(after.at(0, 16, 16, 1), 0.3, 0.004);
  EXPECT_EQ(after.at(1, 16, 16, 3), 0);  // behind
  EXPECT_GT(after.at(1, 16, 16, 1), 0);
}

// The room's walls count as 3 m away. A lamp towards +x, seen from 1.5 m towards +z, lies at an angle of atan 1/2.
TEST(RoomReflections, MoveWithTheObject) {
  MadeUpRoom room = room_with_reflections();
  room.look_everywhere(lamp_room({1, 0, 0}, 6, 0.9));
  const Cube cube(room, {0, 0, 1.5f});
  Direction brightest = {};
  double weight = 0;
  for (uint32_t f = 0; f < 6; ++f)
    for (uint32_t i = 0; i < k_size * k_size; ++i) {
      if (cube.at(f, i / k_size, i % k_size, 1) < 0.55) continue;
      const Direction d = direction_of(f, i / k_size, i % k_size);
      brightest = {brightest.x + d.x, brightest.y + d.y, brightest.z + d.z};
      weight += 1;
    }
  ASSERT_GT(weight, 4);
  const double a = std::atan(0.5), n = std::sqrt(cosine(brightest, brightest));
  // A texel's width is 3.6 degrees in the middle of a face.
  EXPECT_LT(angle_deg({brightest.x / n, brightest.y / n, brightest.z / n}, {std::cos(a), 0, -std::sin(a)}), 1.8);
}

// A floor 1.2 m below the camera, white where x > 1 m. From 0.3 m above x = 1 one half of what lies below is white; as far
// away as the walls it would all be dark there.
TEST(RoomReflections, ShowTheFloorWhereItLies) {
  MadeUpRoom room = room_with_reflections();
  room.look_everywhere([](Direction d) { return d.y < 0 && d.x > -d.y / 1.2 ? 0.8 : 0.1; });
  const auto below = [&](float height, uint32_t column) {
    return Cube(room, {1, -0.9f, 0}, false, height).at(3, 16, column, 1);
  };
  // Texels 16 +- 9 of 32 look 0.59 aside for 1 down: 0.18 m from x = 1, which is 5 degrees of what the camera saw.
  EXPECT_GT(below(0.3f, 25), 0.7);
  EXPECT_LT(below(0.3f, 6), 0.15);
  EXPECT_LT(below(0, 25), 0.2);
}

TEST(RoomReflections, TellALampFromShortExposures) {
  MadeUpRoom room = room_with_reflections();
  const Radiance lamp = lamp_room({1, 0, 0}, 8, 30, 0.2);
  room.look_everywhere(lamp);
  for (int i = 0; i < 3; ++i) room.look(lamp, 0, 0, 1.0 / 64);
  room.look(lamp, 90, 0);  // the white of the last image is 1 again
  EXPECT_NEAR(Cube(room).at(0, 16, 16, 1), 30, 1.5);
  EXPECT_NEAR(Cube(room).at(1, 16, 16, 1), 0.2, 0.004);
}

TEST(RoomReflections, AreOnlyOfARoomThatKeepsThem) {
  MadeUpRoom without, room = room_with_reflections();
  Face face;
  const float origin[3] = {0, 0, 0}, nowhere[3] = {0, std::nanf(""), 0};
  const auto refused = [&](const char* words, const MadeUpRoom& of, const float position[3], uint32_t f, uint32_t left,
                           float height = 0) {
    face.fill(7);
    tests::expect_refused(words, [&](const char** reason) {
      return sandglass_room_get_cube(of.handle(), position, height, f, left, face.data(), reason);
    });
    for (const uint16_t h : face) ASSERT_EQ(h, 7);
  };
  refused("desc.reflections", without, origin, 0, 0);
  refused("face", room, origin, 6, 0);
  refused("left_handed", room, origin, 0, 2);
  refused("position", room, nowhere, 0, 0);
  refused("height", room, origin, 0, 0, -0.1f);
}

}  // namespace
}  // namespace sandglass
