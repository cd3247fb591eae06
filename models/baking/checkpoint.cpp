// The file holds a magic number, the key, the step and the loss. Then come the arrays, each after its length. The
// FNV-1a hash of everything before ends the file.
#include "models/baking/checkpoint.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/core/hash.h"

namespace sandglass::host {

namespace {

constexpr char k_magic[8] = {'S', 'G', 'B', 'A', 'K', 'E', '0', '1'};

struct Writer {
  std::string bytes;
  template <class T>
  void value(const T& x) {
    bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
  }
  template <class Array>
  void array(const Array& values) {
    value(static_cast<uint64_t>(values.size()));
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
  }
};

struct Reader {
  const std::string& bytes;
  size_t at = 0;
  bool good = true;
  template <class T>
  void value(T* x) {
    good = good && bytes.size() - at >= sizeof *x;
    if (!good) return;
    std::memcpy(x, bytes.data() + at, sizeof *x);
    at += sizeof *x;
  }
  template <class Array>
  void array(Array* values) {
    constexpr size_t k_item = sizeof(typename Array::value_type);
    uint64_t count = 0;
    value(&count);
    good = good && count <= (bytes.size() - at) / k_item;
    if (!good) return;
    values->resize(count);
    if (count == 0) return;
    std::memcpy(values->data(), bytes.data() + at, count * k_item);
    at += count * k_item;
  }
};

uint64_t hash_of(const std::string& bytes, size_t count) { return hash_bytes(bytes.data(), count); }

}  // namespace

void require_own_checkpoint(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char magic[sizeof k_magic] = {};
  if (!file || (file.read(magic, sizeof magic) && std::memcmp(magic, k_magic, sizeof magic) == 0)) return;
  throw cannot("write checkpoint", path, "a file that is no checkpoint has this name",
               "Move it away, or give the output another name");
}

void save_checkpoint(const std::string& path, uint64_t key, const TrainingSet& set, const TrainingState& state) {
  Writer w;
  w.bytes.append(k_magic, sizeof k_magic);
  w.value(key);
  w.value(state.step);
  w.value(state.loss);
  w.array(set.values);
  w.array(state.network.parameters);
  w.array(state.mean);
  w.array(state.variance);
  w.array(state.float_network.parameters);
  w.array(state.clips);
  w.value(hash_of(w.bytes, w.bytes.size()));
  write_file(path, w.bytes);
}

bool load_checkpoint(const std::string& path, uint64_t key, TrainingSet* set, TrainingState* state) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return false;
  const std::string bytes = read_file(path, "checkpoint");
  Reader r = {bytes};
  char magic[8] = {};
  uint64_t stored_key = 0, stored_hash = 0;
  TrainingSet read_set;
  TrainingState read_state;
  r.value(&magic);
  r.value(&stored_key);
  r.value(&read_state.step);
  r.value(&read_state.loss);
  r.array(&read_set.values);
  r.array(&read_state.network.parameters);
  r.array(&read_state.mean);
  r.array(&read_state.variance);
  r.array(&read_state.float_network.parameters);
  r.array(&read_state.clips);
  const size_t end = r.at;
  r.value(&stored_hash);
  if (!r.good || std::memcmp(magic, k_magic, sizeof magic) != 0 || stored_hash != hash_of(bytes, end))
    throw cannot("read checkpoint", path, "it is damaged", "Delete it, or bake without --resume");
  if (stored_key != key)
    throw cannot("read checkpoint", path, "it is of another mesh or other settings",
                 "Repeat the command that was interrupted, or bake without --resume");
  set->values = std::move(read_set.values);
  read_state.network.shape = read_state.float_network.shape = state->network.shape;
  *state = std::move(read_state);
  return true;
}

}  // namespace sandglass::host
