// See recording.h. Numbers are written and read byte by byte, so the file does not depend on this machine's byte order
// or padding.
#include "models/simulation/recording.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "runtime/core/hash.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_grains_only = 0x100;  // a flag in the number of a collider's shape

// The line ends in it reveal a transfer in text mode.
constexpr uint8_t k_magic[8] = {'S', 'G', 'R', 'E', 'C', '\r', '\n', 0x1a};
// Version 2 has the stage of shadows, version 3 also the stage of light.
constexpr uint32_t k_version = 3;
constexpr uint32_t k_oldest_version = 2;  // still read
constexpr size_t k_prologue_bytes = sizeof(k_magic) + sizeof(uint32_t);
constexpr size_t k_record_head_bytes = 2 * sizeof(uint32_t);
constexpr size_t k_checksum_bytes = sizeof(uint64_t);

enum RecordKind : uint32_t { k_record_header = 1, k_record_frame = 2, k_record_trailer = 3 };

// ---------------------------------------------------------------------------------------------------- writing

void put_u32(std::vector<uint8_t>* out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out->push_back(static_cast<uint8_t>(value >> shift));
}

void put_u64(std::vector<uint8_t>* out, uint64_t value) {
  put_u32(out, static_cast<uint32_t>(value));
  put_u32(out, static_cast<uint32_t>(value >> 32));
}

void put_floats(std::vector<uint8_t>* out, const float* values, size_t count) {
  for (size_t i = 0; i < count; ++i) put_u32(out, std::bit_cast<uint32_t>(values[i]));
}

void put_bytes(std::vector<uint8_t>* out, const uint8_t* data, size_t bytes) {
  put_u32(out, static_cast<uint32_t>(bytes));
  out->insert(out->end(), data, data + bytes);
}

void put_record(std::vector<uint8_t>* out, uint64_t* sum, RecordKind kind, const std::vector<uint8_t>& payload) {
  const size_t start = out->size();
  put_u32(out, kind);
  put_bytes(out, payload.data(), payload.size());
  *sum = hash_bytes(out->data() + start, out->size() - start, *sum);
  put_u64(out, *sum);
}

std::vector<uint8_t> header_payload(const Recording& recording) {
  std::vector<uint8_t> payload;
  put_u64(&payload, recording.start_hash);
  put_bytes(&payload, reinterpret_cast<const uint8_t*>(recording.scene_name.data()), recording.scene_name.size());
  put_bytes(&payload, recording.description.data(), recording.description.size());
  return payload;
}

std::vector<uint8_t> frame_payload(const RecordedFrame& frame) {
  std::vector<uint8_t> payload;
  put_floats(&payload, &frame.time_step, 1);
  put_u64(&payload, frame.budget_ns);
  put_u32(&payload, static_cast<uint32_t>(frame.colliders.size()));
  for (const sandglass_collider& collider : frame.colliders) {
    put_u32(&payload, static_cast<uint32_t>(collider.shape) | (collider.grains_only != 0 ? k_grains_only : 0));
    put_floats(&payload, collider.position, 3);
    put_floats(&payload, collider.rotation, 4);
    put_floats(&payload, collider.size, 3);
    put_floats(&payload, collider.linear_velocity, 3);
    put_floats(&payload, collider.angular_velocity, 3);
  }
  put_u32(&payload, frame.plan.level);
  const uint32_t runs = std::min<uint32_t>(frame.plan.run_count, SANDGLASS_PLAN_RUNS);
  put_u32(&payload, runs);
  for (uint32_t i = 0; i < runs; ++i) {
    put_u32(&payload, frame.plan.runs[i].stage);
    put_u32(&payload, frame.plan.runs[i].units);
  }
  return payload;
}

// ---------------------------------------------------------------------------------------------------- reading

// Takes bytes off the front. Once bytes are missing, every further value is 0 and `short_of_bytes` stays true.
struct Reader {
  const uint8_t* at;
  size_t left;
  bool short_of_bytes = false;

  uint32_t u32() {
    if (left < sizeof(uint32_t)) {
      short_of_bytes = true;
      left = 0;
      return 0;
    }
    uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | at[i];
    at += sizeof(uint32_t);
    left -= sizeof(uint32_t);
    return value;
  }
  uint64_t u64() {
    const uint64_t low = u32();
    return low | static_cast<uint64_t>(u32()) << 32;
  }
  void floats(float* values, size_t count) {
    for (size_t i = 0; i < count; ++i) values[i] = std::bit_cast<float>(u32());
  }
  // Reads a length and that many bytes.
  std::pair<const uint8_t*, size_t> bytes() {
    const uint32_t count = u32();
    if (count > left) {
      short_of_bytes = true;
      left = 0;
      return {at, 0};
    }
    const uint8_t* start = at;
    at += count;
    left -= count;
    return {start, count};
  }
};

constexpr size_t k_collider_bytes = sizeof(uint32_t) * (1 + 3 + 4 + 3 + 3 + 3);

bool parse_header(Reader payload, Recording* recording) {
  recording->start_hash = payload.u64();
  const auto [name, name_bytes] = payload.bytes();
  recording->scene_name.assign(reinterpret_cast<const char*>(name), name_bytes);
  const auto [description, description_bytes] = payload.bytes();
  recording->description.assign(description, description + description_bytes);
  return !payload.short_of_bytes && payload.left == 0;
}

