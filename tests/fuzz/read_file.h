// For readers that take a path: the fuzzer's bytes as a file with the extension that its first byte picks.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "models/files/failure.h"
#include "tests/fuzz/edits.h"

namespace sandglass::fuzz {

template <class Read, size_t count>
void read_as_file(const uint8_t* data, size_t size, const char* const (&extensions)[count], const Read& read) {
  if (size == 0) return;
  static const struct Folder {
    char name[32] = "/tmp/sandglass_fuzz_XXXXXX";
    Folder() { expect(mkdtemp(name) != nullptr); }
    ~Folder() { rmdir(name); }
  } folder;
  const std::string path = folder.name + std::string("/x") + extensions[data[0] % count];
  std::FILE* file = std::fopen(path.c_str(), "wb");
  expect(file != nullptr && std::fwrite(data + 1, 1, size - 1, file) == size - 1 && std::fclose(file) == 0);
  try {
    read(path);
  } catch (const host::Failure& failure) {
    expect(std::strlen(failure.what()) > 0);
  }
  unlink(path.c_str());
}

}  // namespace sandglass::fuzz
