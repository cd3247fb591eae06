// A room as bytes: the restored one answers as the saved one did, and bytes from anywhere harm nothing.
#include <cstring>
#include <string>

#include "made_up_room.h"
#include "runtime/core/hash.h"
#include "runtime/core/random.h"

namespace sandglass {
namespace {

struct alignas(8) Word {
  uint8_t bytes[8];
};

struct Saved {
  std::vector<Word> words;
  uint64_t bytes = 0;
  uint8_t* data() { return words[0].bytes; }
};

Saved save(const sandglass_room* room) {
  Saved saved;
  saved.bytes = sandglass_room_save_bytes(room);
  saved.words.resize((saved.bytes + 7) / 8);
  uint64_t written = 0;
  EXPECT_EQ(sandglass_room_save(room, saved.data(), saved.bytes, &written, nullptr), SANDGLASS_OK);
  EXPECT_EQ(written, saved.bytes);
  return saved;
}

// The checksum is FNV-1a over all that follows it, at byte 8.
void sign(Saved* saved) {
  const uint64_t sum = hash_bytes(saved->data() + 16, saved->bytes - 16);
  std::memcpy(saved->data() + 8, &sum, sizeof sum);
}

MadeUpRoom looked_around() {
  MadeUpRoom room(60.0f);
  for (int azimuth = 0; azimuth < 360; azimuth += 40)
    room.look(lamp_room(towards(50, 40), 6.0, 20.0), azimuth, 25, azimuth % 80 == 0 ? 0.5 : 0.02);
  return room;
}

TEST(RoomSave, TheRestoredRoomAnswersAlike) {
  const MadeUpRoom first = looked_around();
  Saved saved = save(first.handle());
  MadeUpRoom second(60.0f);
  second.look([](Direction) { return 0.7; }, 0, 0);  // forgotten by restoring
  ASSERT_EQ(sandglass_room_restore(second.handle(), saved.data(), saved.bytes, nullptr), SANDGLASS_OK);
  EXPECT_EQ(sandglass_room_hash(first.handle()), sandglass_room_hash(second.handle()));
  const sandglass_room_light a = first.light(1, 0, 0), b = second.light(1, 0, 0);
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

TEST(RoomSave, EveryDamagedByteIsRefusedAndChangesNothing) {
  const MadeUpRoom first = looked_around();
  const Saved saved = save(first.handle());
  MadeUpRoom room;
  const uint64_t before = sandglass_room_hash(room.handle());
  for (uint64_t at = 0; at < saved.bytes; at += at < 256 ? 1 : 97) {
    Saved damaged = saved;
    damaged.data()[at] ^= 0x40;
    const char* reason = nullptr;
    ASSERT_EQ(sandglass_room_restore(room.handle(), damaged.data(), damaged.bytes, &reason),
              SANDGLASS_ERROR_INVALID_ARGUMENT)
        << at;
    ASSERT_NE(reason, nullptr);
  }
  for (const uint64_t bytes : {uint64_t{0}, uint64_t{15}, saved.bytes - 1, saved.bytes + 1}) {
    Saved cut = saved;
    cut.words.resize(saved.words.size() + 1);
    EXPECT_EQ(sandglass_room_restore(room.handle(), cut.data(), bytes, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  }
  EXPECT_EQ(sandglass_room_hash(room.handle()), before);
}

// Forged numbers behind a right checksum: refused, or a room whose every answer is finite.
TEST(RoomSave, ForgedNumbersNeverBreakAnAnswer) {
  const MadeUpRoom first = looked_around();
  const Saved saved = save(first.handle());
  Random random = random_stream(7, 7);
  const float numbers[] = {NAN, INFINITY, -1.0f, 1e30f, 1e-30f, 0.0f, 3.0f};
  int restored = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Saved forged = saved;
    for (uint32_t n = 1 + random.below(3); n > 0; --n) {
      const uint64_t at = 16 + 4 * random.below(static_cast<uint32_t>((saved.bytes - 16) / 4));
      const float number = numbers[random.below(7)];
      std::memcpy(forged.data() + at, &number, sizeof number);
    }
    sign(&forged);
    MadeUpRoom room;
    if (sandglass_room_restore(room.handle(), forged.data(), forged.bytes, nullptr) != SANDGLASS_OK) {
      ++refused;
      continue;
    }
    ++restored;
    room.look([](Direction) { return 0.5; }, 0, 0, 1.0, i % 2 == 0);
    const sandglass_room_light light = room.light(1, 0, 0);
    for (const float c : light.cells) ASSERT_TRUE(std::isfinite(c) && c >= 0.0f);
    for (const float c : light.sh) ASSERT_TRUE(std::isfinite(c));
    for (const float c : light.irradiance) ASSERT_TRUE(std::isfinite(c));
  }
  EXPECT_GT(refused, 200);
  EXPECT_GT(restored, 200);
}

}  // namespace
}  // namespace sandglass
