// See recording.h. Numbers are written and read byte by byte, so the file does not depend on this machine's byte order
// or padding.
#include "models/simulation/recording.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "runtime/math/hash.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_grains_only = 0x100;  // a flag in the number of a collider's shape

// The line ends in it reveal a transfer in text mode.
constexpr uint8_t k_magic[8] = {'S', 'G', 'R', 'E', 'C', '\r', '\n', 0x1a};
// Version 2 has the stage of shadows, version 3 also the stage of light, version 4 the ids of colliders, version 5 the stage of
// the skin, version 6 the names of stages.
constexpr uint32_t k_version = 6;
constexpr uint32_t k_oldest_version = 2;  // still read
constexpr size_t k_prologue_bytes = sizeof(k_magic) + sizeof(uint32_t);
constexpr size_t k_record_head_bytes = 2 * sizeof(uint32_t);
constexpr size_t k_checksum_bytes = sizeof(uint64_t);

enum RecordKind : uint32_t { k_record_header = 1, k_record_frame = 2, k_record_trailer = 3 };

// Writer and Reader have the same functions, so that one description of a payload serves both directions.
struct Writer {
  static constexpr uint32_t version = k_version;
  std::vector<uint8_t> out = {};

  bool ok() const { return true; }
  void u32(const uint32_t& value) {
    for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<uint8_t>(value >> shift));
  }
  void u64(const uint64_t& value) {
    u32(static_cast<uint32_t>(value));
    u32(static_cast<uint32_t>(value >> 32));
  }
  void floats(const float* values, size_t count) {
    for (size_t i = 0; i < count; ++i) u32(std::bit_cast<uint32_t>(values[i]));
  }
  // A length, and that many bytes.
  void bytes(const auto& content) {
    u32(static_cast<uint32_t>(content.size()));
    out.insert(out.end(), content.begin(), content.end());
  }
  void count(const auto& items, size_t) { u32(static_cast<uint32_t>(items.size())); }
};

// Takes bytes off the front. Once bytes are missing, every further value is 0 and `short_of_bytes` stays true.
struct Reader {
  const uint8_t* at;
  size_t left;
  uint32_t version;
  bool short_of_bytes = false;

  bool ok() const { return !short_of_bytes && left == 0; }
  std::span<const uint8_t> take(size_t size) {
    if (size > left) {
      short_of_bytes = true;
      left = 0;
      return {};
    }
    left -= size;
    at += size;
    return {at - size, size};
  }
  void u32(uint32_t& value) {
    const std::span<const uint8_t> four = take(sizeof value);
    value = 0;
    for (size_t i = four.size(); i > 0; --i) value = value << 8 | four[i - 1];
  }
  void u64(uint64_t& value) {
    uint32_t low, high;
    u32(low);
    u32(high);
    value = low | static_cast<uint64_t>(high) << 32;
  }
  void floats(float* values, size_t count) {
    for (uint32_t bits; count > 0; --count) {
      u32(bits);
      *values++ = std::bit_cast<float>(bits);
    }
  }
  void bytes(auto& content) {
    uint32_t size;
    u32(size);
    const std::span<const uint8_t> taken = take(size);
    content.assign(taken.begin(), taken.end());
  }
  // Refuses more items than the bytes that are left can hold.
  void count(auto& items, size_t bytes_each) {
    uint32_t size;
    u32(size);
    if (size > left / bytes_each) short_of_bytes = true;
    else items.resize(size);
  }
};

void transfer_header(auto* io, auto* recording) {
  io->u64(recording->start_hash);
  io->bytes(recording->scene_name);
  io->bytes(recording->description);
}

// The names of stages, by their numbers in this file.
void transfer_stages(auto* io, auto* names) {
  io->count(*names, sizeof(uint32_t));
  for (auto& name : *names) io->bytes(name);
}

// The number that each stage of a file has in this program; SANDGLASS_STAGE_COUNT: none.
std::vector<uint32_t> numbers_of(const std::vector<std::string>& names) {
  std::vector<uint32_t> numbers;
  for (const std::string& name : names) {
    uint32_t stage = 0;
    const std::string now = name == "lighting" ? "light" : name;  // as it was called before
    while (stage < SANDGLASS_STAGE_COUNT && now != sandglass_stage_name(stage)) ++stage;
    numbers.push_back(stage);
  }
  return numbers;
}

// The same of files without names.
std::vector<uint32_t> numbers_of_version(uint32_t version) {
  std::vector<uint32_t> numbers = {SANDGLASS_STAGE_GRANULAR};
  if (version >= 3) numbers.push_back(SANDGLASS_STAGE_LIGHT);
  if (version >= 5) numbers.push_back(SANDGLASS_STAGE_SKIN);
  for (const uint32_t stage : {SANDGLASS_STAGE_SHADOW, SANDGLASS_STAGE_REFINE, SANDGLASS_STAGE_OUTPUT})
    numbers.push_back(stage);
  return numbers;
}

