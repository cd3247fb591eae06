// A saved room with a right checksum and wrong content: it is refused, or it answers with finite numbers.
#include <cstring>

#include "runtime/math/hash.h"
#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"
#include "tests/room/made_up_room.h"

namespace {

constexpr size_t k_checksum_at = 8, k_checked_from = 16;

std::vector<uint8_t> bytes_of(const sandglass_room* room) {
  std::vector<uint8_t> file(sandglass_room_save_bytes(room));
  uint64_t written;
  sandglass::fuzz::expect(sandglass_room_save(room, file.data(), file.size(), &written, nullptr) == SANDGLASS_OK);
  return file;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  static MadeUpRoom room(1e6f, true, true);
  static const std::vector<uint8_t> base = [] {
    for (int i = 0; i < 6; ++i) room.look(lamp_room(towards(30, 50), 8, 40), 60.0 * i, 10);
    static const std::vector<float> face(size_t{3} * 4 * 4, 0.5f);
    sandglass_cube cube = cpp::cube();
    cube.format = SANDGLASS_CUBE_RGB32F;
    cube.size = 4;
    cube.stride = 48;
    for (const void*& f : cube.faces) f = face.data();
    fuzz::expect(sandglass_room_set_cube(room.handle(), &cube, nullptr) == SANDGLASS_OK);
    return bytes_of(room.handle());
  }();
  std::vector<uint8_t> file = base;
  fuzz::apply_edits(data, size, &file);
  // Now and then its head is wrong as well, or it lies where none may.
  const bool repaired = size % 8 != 7, aligned_right = size % 8 != 6;
  if (repaired && file.size() > k_checked_from) {
    std::memcpy(file.data(), base.data(), k_checksum_at);  // kind and version
    fuzz::put(&file, k_checksum_at, hash_bytes(file.data() + k_checked_from, file.size() - k_checked_from));
  }
  std::vector<uint64_t> aligned(file.size() / 8 + 2);
  uint8_t* const at = reinterpret_cast<uint8_t*>(aligned.data()) + (aligned_right ? 0 : 4);
  if (!file.empty()) std::memcpy(at, file.data(), file.size());
  const bool restored = sandglass_room_restore(room.handle(), at, file.size(), nullptr) == SANDGLASS_OK;
  fuzz::expect(restored ? aligned_right : size >= fuzz::k_edit_bytes || !aligned_right);
  if (!restored) return 0;
  const auto check = [&] {
    for (const float x : {0.0f, 1.5f, -900.0f}) {
      const sandglass_room_light light = room.light(x, 0.2f, -0.3f);
      fuzz::expect(std::isfinite(light.main_share) && std::isfinite(light.irradiance[1]));
      for (const float cell : light.cells) fuzz::expect(cell >= 0.0f && cell <= 1.01f);
      for (const float c : light.sh) fuzz::expect(std::isfinite(c));
      constexpr uint16_t k_not_finite = 0x7C00;  // of a half's exponent
      static std::vector<uint16_t> face(size_t{4} * SANDGLASS_ROOM_CUBE_SIZE * SANDGLASS_ROOM_CUBE_SIZE);
      const float place[3] = {x, 0.2f, -0.3f};
      fuzz::expect(sandglass_room_get_cube(room.handle(), place, 0.5f, 3, 0, face.data(), nullptr) == SANDGLASS_OK);
      for (const uint16_t h : face) fuzz::expect((h & k_not_finite) != k_not_finite);
    }
  };
  check();
  static Photograph seen = photograph(lamp_room(towards(30, 50), 8, 40), 20, 0, 1, 0);  // making it takes long
  static uint64_t now_ns = 1'000'000'000'000;
  seen.image.timestamp_ns = now_ns += 100'000'000;
  int32_t taken = 0;
  fuzz::expect(sandglass_room_set_image(room.handle(), &seen.image, &taken, nullptr) == SANDGLASS_OK);
  check();
  uint64_t bytes = bytes_of(room.handle()).size();
  fuzz::expect(sandglass_room_save(room.handle(), at, bytes - 1, &bytes, nullptr) == SANDGLASS_ERROR_MEMORY_TOO_SMALL);
  return 0;
}
