// The workload on which shadows of triangles are counted: a knot of 2,000 triangles under twelve lights, 2 to 20 degrees wide to
// each side, in 64 directions and 128 x 128 texels; and its ambient shadow, 64 x 64.
//   count_cast closed|both|ambient [ISA]
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "models/mesh/generated.h"
#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  const std::string what = argument_count > 1 ? arguments[1] : "closed";
  const bool ambient = what.starts_with("ambient");
  const sandglass::host::Mesh knot = sandglass::host::make_trefoil(0.1f, 0.018f, 100, 10);
  sandglass_cast_desc desc = sandglass::cast_desc();
  desc.texels = ambient ? 0 : 128;
  desc.ambient_texels = ambient ? 64 : 0;
  desc.layers = what.ends_with("layers") ? 4 : 1;
  desc.isa = argument_count > 2 ? std::atoi(arguments[2]) : SANDGLASS_ISA_AUTOMATIC;
  sandglass::Cast cast;
  const sandglass::Status made = cast.create(desc);
  if (!made) return wrong(made.reason);
  sandglass_cast_mesh mesh = sandglass::cast_mesh();
  mesh.positions = knot.vertices.data();
  mesh.vertex_count = knot.vertex_count();
  mesh.indices = knot.indices.data();
  mesh.triangle_count = knot.triangle_count();
  mesh.closed = what == "both" ? 0 : 1;
  mesh.world_from_mesh[13] = 0.12f;
  uint64_t hash = 0;
  uint32_t textures = 0, units = 0;
  counting_begins();
  for (const float half : {2.0f, 5.0f, 10.0f, 20.0f})
    for (const float elevation : {20.0f, 45.0f, 70.0f}) {
      constexpr float k_degree = 0.017453293f;
      const float e = elevation * k_degree, a = 0.7f + 1.9f * static_cast<float>(textures++);
      const std::array<float, 3> light = {std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)};
      ++mesh.version;
      if (!cast.set_meshes(&mesh, 1) || !cast.set_light(light, 2 * half * k_degree)) return 2;
      for (uint32_t ran; (ran = cast.run(16)) != 0;) units += ran;
      const sandglass_texture t = ambient ? cast.ambient() : cast.texture();
      for (uint32_t i = 0; i < t.layers * t.side * t.side; ++i) hash = hash * 31 + t.bytes[i];
    }
  counting_ends();
  std::printf("isa %s\ntextures %u\nunits %u\nhash 0x%016llx\n", sandglass_isa_name(desc.isa), textures, units,
              static_cast<unsigned long long>(hash));
  return 0;
}
