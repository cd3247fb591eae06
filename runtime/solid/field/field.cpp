// Signed distances on a grid. From a mesh: every triangle writes its exact distance to the nodes within the band. From
// there distances spread node by node, in two passes over the 26 neighbours; they are never below the truth and at most
// 13 % above it. An inside test gives the sign. There is no memory but the field's own.
#include "runtime/solid/field/field.h"
#include "runtime/frame/filled_struct.h"

#include "kernels/whole.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/solid/sampling/arguments.h"

namespace sandglass {

namespace {

constexpr uint32_t k_nodes_max = 1u << 24;
constexpr float k_far = 1e30f;

// Counts the nodes of the box. Null, or a sentence that says what is wrong; the mesh is not looked into.
const char* measure(const sandglass_field_desc* desc, uint32_t counts[3]) {
  if (desc == nullptr || desc->struct_size != sizeof *desc)
    return "desc is NULL or its struct_size is wrong: start from sandglass_field_desc_default.";
  if (desc->solid != SANDGLASS_SOLID_INSIDE && desc->solid != SANDGLASS_SOLID_OUTSIDE)
    return "solid must be a SANDGLASS_SOLID value.";
  if ((desc->mesh == nullptr) == (desc->distance == nullptr))
    return "mesh and distance are both NULL, or neither is: pass one of them.";
  if (desc->mesh != nullptr && desc->inside == nullptr)
    return "inside is NULL: pass sandglass_mesh_inside_test, or a function of yours.";
  if (!(desc->band >= 0.0f && desc->band <= SANDGLASS_COORDINATE_LIMIT)) return "band must be 0 to 1000 metres.";
  const float *low = desc->bounds_min, *high = desc->bounds_max, spacing = desc->spacing;
  if (!(spacing >= 1e-5f && spacing <= 100.0f)) return "spacing must be 0.00001 to 100 metres.";
  double nodes = 1.0;
  for (int k = 0; k < 3; ++k) {
    if (!(low[k] >= -SANDGLASS_COORDINATE_LIMIT && high[k] <= SANDGLASS_COORDINATE_LIMIT && low[k] < high[k]))
      return "bounds must be finite, within 1000 m, and bounds_min below bounds_max.";
    const double cells = (static_cast<double>(high[k]) - static_cast<double>(low[k])) / static_cast<double>(spacing);
    if (!(cells < static_cast<double>(k_nodes_max))) return "more than 2^24 nodes: enlarge the spacing.";
    const uint32_t whole = to_whole<uint32_t>(cells);
    counts[k] = whole + (cells > static_cast<double>(whole) ? 2 : 1);
    if (counts[k] < 2) counts[k] = 2;
    nodes *= counts[k];
  }
  return nodes <= static_cast<double>(k_nodes_max) ? nullptr : "more than 2^24 nodes: enlarge the spacing.";
}

uint64_t bytes_of(const uint32_t counts[3]) {
  return sizeof(sandglass_field) + static_cast<uint64_t>(counts[0]) * counts[1] * counts[2] * sizeof(float);
}

struct Nodes {
  float* values;
  uint32_t counts[3];
  float low[3], spacing;
  uint64_t at(uint32_t i, uint32_t j, uint32_t k) const {
    return i + static_cast<uint64_t>(counts[0]) * (j + static_cast<uint64_t>(counts[1]) * k);
  }
  void place(uint32_t i, uint32_t j, uint32_t k, float point[3]) const {
    point[0] = low[0] + spacing * static_cast<float>(i);
    point[1] = low[1] + spacing * static_cast<float>(j);
    point[2] = low[2] + spacing * static_cast<float>(k);
  }
};

sandglass_status check(const sandglass_field_desc* desc, uint32_t counts[3], const char** reason) {
  if (const char* sentence = measure(desc, counts)) return refuse(reason, sentence);
  return desc->mesh != nullptr ? check_mesh(desc->mesh, reason) : accept(reason);
}

// Writes the header once the values are there. Finds the border and refuses a surface that leaves the box.
sandglass_status finish(const Nodes& n, sandglass_solid solid, void* block, sandglass_field** field,
                        const char** reason) {
  const bool inside = solid == SANDGLASS_SOLID_INSIDE;
  bool two_sided = false;  // some node and the faces lie on different sides of the surface
  float border = inside ? k_far : -k_far;
  for (uint32_t k = 0; k < n.counts[2]; ++k) {
    for (uint32_t j = 0; j < n.counts[1]; ++j) {
      for (uint32_t i = 0; i < n.counts[0]; ++i) {
        const float value = n.values[n.at(i, j, k)];
        if (!(value > -1e6f && value < 1e6f)) return refuse(reason, "a distance is not finite.");
        const bool face =
            i == 0 || j == 0 || k == 0 || i + 1 == n.counts[0] || j + 1 == n.counts[1] || k + 1 == n.counts[2];
        two_sided = two_sided || (inside ? value < 0.0f : value > 0.0f);
        if (face && (inside ? value < border : value > border)) border = value;
      }
    }
  }
  if (inside ? border <= 0.0f : border >= 0.0f)
    return refuse(reason, "the surface crosses the faces of the box: enlarge the bounds.");
  if (!two_sided) {
    return refuse(reason, inside ? "no node is solid: make spacing smaller than the thinnest wall."
                                 : "no node is free: make spacing smaller than the narrowest passage.");
  }
  sandglass_field* header = static_cast<sandglass_field*>(block);
  *header = {};
  header->magic = k_field_magic;
  FieldGrid& grid = header->shape;
  for (int k = 0; k < 3; ++k) {
    grid.counts[k] = n.counts[k];
    grid.low[k] = n.low[k];
  }
  grid.spacing = n.spacing;
  grid.inverse_spacing = 1.0f / n.spacing;
  grid.outward = inside ? 1.0f : -1.0f;
  grid.border = border;
  const uint64_t nodes = static_cast<uint64_t>(n.counts[0]) * n.counts[1] * n.counts[2];
  const float place[4] = {n.low[0], n.low[1], n.low[2], n.spacing};
  header->version = hash_bytes(n.values, nodes * sizeof(float), hash_bytes(place, sizeof place)) | 1;
  *field = header;
  return accept(reason);
}

struct Vector {
  float x, y, z;
};
Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator*(float s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
float dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

float segment_distance2(Vector p, Vector a, Vector b) {
  const Vector ab = b - a;
  const float length2 = dot(ab, ab);
  float t = length2 > 0.0f ? dot(p - a, ab) / length2 : 0.0f;
  t = t > 0.0f ? (t < 1.0f ? t : 1.0f) : 0.0f;
  const Vector d = p - (a + t * ab);
  return dot(d, d);
}

// Squared distance from a triangle: to its plane where the foot point lies inside it, else to its nearest edge.
float triangle_distance2(Vector p, Vector a, Vector b, Vector c) {
  const Vector ab = b - a, ac = c - a, ap = p - a;
  const float d00 = dot(ab, ab), d01 = dot(ab, ac), d11 = dot(ac, ac), d20 = dot(ap, ab), d21 = dot(ap, ac);
  const float det = d00 * d11 - d01 * d01;
  const float v = d11 * d20 - d01 * d21, w = d00 * d21 - d01 * d20;
  if (det > 0.0f && v >= 0.0f && w >= 0.0f && v + w <= det) {
    const Vector foot = a + (v / det) * ab + (w / det) * ac;
    return dot(p - foot, p - foot);
  }
  const float e0 = segment_distance2(p, a, b), e1 = segment_distance2(p, b, c), e2 = segment_distance2(p, c, a);
  const float e = e0 < e1 ? e0 : e1;
  return e < e2 ? e : e2;
}

// The first and last node of an axis within low..high.
bool node_range(const Nodes& n, int axis, float low, float high, uint32_t range[2]) {
  const float from = (low - n.low[axis]) / n.spacing, to = (high - n.low[axis]) / n.spacing;
  const float last = static_cast<float>(n.counts[axis] - 1);
  if (to < 0.0f || from > last) return false;
  range[0] = from > 0.0f ? to_whole<uint32_t>(from) : 0;
  range[1] = to < last ? to_whole<uint32_t>(to) + 1 : n.counts[axis] - 1;
  if (range[1] > n.counts[axis] - 1) range[1] = n.counts[axis] - 1;
  return true;
}

void write_triangle(const Nodes& n, const float* const corners[3], float band) {
  uint32_t range[3][2];
  for (int k = 0; k < 3; ++k) {
    float low = corners[0][k], high = corners[0][k];
    for (int v = 1; v < 3; ++v) {
      low = corners[v][k] < low ? corners[v][k] : low;
      high = corners[v][k] > high ? corners[v][k] : high;
    }
    if (!node_range(n, k, low - band, high + band, range[k])) return;
  }
  const Vector a = {corners[0][0], corners[0][1], corners[0][2]}, b = {corners[1][0], corners[1][1], corners[1][2]},
               c = {corners[2][0], corners[2][1], corners[2][2]};
  for (uint32_t z = range[2][0]; z <= range[2][1]; ++z) {
    for (uint32_t y = range[1][0]; y <= range[1][1]; ++y) {
      for (uint32_t x = range[0][0]; x <= range[0][1]; ++x) {
        float p[3];
        n.place(x, y, z, p);
        const float d2 = triangle_distance2({p[0], p[1], p[2]}, a, b, c);
        float& value = n.values[n.at(x, y, z)];
        if (d2 < value) value = d2;  // squared, until all triangles are done
      }
    }
  }
}

// Distances spread to the nodes beyond the band: forward over the 13 neighbours before, backward over the 13 after.
void spread(const Nodes& n, bool forward) {
  const int64_t nx = n.counts[0], ny = n.counts[1], nz = n.counts[2], side = forward ? -1 : 1;
  const float lengths[4] = {0.0f, n.spacing, n.spacing * 1.41421356f, n.spacing * 1.73205081f};
  for (int64_t s = 0; s < nx * ny * nz; ++s) {
    const int64_t at = forward ? s : nx * ny * nz - 1 - s;
    const int64_t x = at % nx, y = at / nx % ny, z = at / (nx * ny);
    float best = n.values[at];
    for (int neighbour = 0; neighbour < 13; ++neighbour) {
      // 13 of the 26 offsets: those before in storage, mirrored for the way back.
      const int64_t dx = side * (1 - neighbour % 3), dy = side * (1 - neighbour / 3 % 3),
                    dz = side * (1 - neighbour / 9);
      const int64_t i = x + dx, j = y + dy, k = z + dz;
      if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz) continue;
      const int steps = (dx != 0) + (dy != 0) + (dz != 0);
      const float candidate = n.values[i + nx * (j + ny * k)] + lengths[steps];
      best = candidate < best ? candidate : best;
    }
    n.values[at] = best;
  }
}

void ask_function(const Nodes& n, const sandglass_field_desc& desc) {
  for (uint32_t k = 0; k < n.counts[2]; ++k) {
    for (uint32_t j = 0; j < n.counts[1]; ++j) {
      for (uint32_t i = 0; i < n.counts[0]; ++i) {
        float point[3];
        n.place(i, j, k, point);
        n.values[n.at(i, j, k)] = desc.distance(desc.distance_user, point);
      }
    }
  }
}

void measure_mesh(const Nodes& n, const sandglass_field_desc& desc) {
  const sandglass_mesh& mesh = *desc.mesh;
  const float reach = desc.band > 2.0f * n.spacing ? desc.band : 2.0f * n.spacing;
  const uint64_t count = static_cast<uint64_t>(n.counts[0]) * n.counts[1] * n.counts[2];
  for (uint64_t i = 0; i < count; ++i) n.values[i] = k_far;
  for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
    const float* corners[3];
    for (int v = 0; v < 3; ++v) corners[v] = mesh.vertices + 3ull * mesh.indices[3ull * t + v];
    write_triangle(n, corners, reach);
  }
  // Beyond the band the triangles that reached a node need not be the nearest: those nodes are left to the passes.
  for (uint64_t i = 0; i < count; ++i) {
    const float distance = n.values[i] < k_far ? __builtin_sqrtf(n.values[i]) : k_far;
    n.values[i] = distance <= reach ? distance : k_far;
  }
  spread(n, true);
  spread(n, false);
  for (uint32_t k = 0; k < n.counts[2]; ++k) {
    for (uint32_t j = 0; j < n.counts[1]; ++j) {
      for (uint32_t i = 0; i < n.counts[0]; ++i) {
        float point[3];
        n.place(i, j, k, point);
        const bool is_inside = desc.inside(desc.inside_user, point) != 0;
        if (is_inside == (desc.solid == SANDGLASS_SOLID_INSIDE)) n.values[n.at(i, j, k)] = -n.values[n.at(i, j, k)];
      }
    }
  }
}

}  // namespace

}  // namespace sandglass

