// A recording whose checksums are right and whose content is wrong: it is refused, or what it says is written and read
// back alike.
#include "models/simulation/recording.h"
#include "runtime/math/hash.h"
#include "tests/fuzz/edits.h"

namespace {

using namespace sandglass;

std::vector<uint8_t> base_file() {
  host::Recording recording;
  recording.scene_name = "scene";
  recording.start_hash = 1;
  recording.final_hash = 2;
  recording.description = {1, 2, 3};
  for (int i = 0; i < 3; ++i) {
    host::RecordedFrame frame;
    frame.time_step = 0.02f;
    frame.budget_ns = 4000000;
    frame.colliders.resize(static_cast<size_t>(i));
    for (sandglass_collider& collider : frame.colliders) collider.rotation[3] = 1.0f;
    frame.plan.struct_size = sizeof frame.plan;
    frame.plan.run_count = 2;
    frame.plan.runs[0] = {SANDGLASS_STAGE_GRANULAR, 5};
    frame.plan.runs[1] = {SANDGLASS_STAGE_REFINE, 7};
    recording.frames.push_back(frame);
  }
  return host::encode_recording(recording);
}

// Walks the records as far as their lengths lead, and makes each checksum right.
void repair(std::vector<uint8_t>* file) {
  constexpr size_t k_prologue = 12, k_head = 8, k_checksum = 8;
  if (file->size() < k_prologue) return;
  uint64_t sum = hash_bytes(file->data(), k_prologue);
  for (size_t at = k_prologue; at + k_head + k_checksum <= file->size();) {
    uint32_t length;
    std::memcpy(&length, file->data() + at + 4, sizeof length);
    if (length > file->size() - at - k_head - k_checksum) return;
    sum = hash_bytes(file->data() + at, k_head + length, sum);
    fuzz::put(file, at + k_head + length, sum);
    at += k_head + length + k_checksum;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::vector<uint8_t> base = base_file();
  std::vector<uint8_t> file = base;
  fuzz::apply_edits(data, size, &file);
  if (file.size() >= 8) std::memcpy(file.data(), base.data(), 8);
  repair(&file);
  host::Recording recording, again;
  std::string error;
  if (!host::decode_recording(file.data(), file.size(), &recording, &error)) {
    fuzz::expect(!error.empty() && size >= fuzz::k_edit_bytes);
    return 0;
  }
  const std::vector<uint8_t> written = host::encode_recording(recording);
  fuzz::expect(host::decode_recording(written.data(), written.size(), &again, &error));
  fuzz::expect(host::encode_recording(again) == written);
  return 0;
}
