// A cast of any meshes, planes and lights, call after call: each is refused by a sentence, or done. What two sets of kernels
// draw in other divisions of the same units is the same to the byte; nothing is drawn beyond the plane's extent; it comes
// to an end, and what is as it was costs nothing.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "runtime/math/hash.h"
#include "runtime/math/random.h"
#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/other_kernels.h"
#include "tests/guarded_block.h"

namespace {

using sandglass::fuzz::expect;

constexpr uint32_t k_meshes = 2, k_vertices = 30, k_triangles = 60, k_turns = 4;
constexpr uint32_t k_units_max = 100'000;  // far more than any texture of this size needs
constexpr double k_large = 1000;           // metres; beyond, rounding is more than a texel

// What is set before some units run; the fuzzer changes it. An index beyond the vertices, now and then, is meant.
struct Turn {
  sandglass_cast_plane plane = sandglass::cast_plane();
  sandglass_cast_mesh meshes[k_meshes] = {sandglass::cast_mesh(), sandglass::cast_mesh()};
  float positions[3 * k_vertices];
  uint16_t indices[3 * k_triangles];
  float light[3] = {0.3f, 1, 0.2f}, diameter = 0.3f, cells[SANDGLASS_LIGHT_CELLS];
  uint32_t mesh_count = k_meshes, units = 40;
};
struct Input {
  sandglass_cast_desc desc = sandglass::cast_desc();
  Turn turns[k_turns];
};

// From the fuzzer's bytes as from a seed: meshes of all sizes about a plane, of which each turn changes a part.
Input drawn(const uint8_t* data, size_t size) {
  sandglass::Random random{sandglass::hash_bytes(data, size)};
  const auto even = [&](float low, float high) {
    return low + (high - low) * 0.001f * static_cast<float>(random.below(1001));
  };
  Input input;
  input.desc.texels = input.desc.ambient_texels = 64;
  input.desc.directions = 32;
  input.desc.triangle_capacity = k_triangles;
  input.desc.mesh_capacity = k_meshes;
  input.desc.reach = random.below(2) != 0 ? 2.0f : 0.0f;
  input.desc.layers = random.below(2) != 0 ? 1 : 1 + random.below(8);
  const float large = even(0.01f, 1);
  const bool odd = random.below(4) == 0;  // with corners that are not finite, or far away
  for (Turn& t : input.turns) {
    if (&t != input.turns) t = *(&t - 1);
    const bool first = &t == input.turns, redrawn = first || random.below(2) != 0;
    t.units = random.below(200);
    for (float& x : t.positions)
      if (redrawn)
        x = odd && random.below(8) == 0 ? sandglass::fuzz::odd_float(static_cast<uint8_t>(random.below(16)))
                                        : even(-large, large);
    for (uint16_t& i : t.indices)
      if (redrawn) i = static_cast<uint16_t>(random.below(k_vertices + (random.below(20) == 0 ? 9 : 0)));
    uint32_t left = k_triangles;
    for (sandglass_cast_mesh& mesh : t.meshes) {
      mesh.vertex_count = k_vertices;
      mesh.index_bytes = 2;
      mesh.version += redrawn ? 1 : 0;
      if (redrawn) {
        mesh.triangle_count = random.below(left + 1);
        left -= mesh.triangle_count;
      }
      if (first) {
        mesh.closed = random.below(2);
        mesh.is_real = random.below(2);
      }
      mesh.world_from_mesh[13] = even(-0.2f, 0.5f);
    }
    if (!first && random.below(2) != 0) continue;
    for (uint32_t axis = 0; axis < 2; ++axis) {
      t.plane.low[axis] = even(-1, 0);
      t.plane.high[axis] = t.plane.low[axis] + even(0.001f, 1);
    }
    for (float& x : t.plane.origin) x = even(-0.2f, 0.2f);
    for (float& x : t.plane.normal) x += even(-0.5f, 0.5f);
    t.plane.is_virtual = random.below(2);
    t.plane.height = even(0.001f, 1);
    for (float& x : t.light) x = even(-1, 1);
    t.diameter = even(0, 1.5f);
    for (float& cell : t.cells) cell = even(0, 2.0f / SANDGLASS_LIGHT_CELLS) * 0.5f;
  }
  return sandglass::fuzz::edited(input, data, size);
}

// Textures of one set of kernels, whose units run in parts of `part`.
struct Drawing {
  std::unique_ptr<sandglass::test::GuardedBlock> block;
  sandglass_cast* cast = nullptr;
  uint32_t part;

  int32_t begin(sandglass_cast_desc desc, sandglass_isa isa) {
    desc.isa = isa;
    desc.struct_size = sizeof desc;
    uint64_t bytes = 0;
    const char* reason = nullptr;
    const int32_t status = sandglass_cast_bytes(&desc, &bytes, &reason);
    expect((status == SANDGLASS_OK) == (reason == nullptr));
    if (status != SANDGLASS_OK) return status;
    block = std::make_unique<sandglass::test::GuardedBlock>(bytes);
    return sandglass_cast_create(&desc, block->data(), bytes, &cast, nullptr);
  }

  sandglass_texture texture(bool ambient) const {
    sandglass_texture t = {};
    t.struct_size = sizeof t;
    (ambient ? sandglass_cast_get_ambient : sandglass_cast_get_texture)(cast, &t);
    return t;
  }

