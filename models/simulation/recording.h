// A run that can be replayed on another machine: the description of the scene, what every frame was given, the plan
// that it executed, and the hash of the final state. The next state is a pure function of state, input and plan. So a
// replay on any instruction set must end in that hash.
//
// The file is little-endian: an 8-byte magic, a u32 version, then records. A record is
//     {kind u32, bytes u32, payload, checksum u64}
// The checksum is FNV-1a over the record and continues the checksum before it. So a record that was changed, dropped or
// moved is found. There is one header record, one record per frame and one trailer; nothing follows it. A file is
// written under a temporary name and renamed when it is complete. Reading trusts nothing: every size is checked against
// the bytes that are there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

struct RecordedFrame {
  float time_step = 0.0f;
  uint64_t budget_ns = 0;  // the budget that the plan was made under; a replay needs only the plan
  std::vector<sandglass_collider> colliders;
  sandglass_plan plan = {};
};

struct Recording {
  std::string scene_name;  // as given to `run`
  // sandglass_scene_hash before the first frame. It shows at once that another scene has the same name.
  uint64_t start_hash = 0;
  // Whatever else the writer needs to build the scene. It is not interpreted here.
  std::vector<uint8_t> description;
  std::vector<RecordedFrame> frames;
  uint64_t final_hash = 0;  // sandglass_scene_hash after the last frame
};

std::vector<uint8_t> encode_recording(const Recording& recording);

// Returns true and fills *recording. Or returns false, says in *error what is wrong and what to do, and leaves
// *recording as it was. Time and memory are in proportion to `bytes`, whatever the bytes say.
[[nodiscard]] bool decode_recording(const uint8_t* data, size_t bytes, Recording* recording, std::string* error);

// The same for a file. A Failure names the file.
void save_recording(const Recording& recording, const std::string& path);
Recording load_recording(const std::string& path);

}  // namespace sandglass::host
