// A room as bytes: the restored one answers as the saved one did, and damaged bytes change nothing. (Forged ones:
// tests/fuzz/saved_room.cpp.)
#include <cstring>
#include <string>

#include "tests/damaged_file.h"
#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

std::vector<std::byte> save(const MadeUpRoom& room) {
  std::vector<std::byte> saved;
  EXPECT_TRUE(room.save(&saved));
  return saved;
}

MadeUpRoom looked_around() {
  MadeUpRoom room(60.0f);
  for (int azimuth = 0; azimuth < 360; azimuth += 40)
    room.look(lamp_room(towards(50, 40), 6.0, 20.0), azimuth, 25, azimuth % 80 == 0 ? 0.5 : 0.02);
  return room;
}

TEST(RoomSave, TheRestoredRoomAnswersAlike) {
  const MadeUpRoom first = looked_around();
  const std::vector<std::byte> saved = save(first);
  MadeUpRoom second(60.0f);
  second.look([](Direction) { return 0.7; }, 0, 0);  // forgotten by restoring
  ASSERT_TRUE(second.restore(saved));
  EXPECT_EQ(sandglass_room_hash(first.handle()), sandglass_room_hash(second.handle()));
  sandglass_room_light a = first.light(1, 0, 0), b = second.light(1, 0, 0);
  EXPECT_NE(a.unit, b.unit);
  b.unit = a.unit;
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

// A sphere that has grown, because the camera has left it, is restored; after a reset it is as large as ever.
TEST(RoomSave, AGrownSphereIsRestoredAndResetToItsFirstSize) {
  MadeUpRoom first, second, fresh;
  const Radiance lit = lamp_room(towards(50, 40), 6.0, 20.0);
  Photograph p = photograph(lit, 50, 40, 1, 1);
  p.image.position[0] = 4;
  first.look(lit, 50, 40);
  ASSERT_EQ(sandglass_room_set_image(first.handle(), &p.image, nullptr, nullptr), SANDGLASS_OK);
  const std::vector<std::byte> saved = save(first);
  ASSERT_TRUE(second.restore(saved));
  EXPECT_EQ(second.light(2, 0, 0).main_direction[0], first.light(2, 0, 0).main_direction[0]);
  for (MadeUpRoom* room : {&second, &fresh}) {
    sandglass_room_reset(room->handle());
    room->look(lit, 50, 40);
  }
  EXPECT_NE(fresh.light(2, 0, 0).main_direction[0], first.light(2, 0, 0).main_direction[0]) << "the control";
  EXPECT_EQ(second.light(2, 0, 0).main_direction[0], fresh.light(2, 0, 0).main_direction[0]);
}

TEST(RoomSave, DamagedBytesAreRefusedAndChangeNothing) {
  const std::vector<std::byte> saved = save(looked_around());
  MadeUpRoom room;
  const uint64_t before = sandglass_room_hash(room.handle());
  const auto take = [&](const std::vector<uint8_t>& bytes) {
    const char* reason = nullptr;
    const sandglass_status status = sandglass_room_restore(room.handle(), bytes.data(), bytes.size(), &reason);
    if (status == SANDGLASS_OK) return true;
    EXPECT_EQ(status, SANDGLASS_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(reason, nullptr);
    EXPECT_EQ(sandglass_room_hash(room.handle()), before);
    return false;
  };
  const auto* first = reinterpret_cast<const uint8_t*>(saved.data());
  std::vector<uint8_t> bytes(first, first + saved.size());
  bytes.push_back(0);
  EXPECT_FALSE(take(bytes));
  bytes.pop_back();
  tests::expect_only_whole_taken(bytes, take, 300);
}

}  // namespace
}  // namespace sandglass
