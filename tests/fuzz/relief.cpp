// A relief of any images, meshes, outlines, poses and bytes: each is refused by a sentence and changes nothing, or it is done. Nothing is
// read beyond the rows of an image and the arrays of a mesh; heights stay what a relief may have; the same comes out twice; and what is saved shows
// the same heights elsewhere.
#include <cmath>
#include <vector>

#include "runtime/math/hash.h"
#include "runtime/math/random.h"
#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"

namespace {

using sandglass::fuzz::expect;

constexpr uint32_t k_turns = 4, k_side = 40;  // pixels
constexpr uint32_t k_corners = 8, k_rings = 3, k_vertices = 9;

// What is called before the images of a turn, and the image; the pointers and sizes of its rows are made right.
struct Turn {
  sandglass_depth_image image = sandglass::depth_image();
  float position[3] = {}, rotation[4] = {0, 0, 0, 1};
  uint32_t has_confidence = 1, has_mask = 1, looks = 3, resets = 0;
  uint8_t edits[2 * sandglass::fuzz::k_edit_bytes];  // of the saved bytes
  float corners[2 * k_corners], vertices[3 * k_vertices];
  uint32_t rings = 1, counts[k_rings] = {5, 3, 3}, indices[3 * k_vertices];
  sandglass_cast_mesh mesh = sandglass::cast_mesh();
};
struct Input {
  sandglass_relief_desc desc = sandglass::relief_desc();
  Turn turns[k_turns];
};

Input drawn(const uint8_t* data, size_t size) {
  sandglass::Random random{sandglass::hash_bytes(data, size)};
  Input input;
  input.desc.cells[0] = 16 + random.below(20);
  input.desc.cells[1] = 16 + random.below(20);
  input.desc.cell = 0.02f;
  for (Turn& t : input.turns) {
    sandglass_depth_image& i = t.image;
    i.format = static_cast<int32_t>(random.below(2));
    i.width = k_side;
    i.height = k_side - random.below(20);
    i.stride = (random.below(2) != 0 ? 1 : -1) * static_cast<int32_t>(4 * k_side + random.below(9));
    i.confidence_stride = i.mask_stride = static_cast<int32_t>(k_side + random.below(5));
    i.confidence_min = random.below(3);
    i.focal_x = i.focal_y = 0.8f * k_side;
    i.centre_x = i.centre_y = 0.25f * k_side;
    i.position[1] = 0.3f + 0.01f * static_cast<float>(random.below(40));
    i.orientation[0] = -0.7f + 0.01f * static_cast<float>(random.below(30));
    i.orientation[3] = 0.7f;
    i.timestamp_ns = random.below(4);
    t.has_mask = random.below(2);
    t.has_confidence = random.below(2);
    t.resets = random.below(16) == 0 ? 1 : 0;
    const auto near = [&random](float half) { return half * (0.001f * static_cast<float>(random.below(2000)) - 1); };
    for (float& x : t.corners) x = near(0.4f);
    for (float& x : t.vertices) x = near(0.4f);
    for (uint32_t& index : t.indices) index = random.below(k_vertices);
    t.rings = random.below(3);
    t.mesh.triangle_count = random.below(k_vertices);
    t.mesh.index_bytes = 2 + 2 * random.below(2);
    t.mesh.version = random.below(3);
    for (uint8_t& byte : t.edits) byte = static_cast<uint8_t>(random.below(256));
  }
  return sandglass::fuzz::edited(input, data, size);
}

// Rows on the heap, of exactly their bytes: what is read beyond them, the address sanitizer sees.
struct Rows {
  std::vector<uint8_t> bytes;
  const uint8_t* first(int32_t* stride, uint32_t row, uint32_t rows, sandglass::Random* random, bool depth) {
    *stride %= 1024;
    const uint32_t step = static_cast<uint32_t>(std::abs(*stride));
    bytes.resize(step * (rows - 1) + row);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random->below(256));
    for (size_t i = 0; depth && i + 1 < bytes.size(); i += 2)  // about half a metre, with holes
      sandglass::fuzz::put(&bytes, i, static_cast<uint16_t>(random->below(8) == 0 ? 0 : 480 + random->below(60)));
    return bytes.data() + (*stride < 0 ? step * (rows - 1) : 0);
  }
};

