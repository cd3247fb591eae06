// Reads directions, three numbers a line, and writes which texel of a cube of 8 the library takes for each, as face, column
// and row; then the same of a left-handed cube.
#include <cstdio>

#include "runtime/room/room.h"

int main() {
  constexpr int k_size = 8;
  static float faces[6][k_size][k_size][3];
  sandglass_cube cube;
  sandglass_cube_default(&cube);
  cube.format = SANDGLASS_CUBE_RGB32F;
  cube.size = k_size;
  cube.stride = sizeof faces[0][0];
  for (int face = 0; face < 6; ++face) {
    cube.faces[face] = faces[face];
    for (int y = 0; y < k_size; ++y)
      for (int x = 0; x < k_size; ++x) {
        const int texel[3] = {face, x, y};
        for (int c = 0; c < 3; ++c) faces[face][y][x][c] = static_cast<float>(texel[c]);
      }
  }
  double d[3];
  while (std::scanf("%lf %lf %lf", &d[0], &d[1], &d[2]) == 3)
    for (uint32_t left = 0; left < 2; ++left) {
      double texel[3];
      cube.left_handed = left;
      (void)sandglass::room_cube_texel(cube, d, texel);
      std::printf("%.0f %.0f %.0f%c", texel[0], texel[1], texel[2], left == 1 ? '\n' : ' ');
    }
  return 0;
}