// Returns false when the payload is malformed, as the next does.
bool transfer_frame(auto* io, RecordedFrame* frame, const std::vector<uint32_t>& stages) {
  constexpr size_t k_collider_bytes = sizeof(uint32_t) * (1 + 3 + 4 + 3 + 3 + 3);
  io->floats(&frame->time_step, 1);
  io->u64(frame->budget_ns);
  io->count(frame->colliders, k_collider_bytes);
  for (sandglass_collider& collider : frame->colliders) {
    uint32_t shape = static_cast<uint32_t>(collider.shape) | (collider.grains_only != 0 ? k_grains_only : 0);
    io->u32(shape);
    collider.shape = static_cast<sandglass_shape>(shape & ~k_grains_only);
    collider.grains_only = (shape & k_grains_only) != 0 ? 1 : 0;
    io->floats(collider.position, 3);
    io->floats(collider.rotation, 4);
    io->floats(collider.size, 3);
    io->floats(collider.linear_velocity, 3);
    io->floats(collider.angular_velocity, 3);
    if (io->version >= 4) io->u32(collider.id);
  }
  sandglass_plan& plan = frame->plan;
  plan.struct_size = sizeof plan;
  io->u32(plan.level);
  io->u32(plan.run_count);
  if (plan.run_count > SANDGLASS_PLAN_RUNS) return false;
  for (uint32_t i = 0; i < plan.run_count; ++i) {
    io->u32(plan.runs[i].stage);
    io->u32(plan.runs[i].units);
    if (plan.runs[i].stage >= stages.size() || stages[plan.runs[i].stage] >= SANDGLASS_STAGE_COUNT) return false;
    plan.runs[i].stage = stages[plan.runs[i].stage];
  }
  return io->ok();
}

bool transfer_trailer(auto* io, uint64_t frames, auto* recording) {
  const uint64_t all = frames;
  io->u64(frames);
  io->u64(recording->final_hash);
  return io->ok() && frames == all;
}

void put_record(Writer* file, uint64_t* sum, RecordKind kind, const Writer& payload) {
  const size_t start = file->out.size();
  file->u32(kind);
  file->bytes(payload.out);
  *sum = hash_bytes(file->out.data() + start, file->out.size() - start, *sum);
  file->u64(*sum);
}

// An error text completes the sentence "it ...".
bool fail(std::string* error, std::string rest) {
  *error = std::move(rest);
  return false;
}

std::string in_record(size_t index) { return " in record " + std::to_string(index) + ". Record the run again."; }

}  // namespace

std::vector<uint8_t> encode_recording(const Recording& recording) {
  Writer file = {{k_magic, k_magic + sizeof(k_magic)}}, header, trailer;
  file.u32(k_version);
  uint64_t sum = hash_bytes(file.out.data(), file.out.size());
  transfer_header(&header, &recording);
  std::vector<std::string> names;
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) names.emplace_back(sandglass_stage_name(stage));
  transfer_stages(&header, &names);
  put_record(&file, &sum, k_record_header, header);
  for (RecordedFrame frame : recording.frames) {
    Writer payload;
    frame.plan.run_count = std::min<uint32_t>(frame.plan.run_count, SANDGLASS_PLAN_RUNS);
    transfer_frame(&payload, &frame, numbers_of(names));
    put_record(&file, &sum, k_record_frame, payload);
  }
  transfer_trailer(&trailer, recording.frames.size(), &recording);
  put_record(&file, &sum, k_record_trailer, trailer);
  return file.out;
}

bool decode_recording(const uint8_t* data, size_t bytes, Recording* recording, std::string* error) {
  if (bytes < k_prologue_bytes) return fail(error, "is too short for a recording. Record the run again.");
  if (!std::equal(k_magic, k_magic + sizeof(k_magic), data))
    return fail(error, "is not a recording. Name a file that --record wrote.");
  Reader file = {data + sizeof(k_magic), bytes - sizeof(k_magic), 0};
  file.u32(file.version);
  if (file.version < k_oldest_version || file.version > k_version)
    return fail(error, "has version " + std::to_string(file.version) + ", and this program reads versions " +
                           std::to_string(k_oldest_version) + " to " + std::to_string(k_version) +
                           ". Replay it with the program that recorded it.");
  uint64_t sum = hash_bytes(data, k_prologue_bytes);
  Recording result;
  std::vector<uint32_t> stages = numbers_of_version(file.version);
  for (size_t index = 0;; ++index) {
    const uint8_t* start = file.at;
    uint32_t kind, size;
    uint64_t checksum;
    file.u32(kind);
    file.u32(size);
    const std::span<const uint8_t> content = file.take(size);
    if (file.short_of_bytes || file.left < k_checksum_bytes) return fail(error, "ends" + in_record(index));
    sum = hash_bytes(start, k_record_head_bytes + size, sum);
    file.u64(checksum);
    if (checksum != sum) return fail(error, "was damaged: the checksum is wrong" + in_record(index));

    Reader payload = {content.data(), content.size(), file.version};
    if ((index == 0) != (kind == k_record_header))
      return fail(error, "has its records out of order" + in_record(index));
    if (kind == k_record_header) {
      std::vector<std::string> names;
      transfer_header(&payload, &result);
      if (file.version >= 6) transfer_stages(&payload, &names);
      if (!payload.ok()) return fail(error, "has a malformed header" + in_record(index));
      if (file.version >= 6) stages = numbers_of(names);
    } else if (kind == k_record_frame) {
      if (!transfer_frame(&payload, &result.frames.emplace_back(), stages))
        return fail(error, "has a malformed frame" + in_record(index));
    } else if (kind == k_record_trailer) {
      if (!transfer_trailer(&payload, result.frames.size(), &result) || file.left != 0)
        return fail(error, "has a trailer that does not match the rest" + in_record(index));
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