void check(const sandglass::Relief& relief) {
  const sandglass_heights h = relief.heights();
  for (uint32_t i = 0; i < h.cells[0] * h.cells[1]; ++i)
    expect((h.heights[i] >= -0.031f && h.heights[i] <= 0.501f) || h.heights[i] == SANDGLASS_RELIEF_GONE);
  for (int k = 0; k < 2; ++k) expect(h.low[k] <= h.high[k] && h.high[k] <= h.cells[k]);
  for (int k = 0; k < 3; ++k) expect(std::isfinite(h.corner[k] + h.along[k] + h.across[k] + h.up[k]));
  expect(h.depth_scale > 0.9f && h.depth_scale < 1.1f);
}

bool same_heights(const sandglass::Relief& a, const sandglass::Relief& b) {
  const sandglass_heights x = a.heights(), y = b.heights();
  return std::memcmp(x.heights, y.heights, sizeof(float) * x.cells[0] * x.cells[1]) == 0;
}

void show(const Turn& turn, sandglass::Random random, sandglass::Relief* reliefs) {
  sandglass_depth_image image = turn.image;
  image.struct_size = sizeof image;
  Rows depth, confidence, mask;
  image.width = std::max(image.width % (k_side + 1), 2u);
  image.height = std::max(image.height % (k_side + 1), 2u);
  image.depth = depth.first(&image.stride, image.width * (image.format == SANDGLASS_DEPTH_U16 ? 2 : 4), image.height,
                            &random, image.format == SANDGLASS_DEPTH_U16);
  image.confidence = confidence.first(&image.confidence_stride, image.width, image.height, &random, false);
  image.mask = mask.first(&image.mask_stride, image.width, image.height, &random, false);
  if (turn.has_confidence % 2 == 0) image.confidence = nullptr;
  if (turn.has_mask % 2 == 0) image.mask = nullptr;
  for (uint32_t look = 0; look < 1 + turn.looks % 9; ++look) {
    const uint64_t before = reliefs[0].hash();
    int32_t status[2];
    for (int k = 0; k < 2; ++k) {
      const char* reason = nullptr;
      status[k] = sandglass_relief_set_image(reliefs[k].get(), &image, nullptr, &reason);
      expect((status[k] == SANDGLASS_OK) == (reason == nullptr));
    }
    expect(status[0] == status[1] && (status[0] == SANDGLASS_OK || reliefs[0].hash() == before));
    image.timestamp_ns += image.timestamp_ns % 4;
  }
}