bool parse_frame(Reader payload, uint32_t version, RecordedFrame* frame) {
  payload.floats(&frame->time_step, 1);
  frame->budget_ns = payload.u64();
  const uint32_t colliders = payload.u32();
  if (colliders > payload.left / k_collider_bytes) return false;
  frame->colliders.resize(colliders);
  for (sandglass_collider& collider : frame->colliders) {
    const uint32_t shape = payload.u32();
    collider.shape = static_cast<sandglass_shape>(shape & ~k_grains_only);
    collider.grains_only = (shape & k_grains_only) != 0 ? 1 : 0;
    payload.floats(collider.position, 3);
    payload.floats(collider.rotation, 4);
    payload.floats(collider.size, 3);
    payload.floats(collider.linear_velocity, 3);
    payload.floats(collider.angular_velocity, 3);
  }
  frame->plan.struct_size = sizeof(sandglass_plan);
  frame->plan.level = payload.u32();
  frame->plan.run_count = payload.u32();
  if (frame->plan.run_count > SANDGLASS_PLAN_RUNS) return false;
  for (uint32_t i = 0; i < frame->plan.run_count; ++i) {
    frame->plan.runs[i].stage = payload.u32();
    // In version 2 there was no stage of light between sand and shadows, so later stages had a smaller number.
    if (version < 3 && frame->plan.runs[i].stage >= SANDGLASS_STAGE_LIGHTING) ++frame->plan.runs[i].stage;
    frame->plan.runs[i].units = payload.u32();
    if (frame->plan.runs[i].stage >= SANDGLASS_STAGE_COUNT) return false;
  }
  return !payload.short_of_bytes && payload.left == 0;
}

// An error text completes the sentence "it ...".
bool fail(std::string* error, std::string rest) {
  *error = std::move(rest);
  return false;
}

std::string in_record(size_t index) { return " in record " + std::to_string(index) + ". Record the run again."; }

}  // namespace

std::vector<uint8_t> encode_recording(const Recording& recording) {
  std::vector<uint8_t> out(k_magic, k_magic + sizeof(k_magic));
  put_u32(&out, k_version);
  uint64_t sum = hash_bytes(out.data(), out.size());
  put_record(&out, &sum, k_record_header, header_payload(recording));
  for (const RecordedFrame& frame : recording.frames) put_record(&out, &sum, k_record_frame, frame_payload(frame));
  std::vector<uint8_t> trailer;
  put_u64(&trailer, recording.frames.size());
  put_u64(&trailer, recording.final_hash);
  put_record(&out, &sum, k_record_trailer, trailer);
  return out;
}

bool decode_recording(const uint8_t* data, size_t bytes, Recording* recording, std::string* error) {
  if (bytes < k_prologue_bytes) return fail(error, "is too short for a recording. Record the run again.");
  for (size_t i = 0; i < sizeof(k_magic); ++i) {
    if (data[i] != k_magic[i]) return fail(error, "is not a recording. Name a file that --record wrote.");
  }
  Reader file = {data + sizeof(k_magic), bytes - sizeof(k_magic)};
  const uint32_t version = file.u32();
  if (version < k_oldest_version || version > k_version) {
    return fail(error, "has version " + std::to_string(version) + ", and this program reads versions " +
                           std::to_string(k_oldest_version) + " to " + std::to_string(k_version) +
                           ". Replay it with the program that recorded it.");
  }
  uint64_t sum = hash_bytes(data, k_prologue_bytes);
  Recording result;
  for (size_t index = 0;; ++index) {
    const uint8_t* start = file.at;
    const uint32_t kind = file.u32();
    const auto [payload, payload_bytes] = file.bytes();
    if (file.short_of_bytes || file.left < k_checksum_bytes) {
      return fail(error, "ends" + in_record(index));
    }
    sum = hash_bytes(start, k_record_head_bytes + payload_bytes, sum);
    if (file.u64() != sum) return fail(error, "was damaged: the checksum is wrong" + in_record(index));

    const bool first = index == 0;
    if (first != (kind == k_record_header)) return fail(error, "has its records out of order" + in_record(index));
    if (kind == k_record_header) {
      if (!parse_header({payload, payload_bytes}, &result))
        return fail(error, "has a malformed header" + in_record(index));
    } else if (kind == k_record_frame) {
      RecordedFrame frame;
      if (!parse_frame({payload, payload_bytes}, version, &frame))
        return fail(error, "has a malformed frame" + in_record(index));
      result.frames.push_back(std::move(frame));
    } else if (kind == k_record_trailer) {
      Reader trailer = {payload, payload_bytes};
      const uint64_t frames = trailer.u64();
      result.final_hash = trailer.u64();
      if (trailer.short_of_bytes || trailer.left != 0 || frames != result.frames.size() || file.left != 0) {
        return fail(error, "has a trailer that does not match the rest" + in_record(index));
      }
      *recording = std::move(result);
      return true;
    } else {
      return fail(error, "has an unknown kind" + in_record(index));
    }
  }
}

void save_recording(const Recording& recording, const std::string& path) {
  const std::vector<uint8_t> bytes = encode_recording(recording);
  write_file(path, std::span<const uint8_t>(bytes));
}

Recording load_recording(const std::string& path) {
  const std::string bytes = read_file(path, "recording");
  Recording recording;
  std::string error;
  if (!decode_recording(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), &recording, &error)) {
    throw cannot("read", path, "it " + error);
  }
  return recording;
}

}  // namespace sandglass::host
