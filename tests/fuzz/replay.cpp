// Runs a fuzzer's function without a fuzzer, for builds by other compilers: over the files that are named, and over
// inputs that a fixed sequence of random numbers makes. SANDGLASS_FUZZ_INPUTS says how many.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "runtime/math/random.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int main(int argc, char** argv) {
  const char* asked = std::getenv("SANDGLASS_FUZZ_INPUTS");
  const int inputs = asked == nullptr ? 100 : std::atoi(asked);
  for (int i = 1; i < argc; ++i) {
    std::ifstream file(argv[i], std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  }
  sandglass::Random random{1};
  for (int i = 0; i < inputs; ++i) {
    std::vector<uint8_t> bytes(random.below(25));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.below(256));
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::printf("%d files, %d random inputs\n", argc - 1, inputs);
  return 0;
}
