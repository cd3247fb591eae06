// Runs a fuzzer's function without a fuzzer, for builds by other compilers: over the files and folders that are named, and
// over inputs that a fixed sequence of random numbers makes. SANDGLASS_FUZZ_INPUTS says how many.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "runtime/math/random.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  const char* asked = std::getenv("SANDGLASS_FUZZ_INPUTS");
  const int inputs = asked == nullptr ? 100 : std::atoi(asked);
  int files = 0;
  const auto run = [&](const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
    ++files;
  };
  for (int i = 1; i < argc; ++i) {
    if (!fs::is_directory(argv[i])) run(argv[i]);
    else
      for (const fs::directory_entry& entry : fs::directory_iterator(argv[i])) run(entry.path());
  }
  sandglass::Random random{1};
  for (int i = 0; i < inputs; ++i) {
    std::vector<uint8_t> bytes(random.below(25));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.below(256));
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::printf("%d files, %d random inputs\n", files, inputs);
  return 0;
}
