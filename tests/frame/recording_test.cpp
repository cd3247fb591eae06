// A recording is read back as it was written, and wrong bytes are refused: every truncation, changed bits, and records
// that are dropped, doubled and swapped. (Forged ones: tests/fuzz/recording.cpp.)
#include "models/simulation/recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>

#include "models/files/failure.h"
#include "tests/damaged_file.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

Recording small_recording() {
  Recording recording;
  recording.scene_name = "column14k";
  recording.start_hash = 0x0123456789abcdefu;
  recording.description = {1, 2, 3, 250};
  recording.final_hash = 0xfedcba9876543210u;
  for (uint32_t f = 0; f < 3; ++f) {
    RecordedFrame frame;
    frame.time_step = 0.01f * static_cast<float>(f + 1);
    frame.budget_ns = 4000000 + f;
    frame.colliders.resize(f);
    for (sandglass_collider& collider : frame.colliders) {
      collider = {SANDGLASS_SHAPE_BOX,
                  {1, 2, 3},
                  {0, 0, 0, 1},
                  {0.1f, 0.2f, 0.3f},
                  {-1, -0.0f, 1e-40f},
                  {4, 5, 6},
                  0,
                  nullptr,
                  7 + f,
                  nullptr};
      collider.position[0] =
          std::numeric_limits<float>::quiet_NaN();  // an app may have passed it, so a replay must too
    }
    frame.plan.struct_size = sizeof(sandglass_plan);
    frame.plan.level = f;
    frame.plan.run_count = f + 1;
    for (uint32_t r = 0; r <= f; ++r) frame.plan.runs[r] = {r % SANDGLASS_STAGE_COUNT, 100 * f + r + 1};
    recording.frames.push_back(frame);
  }
  return recording;
}

bool same(const Recording& a, const Recording& b) {
  bool equal = a.scene_name == b.scene_name && a.start_hash == b.start_hash && a.description == b.description &&
               a.final_hash == b.final_hash && a.frames.size() == b.frames.size();
  for (size_t i = 0; equal && i < a.frames.size(); ++i) {
    const RecordedFrame& x = a.frames[i];
    const RecordedFrame& y = b.frames[i];
    equal = x.time_step == y.time_step && x.budget_ns == y.budget_ns && x.colliders.size() == y.colliders.size() &&
            std::memcmp(&x.plan, &y.plan, sizeof(x.plan)) == 0;
    for (size_t c = 0; equal && c < x.colliders.size(); ++c) {
      equal =
          std::memcmp(&x.colliders[c], &y.colliders[c], sizeof(sandglass_collider)) == 0;  // bits: NaN, -0, denormals
    }
  }
  return equal;
}

bool decodes(const std::vector<uint8_t>& bytes, Recording* recording, std::string* error) {
  return decode_recording(bytes.data(), bytes.size(), recording, error);
}

TEST(Recording, ComesBackAsItWasWritten) {
  const Recording recording = small_recording();
  Recording back;
  std::string error;
  ASSERT_TRUE(decodes(encode_recording(recording), &back, &error)) << error;
  EXPECT_TRUE(same(recording, back));
  ASSERT_TRUE(decodes(encode_recording({}), &back, &error)) << error;
  EXPECT_TRUE(same({}, back));
}

TEST(Recording, StartsWithTheDocumentedBytes) {
  const std::vector<uint8_t> bytes = encode_recording({});
  const uint8_t expected[] = {'S', 'G', 'R', 'E', 'C', '\r', '\n', 0x1a, 6, 0, 0, 0, 1, 0, 0, 0, 89, 0, 0, 0};
  ASSERT_GE(bytes.size(), sizeof(expected));
  EXPECT_EQ(std::memcmp(bytes.data(), expected, sizeof(expected)), 0);
}

TEST(Recording, EveryTruncationAndChangedBitIsRefusedWithASentence) {
  tests::expect_only_whole_taken(encode_recording(small_recording()), [](const std::vector<uint8_t>& bytes) {
    Recording back;
    std::string error;
    if (decodes(bytes, &back, &error)) return true;
    EXPECT_NE(error.find(". "), std::string::npos) << error;  // first what is wrong, then what to do
    EXPECT_TRUE(same(back, {})) << "a failed read changed the result";
    return false;
  });
}

// Where every record starts. The last entry is the end.
std::vector<size_t> record_starts(const std::vector<uint8_t>& bytes) {
  std::vector<size_t> starts = {12};
  while (starts.back() < bytes.size()) {
    const uint8_t* size = &bytes[starts.back() + 4];
    starts.push_back(starts.back() + 16 + (size[0] | static_cast<size_t>(size[1]) << 8));
  }
  return starts;
}

TEST(Recording, RecordsCannotBeDroppedDoubledSwappedOrAppended) {
  const std::vector<uint8_t> bytes = encode_recording(small_recording());
  const std::vector<size_t> starts = record_starts(bytes);
  ASSERT_EQ(starts.size(), 6u);  // header, three frames, trailer, end
  for (const std::string order : {"0134", "011234", "02134", "1234", "0123", "012344", "4", "04", ""}) {
    std::vector<uint8_t> changed(bytes.begin(), bytes.begin() + 12);
    for (const char name : order) {
      const size_t i = static_cast<size_t>(name - '0');
      changed.insert(changed.end(), &bytes[starts[i]], bytes.data() + starts[i + 1]);
    }
    Recording back;
    std::string error;
    EXPECT_FALSE(decodes(changed, &back, &error)) << order;
  }
}

TEST(Recording, GoesThroughAFileAndLeavesNothingElseBehind) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "run.sgrec";
  const Recording recording = small_recording();
  save_recording(recording, path);
  save_recording(recording, path);  // over an older one
  EXPECT_TRUE(same(recording, load_recording(path)));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);

  std::filesystem::resize_file(path, 40);
  EXPECT_THROW(load_recording(path), Failure);
  std::filesystem::remove_all(folder.path);
  EXPECT_THROW(load_recording(path), Failure);
  EXPECT_THROW(save_recording(recording, path), Failure);
}

}  // namespace
}  // namespace sandglass::host
