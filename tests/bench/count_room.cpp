// The workload on which the room is counted: images of 640 x 480 of a camera that turns, or the answers for one object.
//   count_room                                    the names of what is counted
//   count_room image_told|image_untold|answer
// told: the app says how each image is exposed; untold: the library finds it, which looks at each image twice.
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "sandglass/camera.h"
#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"
#include "tests/camera_picture.h"

int main(int argument_count, char** arguments) {
  constexpr uint32_t k_images = 24, k_answers = 8, k_width = 640, k_height = 480;
  if (argument_count < 2) {
    std::puts("image_told image_untold answer");
    return 0;
  }
  const std::string what = arguments[1];
  const bool answer = what == "answer";
  CountingRandom unit;
  std::vector<uint8_t> bytes(size_t{k_width} * k_height * 3 / 2);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(64 + 120 * unit());
  sandglass_camera_image image =
      sandglass::tests::camera_picture(bytes.data(), k_width, k_height, 520.0f, SANDGLASS_CAMERA_NV12);
  image.exposure = what == "image_untold" ? 0.0f : 1.0f;
  sandglass::cpp::Room room;
  if (!room.create()) return 2;
  const float axis[3] = {0, 1, 0}, place[3] = {0.5f, -0.5f, -1.0f};
  double sum = 0;
  if (!answer) counting_begins();
  for (uint32_t i = 0; i < k_images; ++i) {
    image.timestamp_ns = 1 + 200'000'000ull * i;
    if (sandglass_rotation_about(axis, 0.2618f * static_cast<float>(i), image.orientation) == 0) return 2;
    if (!room.set_image(image)) return 2;
  }
  if (!answer) counting_ends();
  if (answer) counting_begins();
  for (uint32_t i = 0; i < k_answers; ++i) sum += static_cast<double>(room.light_at(place).cells[i]);
  if (answer) counting_ends();
  std::printf("isa portable\nitems %u\nhash 0x%016llx\nsum %.9g\n", answer ? k_answers : k_images,
              static_cast<unsigned long long>(room.hash()), sum);
  return sum > 0 ? 0 : 2;
}