using namespace sandglass;

void sandglass_field_desc_default(sandglass_field_desc* desc) { empty_struct(desc); }

sandglass_status sandglass_field_bytes(const sandglass_field_desc* desc, uint64_t* bytes, const char** reason) {
  uint32_t counts[3];
  if (const sandglass_status status = check(desc, counts, reason)) return status;
  if (bytes == nullptr) return refuse(reason, "bytes is NULL: pass where to store the size.");
  *bytes = bytes_of(counts);
  return accept(reason);
}

sandglass_status sandglass_field_create(const sandglass_field_desc* desc, void* block, uint64_t bytes,
                                        sandglass_field** field, const char** reason) {
  Nodes n = {};
  if (const sandglass_status status = check(desc, n.counts, reason)) return status;
  if (field == nullptr) return refuse(reason, "field is NULL: pass where to store the field.");
  if (const sandglass_status status = check_block(block, bytes, bytes_of(n.counts), reason)) return status;
  n.values = reinterpret_cast<float*>(static_cast<sandglass_field*>(block) + 1);
  for (int k = 0; k < 3; ++k) n.low[k] = desc->bounds_min[k];
  n.spacing = desc->spacing;
  if (desc->mesh != nullptr) measure_mesh(n, *desc);
  else ask_function(n, *desc);
  return finish(n, desc->solid, block, field, reason);
}

