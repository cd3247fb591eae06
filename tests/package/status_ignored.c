/* A status that nobody looks at: with IGNORED_ON_PURPOSE it is cast to void, which must be silent in every language;
 * without, C++17 and C23 must warn. Compiled as C and as C++. */
#include "sandglass/sandglass.h"

uint64_t bytes_of(const sandglass_scene_desc* desc);
uint64_t bytes_of(const sandglass_scene_desc* desc) {
  uint64_t bytes = 0;
#ifdef IGNORED_ON_PURPOSE
  (void)sandglass_scene_bytes(desc, &bytes, NULL);
#else
  sandglass_scene_bytes(desc, &bytes, NULL);
#endif
  return bytes;
}
