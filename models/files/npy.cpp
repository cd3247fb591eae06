// The header holds a magic number, the version, a little-endian length and a Python dictionary. Spaces pad it so that
// the data start at a multiple of 64.
#include "models/files/npy.h"

#include <bit>
#include <cstring>
#include <functional>
#include <string_view>

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

// Reads an array from the bytes of an .npy file. `refuse` gets what is wrong ("is cut off") and must throw. With
// `octets_too` an array of bytes is accepted, too.
static NpyArray parse_npy(std::string_view bytes, bool octets_too,
                          const std::function<void(const std::string&)>& refuse) {
  if (bytes.size() < k_preamble || bytes.substr(0, sizeof k_magic) != std::string_view(k_magic, sizeof k_magic))
    refuse("is not in .npy format 1.0");
  const size_t header_bytes = static_cast<uint8_t>(bytes[8]) + 256u * static_cast<uint8_t>(bytes[9]);
  if (header_bytes + k_preamble > bytes.size()) refuse("is cut off");
  const std::string header(bytes.substr(k_preamble, header_bytes)), type = header_value(header, "descr").substr(0, 5);
  const bool floats = type == "'<f4'";
  if (!floats && !(octets_too && type == "'|u1'"))
    refuse(octets_too ? "is neither of 32-bit floats nor of bytes" : "is not of 32-bit floats");
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
  const std::string_view data = bytes.substr(k_preamble + header_bytes);
  if (count * (floats ? 4 : 1) != data.size()) refuse("has another size than its shape says");
  array.values.resize(count);
  if (!floats)
    for (size_t i = 0; i < count; ++i) array.values[i] = static_cast<float>(static_cast<uint8_t>(data[i]));
  else if (count > 0) std::memcpy(array.values.data(), data.data(), 4 * count);
  return array;
}

NpyArray read_npy(const std::string& path) {
  return parse_npy(read_file(path, "array"), false, [&](const std::string& what) {
    throw cannot("read", path, "it " + what, "Save it with numpy.save as 32-bit floats");
  });
}

namespace {

constexpr uint32_t k_end_signature = 0x06054B50, k_entry_signature = 0x02014B50, k_local_signature = 0x04034B50;
constexpr size_t k_end_bytes = 22, k_entry_bytes = 46, k_local_bytes = 30, k_comment_limit = 65535;

// Reads little-endian fields of a file. Every access outside the file gives the same error.
struct ZipReader {
  const std::string& path;
  const std::string& bytes;

  [[noreturn]] void damaged(const std::string& what) const {
    throw cannot("read", path, "it " + what, "Save it again with numpy.savez");
  }
  void need(size_t at, size_t count) const {
    if (at > bytes.size() || count > bytes.size() - at) damaged("is cut off or damaged");
  }
  uint32_t field(size_t at, size_t count) const {
    need(at, count);
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i) value |= static_cast<uint32_t>(static_cast<uint8_t>(bytes[at + i])) << (8 * i);
    return value;
  }
  size_t end_record() const {
    if (bytes.size() < k_end_bytes) damaged("is not a .npz file");
    const size_t last = bytes.size() - k_end_bytes, first = last > k_comment_limit ? last - k_comment_limit : 0;
    for (size_t at = last + 1; at-- > first;)
      if (field(at, 4) == k_end_signature) return at;
    damaged("is not a .npz file, or is cut off");
  }
};

}  // namespace

std::map<std::string, NpyArray> read_npz(const std::string& path) {
  const std::string bytes = read_file(path, "weights");
  const ZipReader zip = {path, bytes};
  const size_t end = zip.end_record();
  const uint32_t count = zip.field(end + 10, 2);
  size_t at = zip.field(end + 16, 4);
  std::map<std::string, NpyArray> arrays;
  size_t together = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (zip.field(at, 4) != k_entry_signature) zip.damaged("has a damaged table of contents");
    if (zip.field(at + 10, 2) != 0) zip.damaged("is compressed (numpy.savez_compressed)");
    const size_t size = zip.field(at + 20, 4), name_bytes = zip.field(at + 28, 2), local = zip.field(at + 42, 4);
    zip.need(at + k_entry_bytes, name_bytes);
    std::string name = bytes.substr(at + k_entry_bytes, name_bytes);
    if (name.size() > 4 && name.compare(name.size() - 4, 4, ".npy") == 0) name.resize(name.size() - 4);
    if (zip.field(local, 4) != k_local_signature) zip.damaged("has a damaged entry \"" + name + "\"");
    const size_t data = local + k_local_bytes + zip.field(local + 26, 2) + zip.field(local + 28, 2);
    zip.need(data, size);
    // Entries that lie in one another would ask for more memory than the file's size promises.
    together += size;
    if (together > bytes.size()) zip.damaged("has entries that overlap");
    arrays[name] = parse_npy(std::string_view(bytes).substr(data, size), true, [&](const std::string& what) {
      zip.damaged("has an array \"" + name + "\" that " + what);
    });
    at += k_entry_bytes + name_bytes + zip.field(at + 30, 2) + zip.field(at + 32, 2);
  }
  return arrays;
}

}  // namespace sandglass::host