float sandglass_field_distance(const sandglass_field* field, const float point[3], float normal[3]) {
  constexpr float k_farthest = 1e6f;
  if (field == nullptr || point == nullptr) return 0.0f;
  if (!all_finite(point, 3)) {
    if (normal != nullptr) {
      normal[0] = 0.0f;
      normal[1] = 1.0f;
      normal[2] = 0.0f;
    }
    return 0.0f;
  }
  const Kernels* kernels = select_sand_kernels(SANDGLASS_ISA_SCALAR);
  ColliderFrame frame = {};
  frame.shape = SANDGLASS_SHAPE_FIELD;
  for (int k = 0; k < 3; ++k) frame.axes[k][k] = 1.0f;
  frame.field = grid_of(field);
  SurfacePoint at = {};
  for (int k = 0; k < 3; ++k) {
    const float p = point[k];
    at.position[k] = p > k_farthest ? k_farthest : (p < -k_farthest ? -k_farthest : p);
  }
  SurfaceArgs args = {&at, &frame};
  uint32_t unused = 0;
  kernels->surface_at(&args, 0, 1, &unused);
  if (normal != nullptr) {
    for (int k = 0; k < 3; ++k) normal[k] = at.normal[k];
  }
  return at.distance;
}

sandglass_solid sandglass_field_bounds(const sandglass_field* field, float bounds_min[3], float bounds_max[3]) {
  if (field == nullptr) return SANDGLASS_SOLID_INSIDE;
  const FieldGrid& grid = field->shape;
  for (int k = 0; k < 3; ++k) {
    if (bounds_min != nullptr) bounds_min[k] = grid.low[k];
    if (bounds_max != nullptr) bounds_max[k] = grid.low[k] + grid.spacing * static_cast<float>(grid.counts[k] - 1);
  }
  return grid.outward > 0.0f ? SANDGLASS_SOLID_INSIDE : SANDGLASS_SOLID_OUTSIDE;
}
