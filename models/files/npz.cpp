// See npz.h.
#include "models/files/npz.h"

#include <cstdint>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

namespace sandglass::host {

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
    arrays[name] = parse_npy(std::string_view(bytes).substr(data, size), true, [&](const std::string& what) {
      zip.damaged("has an array \"" + name + "\" that " + what);
    });
    at += k_entry_bytes + name_bytes + zip.field(at + 30, 2) + zip.field(at + 32, 2);
  }
  return arrays;
}

}  // namespace sandglass::host
