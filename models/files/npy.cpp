// The header holds a magic number, the version, a little-endian length and a Python dictionary. Spaces pad it so that
// the data start at a multiple of 64.
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
constexpr size_t k_alignment = 64;                 // of the data, as the format defines it
constexpr uint64_t k_value_limit = 1ull << 28;     // values of an array: a gigabyte of floats

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

// The text after the colon of a key in the header, which is a Python dictionary.
static std::string header_value(const std::string& header, const std::string& key) {
  const size_t at = header.find("'" + key + "'");
  const size_t colon = at == std::string::npos ? at : header.find(':', at);
  const size_t value = colon == std::string::npos ? colon : header.find_first_not_of(' ', colon + 1);
  return value == std::string::npos ? "" : header.substr(value);
}

NpyArray read_npy(const std::string& path) {
  const std::string bytes = read_file(path, "array");
  const auto refuse = [&](const std::string& what) {
    throw cannot("read", path, "it " + what, "Save it with numpy.save as 32-bit floats");
  };
  if (bytes.size() < k_preamble || bytes.compare(0, sizeof k_magic, k_magic, sizeof k_magic) != 0)
    refuse("is not in .npy format 1.0");
  const size_t header_bytes = static_cast<uint8_t>(bytes[8]) + 256u * static_cast<uint8_t>(bytes[9]);
  if (header_bytes + k_preamble > bytes.size()) refuse("is cut off");
  const std::string header = bytes.substr(k_preamble, header_bytes);
  if (header_value(header, "descr").rfind("'<f4'", 0) != 0) refuse("is not of 32-bit floats");
  if (header_value(header, "fortran_order").rfind("False", 0) != 0) refuse("is not in C order");
  NpyArray array;
  uint64_t count = 1;
  const std::string shape = header_value(header, "shape");
  for (size_t i = 1; i < shape.size() && shape[i] != ')';) {
    if (shape[i] < '0' || shape[i] > '9') {
      ++i;
      continue;
    }
    uint64_t extent = 0;
    for (; i < shape.size() && shape[i] >= '0' && shape[i] <= '9' && extent <= k_value_limit; ++i)
      extent = 10 * extent + static_cast<uint64_t>(shape[i] - '0');
    array.shape.push_back(extent);
    count *= extent;
    if (extent > k_value_limit || count > k_value_limit) refuse("is larger than 2^28 values");
  }
  const size_t data = k_preamble + header_bytes;
  if (4 * count != bytes.size() - data) refuse("has another size than its shape says");
  array.values.resize(count);
  if (count > 0) std::memcpy(array.values.data(), bytes.data() + data, 4 * count);
  return array;
}

}  // namespace sandglass::host
