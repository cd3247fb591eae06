// A run that can be replayed on another machine: the description of the scene, what every frame was given, the plan
// that it executed, and the hash of the final state. Because advancing is a pure function of state, input and plan, a
// replay on any instruction set must end in that hash.
//
// On disk, little-endian: an 8-byte magic, a version, then records. A record is {kind u32, bytes u32, payload, checksum
// u64}; the checksum is FNV-1a over the record and continues the previous record's, so a record that was changed,
// dropped or moved shows. One header record, one record a frame, one trailer; nothing after it. A file is written under
// a temporary name and renamed when it is complete. Reading trusts nothing: every size is checked against the bytes
// that are there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

struct RecordedFrame {
  float time_step = 0.0f;
  uint64_t budget_ns = 0;  // what the plan was made under; a replay needs only the plan
  std::vector<sandglass_collider> colliders;
  sandglass_plan plan = {};
};

struct Recording {
  std::string scene_name;   // as given to `run`
  uint64_t start_hash = 0;  // sandglass_scene_hash before the first frame: another scene of the same name shows at once
  std::vector<uint8_t> description;  // whatever else the writer needs to build the scene; not interpreted here
  std::vector<RecordedFrame> frames;
  uint64_t final_hash = 0;  // sandglass_scene_hash after the last frame
};

std::vector<uint8_t> encode_recording(const Recording& recording);

// True and *recording filled, or false and in *error what is wrong and what to do; then *recording is untouched. Takes
// time and memory in proportion to `bytes`, whatever the bytes say.
[[nodiscard]] bool decode_recording(const uint8_t* data, size_t bytes, Recording* recording, std::string* error);

// The same through a file; a Failure names it.
void save_recording(const Recording& recording, const std::string& path);
Recording load_recording(const std::string& path);

}  // namespace sandglass::host
