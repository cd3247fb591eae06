// NumPy's files: .npy, version 1.0, for 32-bit floats in C order. A file may be damaged: every offset and length is
// checked.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sandglass::host {

// Writes rows x columns floats. With `columns` 1 the array is one-dimensional.
void write_npy(const std::string& path, std::span<const float> values, uint64_t rows, uint64_t columns);

struct NpyArray {
  std::vector<uint64_t> shape;
  std::vector<float> values;
};

// Reads an array of 32-bit floats in C order, of any shape. Throws a Failure for anything else.
NpyArray read_npy(const std::string& path);

}  // namespace sandglass::host
