// Forged files: a good file, changed as the fuzzer's bytes say. The fuzzer need not find the format, and its corpus stays
// valid when the format changes. Each change is eight bytes: where, how, and with what.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace sandglass::fuzz {

template <class Value>
void put(std::vector<uint8_t>* file, size_t at, Value value) {
  if (at + sizeof value <= file->size()) std::memcpy(file->data() + at, &value, sizeof value);
}

// Values at which a check is easily wrong.
inline float odd_float(uint8_t which) {
  constexpr float k_values[] = {0.0f,
                                -0.0f,
                                1.0f,
                                -1.0f,
                                1e-30f,
                                1e10f,
                                -1e10f,
                                1e30f,
                                3e38f,
                                -3e38f,
                                1e-45f,
                                2147483648.0f,
                                1000.0f,
                                -2000.0f,
                                std::numeric_limits<float>::infinity(),
                                std::numeric_limits<float>::quiet_NaN()};
  return k_values[which % std::size(k_values)];
}
inline double odd_double(uint8_t which) {
  constexpr double k_values[] = {0.0, 1.0, -1.0, 1e300, -1e300, 1e19, 1e5, std::numeric_limits<double>::quiet_NaN()};
  return k_values[which % std::size(k_values)];
}
inline uint32_t odd_number(uint8_t which) {
  constexpr uint32_t k_values[] = {0, 1, 2, 255, 65536, 0x7fffffff, 0x80000000, 0xffffffff};
  return k_values[which % std::size(k_values)];
}

constexpr size_t k_edit_bytes = 8;  // fewer bytes change nothing: a good file is taken

inline void apply_edits(const uint8_t* edits, size_t size, std::vector<uint8_t>* file) {
  constexpr size_t k_edits_max = 64;
  for (size_t i = 0; i + k_edit_bytes <= size && i < k_edit_bytes * k_edits_max && !file->empty(); i += k_edit_bytes) {
    uint32_t where;
    std::memcpy(&where, edits + i, sizeof where);
    const uint8_t how = edits[i + 4], what = edits[i + 5];
    const size_t at = where % file->size(), word = at / 4 * 4;
    uint16_t pair;
    std::memcpy(&pair, edits + i + 6, sizeof pair);
    switch (how % 7) {
      case 0:
        (*file)[at] = what;
        break;
      case 1:
        (*file)[at] ^= static_cast<uint8_t>(1u << what % 8);
        break;
      case 2:
        put(file, word, odd_float(what));
        break;
      case 3:
        put(file, word, odd_double(what));
        break;
      case 4:
        put(file, word, odd_number(what));
        break;
      case 5:
        put(file, word, (static_cast<float>(pair) - 32768.0f) * 0.01f);
        break;
      case 6:
        if (pair % 16 == 0) file->resize(at);
        else put(file, at, pair);
        break;
    }
  }
}

// A plain struct, changed in the same way.
template <class Plain>
Plain edited(const Plain& base, const uint8_t* edits, size_t size) {
  std::vector<uint8_t> bytes(sizeof base);
  std::memcpy(bytes.data(), &base, sizeof base);
  apply_edits(edits, size, &bytes);
  bytes.resize(sizeof base);
  Plain changed;
  std::memcpy(&changed, bytes.data(), sizeof changed);
  return changed;
}

// Ends the program so that the fuzzer keeps the input.
inline void expect(bool holds) {
  if (!holds) __builtin_trap();
}

}  // namespace sandglass::fuzz
