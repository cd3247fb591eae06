// NumPy's .npy format, version 1.0, for 32-bit floats in C order.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
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

// Reads an array from the bytes of an .npy file, which may be damaged. `refuse` gets what is wrong ("is cut off") and
// must throw. With `octets_too` an array of bytes is accepted, too.
NpyArray parse_npy(std::string_view bytes, bool octets_too, const std::function<void(const std::string&)>& refuse);

}  // namespace sandglass::host
