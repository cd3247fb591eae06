// What every asset file has in common: a FlatBuffer, and behind it eight bytes, the FNV-1a hash of all bytes before
// them, little-endian. The checks here come first; FlatBuffers' verifier and the checks of each kind of file follow.
#pragma once

#include <cstdint>
#include <cstring>

#include "runtime/frame/refuse.h"
#include "runtime/math/hash.h"

namespace sandglass {

constexpr uint64_t k_checksum_bytes = 8;
constexpr uint64_t k_asset_bytes_min = 32;
constexpr uint64_t k_asset_bytes_limit = uint64_t{1} << 31;  // FlatBuffers' offsets have 31 bits

// How a kind of file is refused, in its own words.
struct AssetRefusals {
  const char *missing, *other_kind, *damaged;
};

// `identifier`: the four characters at byte 4 that tell the kind.
inline sandglass_status check_asset_bytes(const void* bytes, uint64_t count, const char* identifier,
                                          const AssetRefusals& refusals, const char** reason) {
  const uint8_t* data = static_cast<const uint8_t*>(bytes);
  if (data == nullptr) return refuse(reason, refusals.missing);
  if (reinterpret_cast<uintptr_t>(data) % 8 != 0)
    return refuse(reason, "asset is not aligned to 8 bytes: read the file into memory that is.");
  constexpr char k_lfs_pointer[] = "version https://git-lfs.github.com/spec/";
  if (count >= sizeof k_lfs_pointer && memcmp(data, k_lfs_pointer, sizeof k_lfs_pointer - 1) == 0)
    return refuse(reason, "the file is a Git LFS pointer, not the asset itself: fetch that with git lfs pull.");
  if (count < k_asset_bytes_min || count >= k_asset_bytes_limit || memcmp(data + 4, identifier, 4) != 0)
    return refuse(reason, refusals.other_kind);
  const uint64_t body = count - k_checksum_bytes;
  uint64_t stored = 0;
  for (uint32_t i = 0; i < k_checksum_bytes; ++i) stored |= uint64_t{data[body + i]} << 8 * i;
  return stored == hash_bytes(data, body) ? accept(reason) : refuse(reason, refusals.damaged);
}

}  // namespace sandglass
