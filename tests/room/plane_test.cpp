// The light of other planes than the floor: their cells, main light and irradiance.
#include <array>
#include <cstring>

#include "tests/reason.h"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

constexpr uint32_t k_sectors = 16;

sandglass_room_place place_on(const float* normal, const float* along) {
  sandglass_room_place place;
  sandglass_room_place_default(&place);
  place.normal = normal;
  place.along = along;
  return place;
}

sandglass_room_light light_of(const MadeUpRoom& room, const float* normal, const float* along) {
  sandglass_room_light out = {};
  out.struct_size = sizeof out;
  const sandglass_room_place place = place_on(normal, along);
  EXPECT_EQ(sandglass_room_get(room.handle(), &place, &out, nullptr), SANDGLASS_OK);
  return out;
}

double uneven(Direction d) { return 0.2 + 0.3 * std::pow(std::max(0.0, cosine(d, towards(40, 50))), 6) + 0.1 * d.x; }

TEST(RoomPlane, ALevelOneIsTheFloor) {
  MadeUpRoom room;
  room.look_everywhere(uneven);
  const sandglass_room_light floor = room.light();
  const float up[3] = {0, 2, 0};
  const sandglass_room_light plane = light_of(room, up, nullptr);
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) EXPECT_NEAR(plane.cells[i], floor.cells[i], 1e-6) << i;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(plane.irradiance[c], floor.irradiance[c], 1e-5);
  EXPECT_EQ(std::memcmp(plane.sh, floor.sh, sizeof plane.sh), 0);
}

// `along` two sectors on, from +x to +z: what was in a sector is two sectors before.
TEST(RoomPlane, CellsCountFromAlong) {
  MadeUpRoom room;
  room.look_everywhere(uneven);
  const sandglass_room_light floor = room.light();
  const Direction d = towards(45, 0);
  const float up[3] = {0, 1, 0}, along[3] = {static_cast<float>(d.x), 0.3f, static_cast<float>(d.z)};
  const sandglass_room_light plane = light_of(room, up, along);
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) {
    const uint32_t from = i / k_sectors * k_sectors + (i + 2) % k_sectors;
    EXPECT_NEAR(plane.cells[i], floor.cells[from], 1e-5) << i;
  }
}

// An even room gives every plane pi L, from all cells alike.
TEST(RoomPlane, AnEvenRoomIsEvenFromAnyPlane) {
  MadeUpRoom room;
  room.look_everywhere([](Direction) { return 0.3; });
  for (const std::array<float, 3>& normal : {std::array<float, 3>{1, 0, 0}, {0, -1, 0}, {-0.6f, 0.3f, 0.8f}}) {
    const float along[3] = {0.1f, 0.2f, 1};
    const sandglass_room_light plane = light_of(room, normal.data(), along);
    for (const float cell : plane.cells) EXPECT_NEAR(cell, 1.0 / SANDGLASS_LIGHT_CELLS, 2e-3);
    EXPECT_NEAR(plane.irradiance[1], std::numbers::pi * 0.3, 0.02);
    EXPECT_LT(plane.main_share, 0.02);
  }
}

// A bright cap of 30 degrees to each side at the height of the eye, which parts of 11 degrees resolve: a wall across from it
// gets it from its zenith, and the wall on its own side nothing.
TEST(RoomPlane, AWallGetsWhatItFaces) {
  constexpr double k_half = 30, k_lamp = 0.95, k_dim = 0.02;
  MadeUpRoom room;
  const Direction lamp = towards(0, 0);
  room.look_everywhere(lamp_room(lamp, k_half, k_lamp, k_dim));
  const float towards_it[3] = {1, 0, 0}, away[3] = {-1, 0, 0}, along[3] = {0, 0, 1};
  const sandglass_room_light facing = light_of(room, towards_it, along), behind = light_of(room, away, along);
  // The integral of the cosine over a cap of half angle a about the normal is pi sin^2 a.
  const double sine = std::sin(degrees(k_half)), expected = std::numbers::pi * (k_dim + (k_lamp - k_dim) * sine * sine);
  EXPECT_NEAR(facing.irradiance[1] / expected, 1, 0.05);
  EXPECT_NEAR(behind.irradiance[1] / (std::numbers::pi * k_dim), 1, 0.15);
  MadeUpRoom other;
  other.look_everywhere(lamp_room(lamp, 12, k_lamp, k_dim));
  const sandglass_room_light small = light_of(other, towards_it, along);
  EXPECT_GT(small.main_share, 0.4f);
  EXPECT_LT(angle_deg({small.main_direction[0], small.main_direction[1], small.main_direction[2]}, lamp), 3);
  EXPECT_LT(behind.main_share, 0.05f);
  double top = 0;
  for (uint32_t i = 3 * k_sectors; i < SANDGLASS_LIGHT_CELLS; ++i) top += static_cast<double>(facing.cells[i]);
  EXPECT_GT(top, 0.6);
}

TEST(RoomPlane, RefusesPlanesWithoutADirection) {
  const MadeUpRoom room;
  const float none[3] = {0, 0, 0}, up[3] = {0, 1, 0}, x[3] = {1, 0, 0};
  const auto refused = [&](const char* words, const float* normal, const float* along) {
    sandglass_room_light out = {};
    out.struct_size = sizeof out;
    const sandglass_room_place place = place_on(normal, along);
    tests::expect_refused(words,
                          [&](const char** reason) { return sandglass_room_get(room.handle(), &place, &out, reason); });
  };
  refused("zero", none, nullptr);
  refused("along its normal", up, up);
  refused("without a normal", nullptr, x);
  refused("along its normal", x, nullptr);  // the default, +x
}

}  // namespace
}  // namespace sandglass
