// Header: magic, version, little-endian length, a Python dictionary padded with spaces so that the data start at a
// multiple of 64.
#include "models/files/npy.h"

#include <bit>
#include <cstring>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

namespace sandglass::host {

static_assert(std::endian::native == std::endian::little,
              "the files are little-endian and written as memory holds them");

constexpr char k_magic[8] = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0};
constexpr size_t k_preamble = sizeof k_magic + 2;  // bytes before the dictionary: magic, version, length
constexpr size_t k_alignment = 64;                 // of the data, by the format's definition

void write_npy(const std::string& path, std::span<const float> values, uint64_t rows, uint64_t columns) {
  if (values.size() != rows * columns)
    throw cannot("write", path, "the array does not have rows x columns values", "Report this");
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",";
  if (columns != 1) header.append(" ").append(std::to_string(columns));
  header += "), }";
  while ((k_preamble + header.size() + 1) % k_alignment != 0) header += ' ';
  header += '\n';
  std::string file(k_magic, sizeof k_magic);
  file += static_cast<char>(header.size() & 255);
  file += static_cast<char>(header.size() >> 8);
  file += header;
  if (!values.empty()) file.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  write_file(path, file);
}

NpyArray read_npy(const std::string& path) {
  const std::string file = read_file(path, "array");
  const Failure refused("'" + path + "' is not an .npy file of version 1.0 with 32-bit floats in C order");
  if (file.size() < k_preamble || std::memcmp(file.data(), k_magic, sizeof k_magic) != 0) throw refused;
  const size_t length = static_cast<uint8_t>(file[8]) + 256u * static_cast<uint8_t>(file[9]);
  if (file.size() < k_preamble + length) throw refused;
  const std::string header = file.substr(k_preamble, length);
  const size_t open = header.find("'shape': (");
  if (header.find("'<f4'") == std::string::npos || header.find("'fortran_order': False") == std::string::npos ||
      open == std::string::npos)
    throw refused;
  NpyArray array;
  uint64_t count = 1, number = 0;
  bool digits = false;
  for (size_t i = open + 10; i < header.size(); ++i) {
    const char c = header[i];
    if (c >= '0' && c <= '9') {
      number = number * 10 + static_cast<uint64_t>(c - '0');
      digits = true;
    } else if (digits) {
      array.shape.push_back(number);
      count *= number;
      number = 0;
      digits = false;
    }
    if (c == ')') break;
  }
  if (file.size() != k_preamble + length + count * sizeof(float)) throw refused;
  array.values.resize(count);
  if (count > 0) std::memcpy(array.values.data(), file.data() + k_preamble + length, count * sizeof(float));
  return array;
}

}  // namespace sandglass::host
