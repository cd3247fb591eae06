// The soft shadow of a chair, without a scene, while the light goes round it: a texture for each of eight lights, and
// the last one as text.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "sandglass/sandglass.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: shadow_alone chair.shadow\n", stderr);
    return 2;
  }
  // A baked file, aligned to 8 bytes; needed until create returns.
  std::ifstream file(argv[1], std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<uint64_t> words(bytes.size() / 8 + 1);
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(words.data()));

  sandglass_shadow_desc desc = sandglass::shadow_desc();
  desc.asset = words.data();
  desc.asset_bytes = bytes.size();
  sandglass_shadow_info chair{};
  sandglass::Shadow shadow;
  sandglass::Status status = sandglass::inspect_shadow(desc.asset, desc.asset_bytes, &chair);
  if (status) status = shadow.create(desc);

  const int texels = SANDGLASS_SHADOW_TEXELS;
  sandglass_texture texture{};
  for (int light = 0; status && light < 8; ++light) {
    const float azimuth = 0.7853982f * static_cast<float>(light), x = std::cos(azimuth), z = std::sin(azimuth);
    status = shadow.set_light({x, 1.2f, z});  // towards the light, in the object's frame
    shadow.run();                             // all units; an app with frames runs a few in each
    texture = shadow.texture();
    // Where the middle of the shadow lies, seen from the middle of the chair, in metres.
    double sum = 0, middle_x = 0, middle_z = 0;
    for (int v = 0; v < texels; ++v)
      for (int u = 0; u < texels; ++u) {
        const double covered = texture.bytes[v * texels + u];
        sum += covered;
        middle_x += covered * (u + 0.5) / texels;
        middle_z += covered * (v + 0.5) / texels;
      }
    const double to_x = texture.corner[0] + middle_x / sum * texture.along[0] - chair.origin[0];
    const double to_z = texture.corner[2] + middle_z / sum * texture.across[2] - chair.origin[2];
    std::printf("light (%5.2f %5.2f): shadow falls to (%5.2f %5.2f), away from the light by %.2f m\n",
                static_cast<double>(x), static_cast<double>(z), to_x, to_z, -(to_x * x + to_z * z));
  }
  if (!status) {
    std::fprintf(stderr, "%s: %s\n", argv[1], status.reason);
    return 1;
  }
  for (int row = 0; row < 24; ++row, std::putchar('\n'))
    for (int column = 0; column < 48; ++column)
      std::putchar(" .:-=+*#%@"[texture.bytes[row * texels / 24 * texels + column * texels / 48] / 26]);
}