// The same outline on all; meshes on two of them, unit by unit on one.
void tell(const Turn& turn, bool has_room, sandglass::Relief* reliefs, sandglass::Relief* other) {
  std::vector<uint32_t> counts(turn.counts, turn.counts + turn.rings % (k_rings + 1));
  size_t corners = 0;
  for (uint32_t& count : counts) corners += count %= k_corners + 1;
  std::vector<float> outline(2 * corners);
  for (size_t i = 0; i < outline.size(); ++i) outline[i] = turn.corners[i % std::size(turn.corners)];
  int32_t status[3];
  sandglass::Relief* const all[3] = {&reliefs[0], &reliefs[1], other};
  for (int k = 0; k < 3; ++k)
    status[k] = sandglass_relief_set_outline(all[k]->get(), outline.data(), counts.data(),
                                             static_cast<uint32_t>(counts.size()), nullptr);
  expect(status[0] == status[1] && status[0] == status[2]);

  sandglass_cast_mesh mesh = turn.mesh;
  mesh.vertex_count %= k_vertices + 1;
  if (mesh.vertex_count == 0) mesh.vertex_count = k_vertices;
  mesh.triangle_count %= k_vertices + 1;
  mesh.stride = mesh.stride % 20 + 12;
  const std::vector<float> positions(turn.vertices, turn.vertices + 3 * mesh.vertex_count);
  std::vector<float> spread(static_cast<size_t>(mesh.stride) / 4 * (mesh.vertex_count - 1) + 3);
  for (size_t i = 0; i < positions.size(); ++i) spread[i / 3 * (mesh.stride / 4) + i % 3] = positions[i];
  std::vector<uint8_t> indices(size_t{3} * mesh.triangle_count * (mesh.index_bytes == 2 ? 2 : 4));
  for (uint32_t i = 0; i < 3 * mesh.triangle_count; ++i)
    std::memcpy(&indices[i * indices.size() / (3 * mesh.triangle_count)], &turn.indices[i],
                mesh.index_bytes == 2 ? 2 : 4);
  mesh.positions = spread.data();
  mesh.indices = indices.data();
  for (int k = 0; k < 2; ++k) {
    status[k] = sandglass_relief_set_meshes(reliefs[k].get(), &mesh, 1, nullptr);
    while (reliefs[k].run(k == 0 ? UINT32_MAX : 1) != 0) {
    }
  }
  expect(status[0] == status[1]);
  for (int k = 0; k < 2; ++k) {
    expect(sandglass_relief_set_meshes(reliefs[k].get(), nullptr, turn.looks % 2 == 0 ? 0 : 1, nullptr) ==
           (turn.looks % 2 == 0 ? SANDGLASS_OK : SANDGLASS_ERROR_INVALID_ARGUMENT));
    mesh.triangle_count = 0;
    expect((sandglass_relief_set_meshes(reliefs[k].get(), &mesh, 1, nullptr) == SANDGLASS_OK) == has_room);
  }
}

// Bytes that were changed, but for kind, version and checksum.
void restore_forged(const Turn& turn, sandglass::Relief* reliefs) {
  constexpr size_t k_checksum_at = 8, k_checked_from = 16;
  std::vector<std::byte> saved;
  expect(static_cast<bool>(reliefs[0].save(&saved)));
  const auto* from = reinterpret_cast<const uint8_t*>(saved.data());
  std::vector<uint8_t> file(from, from + saved.size());
  sandglass::fuzz::apply_edits(turn.edits, sizeof turn.edits, &file);
  if (file.size() > k_checked_from && turn.looks % 8 != 7) {
    std::memcpy(file.data(), from, k_checksum_at);
    sandglass::fuzz::put(&file, k_checksum_at,
                         sandglass::hash_bytes(file.data() + k_checked_from, file.size() - k_checked_from));
  }
  const uint64_t before = reliefs[0].hash();
  int32_t status[2];
  for (int k = 0; k < 2; ++k) status[k] = sandglass_relief_restore(reliefs[k].get(), file.data(), file.size(), nullptr);
  expect(status[0] == status[1] && (status[0] == SANDGLASS_OK || reliefs[0].hash() == before));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Input input = drawn(data, size);
  input.desc.struct_size = sizeof input.desc;
  for (uint32_t& cells : input.desc.cells) cells %= 257;
  input.desc.mesh_capacity %= 3;
  sandglass::Relief reliefs[2], other;
  for (sandglass::Relief& relief : reliefs)
    if (!relief.create(input.desc)) return 0;
  expect(static_cast<bool>(other.create(input.desc)));
  sandglass::Random random{sandglass::hash_bytes(data, size) + 1};
  for (const Turn& turn : input.turns) {
    int32_t moved[2];
    for (int k = 0; k < 2; ++k)
      moved[k] = sandglass_relief_set_plane(reliefs[k].get(), turn.position, turn.rotation, nullptr);
    expect(moved[0] == moved[1]);
    for (sandglass::Relief& relief : reliefs)
      if (turn.resets == 1) relief.reset();
    tell(turn, input.desc.mesh_capacity != 0, reliefs, &other);
    show(turn, random, reliefs);
    random.next();
    restore_forged(turn, reliefs);
    check(reliefs[0]);
    expect(reliefs[0].hash() == reliefs[1].hash() && same_heights(reliefs[0], reliefs[1]));
    std::vector<std::byte> saved;
    expect(reliefs[0].save(&saved) && other.restore(saved) && same_heights(reliefs[0], other));
  }
  return 0;
}
