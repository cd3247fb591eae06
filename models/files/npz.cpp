#include "models/files/npz.h"

#include <cstdint>
#include <cstring>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_end_signature = 0x06054B50, k_entry_signature = 0x02014B50, k_local_signature = 0x04034B50;
constexpr size_t k_end_bytes = 22, k_entry_bytes = 46, k_local_bytes = 30, k_comment_limit = 65535;
constexpr uint64_t k_value_limit = 1ull << 28;  // of an array: a gigabyte

// Little-endian fields of a file, with one complaint for all that lies outside it.
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

// The value of a key of the header, a Python dictionary: what follows the key's colon.
std::string header_value(const std::string& header, const std::string& key) {
  const size_t at = header.find("'" + key + "'");
  const size_t colon = at == std::string::npos ? at : header.find(':', at);
  const size_t value = colon == std::string::npos ? colon : header.find_first_not_of(' ', colon + 1);
  return value == std::string::npos ? "" : header.substr(value);
}

NpyArray parse_array(const ZipReader& zip, const std::string& name, size_t at, size_t size) {
  const auto damaged = [&](const std::string& what) { zip.damaged("has an array \"" + name + "\" that " + what); };
  if (size < 10 || zip.bytes.compare(at, 8, std::string("\x93NUMPY\x01\x00", 8)) != 0)
    damaged("is not in .npy format 1.0");
  const size_t header_bytes = zip.field(at + 8, 2);
  if (header_bytes + 10 > size) damaged("is cut off");
  const std::string header = zip.bytes.substr(at + 10, header_bytes), type = header_value(header, "descr").substr(0, 5);
  const bool floats = type == "'<f4'", octets = type == "'|u1'";
  if (!floats && !octets) damaged("is neither of 32-bit floats nor of bytes");
  if (header_value(header, "fortran_order").rfind("False", 0) != 0) damaged("is not in C order");
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
    if (extent > k_value_limit || count > k_value_limit) damaged("is larger than 2^28 values");
  }
  const size_t value_bytes = floats ? 4 : 1;
  if (count * value_bytes != size - 10 - header_bytes) damaged("has another size than its shape says");
  array.values.resize(count);
  const char* data = zip.bytes.data() + at + 10 + header_bytes;
  if (floats) std::memcpy(array.values.data(), data, 4 * count);
  else
    for (size_t i = 0; i < count; ++i) array.values[i] = static_cast<float>(static_cast<uint8_t>(data[i]));
  return array;
}

}  // namespace

std::map<std::string, NpyArray> read_npz(const std::string& path) {
  const std::string bytes = read_file(path, "weights");
  const ZipReader zip = {path, bytes};
  const size_t end = zip.end_record();
  const uint32_t count = zip.field(end + 10, 2);
  size_t at = zip.field(end + 16, 4);
  std::map<std::string, NpyArray> arrays;
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
    arrays[name] = parse_array(zip, name, data, size);
    at += k_entry_bytes + name_bytes + zip.field(at + 30, 2) + zip.field(at + 32, 2);
  }
  return arrays;
}

}  // namespace sandglass::host