  // Pointers are right: only what the library can check is forged. The arrays stay in *kept.
  std::vector<int32_t> set(const Turn& t, Turn* kept) const {
    Turn& own = *kept;
    own = t;
    own.plane.struct_size = sizeof own.plane;
    for (sandglass_cast_mesh& mesh : own.meshes) {
      mesh.stride %= 16;
      mesh.vertex_count %= k_vertices + 1;
      mesh.positions = own.positions;
      mesh.triangle_count %= k_triangles + 1;
      mesh.indices = mesh.index_bytes == 2 ? own.indices : nullptr;
      if (mesh.indices == nullptr) mesh.triangle_count = mesh.vertex_count / 3;
    }
    std::vector<int32_t> statuses;
    const char* reason = nullptr;
    const auto is = [&](int32_t status) {
      expect((status == SANDGLASS_OK) == (reason == nullptr));
      statuses.push_back(status);
    };
    is(sandglass_cast_set_plane(cast, &own.plane, &reason));
    is(sandglass_cast_set_meshes(cast, own.meshes, own.mesh_count % (k_meshes + 2), &reason));
    is(sandglass_cast_set_light(cast, own.light, own.diameter, &reason));
    is(sandglass_cast_set_cells(cast, own.cells, &reason));
    return statuses;
  }

  uint32_t run(uint32_t units) {
    uint32_t done = 0;
    while (done < units) {
      const uint32_t asked = std::min(part, units - done), ran = sandglass_cast_run(&cast, 1, asked);
      done += ran;
      if (ran < asked) break;
    }
    expect(block->guards_intact());
    return done;
  }
};

bool same(const sandglass_texture& a, const sandglass_texture& b) {
  const uint64_t bytes = uint64_t{a.layers} * a.side * a.side;
  return a.valid == b.valid && a.layers == b.layers && a.side == b.side && a.version == b.version &&
         a.behind == b.behind && (a.valid == 0 || bytes == 0 || std::memcmp(a.bytes, b.bytes, bytes) == 0);
}

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Numbers are finite, and without layers a texel that lies wholly beyond the plane's extent is as light as without any mesh.
void check(const sandglass_texture& t, const sandglass_cast_plane* plane, uint8_t light) {
  if (t.valid == 0) return;
  double corner[3], along[3], across[3];
  for (int k = 0; k < 3; ++k) {
    corner[k] = t.corner[k];
    along[k] = t.along[k];
    across[k] = t.across[k];
  }
  expect(std::isfinite(dot(corner, corner) + dot(along, along) + dot(across, across)));
  for (const float x : t.slide) expect(std::isfinite(x) && std::fabs(x) < 10);
  if (t.layers > 1) return;
  if (plane == nullptr || t.bytes == nullptr || dot(corner, corner) > k_large * k_large) return;
  double from[3];
  for (int k = 0; k < 3; ++k) from[k] = corner[k] - static_cast<double>(plane->origin[k]);
  const double wide = std::sqrt(dot(along, along)), high = std::sqrt(dot(across, across));
  if (!(wide > 0 && high > 0)) return;  // nothing is seen
  const auto outside = [&](double at, double texel, int axis) {
    return at < static_cast<double>(plane->low[axis]) - texel || at > static_cast<double>(plane->high[axis]) + texel;
  };
  for (uint32_t y = 0; y < t.side; ++y) {
    for (uint32_t x = 0; x < t.side; ++x) {
      double p[3];
      for (int k = 0; k < 3; ++k) p[k] = from[k] + ((x + 0.5) * along[k] + (y + 0.5) * across[k]) / t.side;
      if (outside(dot(p, along) / wide, wide / t.side, 0) || outside(dot(p, across) / high, high / t.side, 1))
        expect(t.bytes[y * t.side + x] == light);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const Input input = drawn(data, size);
  if (input.desc.triangle_capacity > 1000 || input.desc.texels > 128) return 0;  // would take too long, or are refused
  Drawing scalar = {nullptr, nullptr, UINT32_MAX}, other = {nullptr, nullptr, 3};
  const int32_t begun = scalar.begin(input.desc, SANDGLASS_ISA_SCALAR);
  expect(other.begin(input.desc, sandglass::fuzz::other_kernels(data, size)) == begun);
  if (begun != SANDGLASS_OK) return 0;
  static Turn kept[2][2];  // arrays that take turns, of either
  const sandglass_cast_plane* plane = nullptr;
  for (uint32_t i = 0; i < k_turns; ++i) {
    const Turn& turn = input.turns[i];
    const bool last = i == k_turns - 1;
    const std::vector<int32_t> statuses = scalar.set(turn, &kept[0][i % 2]);
    expect(other.set(turn, &kept[1][i % 2]) == statuses);
    if (statuses[0] == SANDGLASS_OK) plane = &turn.plane;
    const uint32_t units = last ? k_units_max : turn.units % 1000, ran = scalar.run(units);
    expect(other.run(units) == ran && (!last || ran < k_units_max));
    for (const bool ambient : {false, true}) {
      expect(same(scalar.texture(ambient), other.texture(ambient)));
      check(scalar.texture(ambient), last ? plane : nullptr, ambient ? 255 : 0);
    }
    if (!last) continue;
    expect(scalar.set(turn, &kept[0][i % 2]) == statuses && scalar.run(10) == 0);
    for (const bool ambient : {false, true}) {  // without a light there is no texture of it, but one is asked for
      const sandglass_texture texture = scalar.texture(ambient);
      expect(texture.behind == 0 || texture.valid == 0);
    }
  }
  return 0;
}
