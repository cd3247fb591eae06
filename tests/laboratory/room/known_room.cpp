#include "tests/laboratory/room/known_room.h"

#include <vector>

#include "models/files/failure.h"
#include "runtime/light/cube_map.h"

namespace sandglass::host {

void know_room(const RadianceMap& panorama, cpp::Room* room) {
  constexpr int k_size = 32, k_points = 3;
  std::vector<float> texels;
  for (uint32_t face = 0; face < 6; ++face)
    for (int i = 0; i < k_size * k_size; ++i) {
      Vec3 sum{};
      for (int k = 0; k < k_points * k_points; ++k) {
        const double s = 2 * (i % k_size + (k % k_points + 0.5) / k_points) / k_size - 1;
        const double t = 2 * (i / k_size + (k / k_points + 0.5) / k_points) / k_size - 1;
        double d[3];
        cube_direction({face, s, t}, d);
        sum = sum + look_up(panorama, {d[0], d[1], d[2]});
      }
      for (const double x : {sum.x, sum.y, sum.z}) texels.push_back(static_cast<float>(x / (k_points * k_points)));
    }
  sandglass_room_desc desc = cpp::room_desc();
  desc.probe = 1;
  sandglass_cube cube;
  sandglass_cube_default(&cube);
  cube.format = SANDGLASS_CUBE_RGB32F;
  cube.size = k_size;
  cube.stride = 3 * static_cast<int32_t>(sizeof(float)) * k_size;
  for (size_t face = 0; face < 6; ++face) cube.faces[face] = texels.data() + face * 3 * k_size * k_size;
  if (const cpp::Status made = room->create(desc); !made) throw Failure(made.reason);
  if (const cpp::Status known = room->set_cube(cube); !known) throw Failure(known.reason);
}

sandglass_room_light light_on(const cpp::Room& room, const float normal[3], const float along[3]) {
  sandglass_room_place place;
  sandglass_room_place_default(&place);
  place.normal = normal;
  place.along = along;
  sandglass_room_light light{};
  light.struct_size = sizeof light;
  if (const char* reason = nullptr; sandglass_room_get(room.get(), &place, &light, &reason) != SANDGLASS_OK)
    throw Failure(reason);
  return light;
}

}  // namespace sandglass::host
