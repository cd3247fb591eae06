// NumPy's .npy format, version 1.0, for 32-bit floats in C order: what `sandglass run --dump` writes, one array a file.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sandglass::host {

// rows x columns floats; columns 1 writes a one-dimensional array.
void write_npy(const std::string& path, std::span<const float> values, uint64_t rows, uint64_t columns);

struct NpyArray {
  std::vector<uint64_t> shape;
  std::vector<float> values;
};

// Reads what write_npy writes; a Failure for anything else.
NpyArray read_npy(const std::string& path);

// An array from the bytes of an .npy file, which may be damaged. `refuse` gets what is wrong ("is cut off") and throws.
// `octets_too`: an array of bytes is taken as well.
NpyArray parse_npy(std::string_view bytes, bool octets_too, const std::function<void(const std::string&)>& refuse);

}  // namespace sandglass::host
