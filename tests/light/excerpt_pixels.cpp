// Writes the bytes of data sets' images as the host reads them, one image after another. PyTorch gets these bytes, so
// that both see the same.
#include <cstdio>
#include <exception>

#include "models/files/image.h"

int main(int count, char** arguments) try {
  for (int i = 1; i < count; ++i) {
    const sandglass::host::Picture picture = sandglass::host::read_excerpt(arguments[i]);
    if (std::fwrite(picture.rgb.data(), 1, picture.rgb.size(), stdout) != picture.rgb.size()) return 1;
  }
  return 0;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "%s\n", failure.what());
  return 2;
}
