// NumPy's files: .npy, version 1.0, for 32-bit floats in C order, and .npz, a zip of such arrays as numpy.savez writes
// it (stored, not compressed). A file may be damaged: every offset and length is checked.
#pragma once

#include <cstdint>
#include <map>
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

// The arrays of a .npz file, of 32-bit floats or of bytes, by their names without ".npy". A Failure names the file, and
// the array if one is at fault.
std::map<std::string, NpyArray> read_npz(const std::string& path);

}  // namespace sandglass::host
