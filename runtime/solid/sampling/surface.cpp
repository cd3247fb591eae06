// Poisson-disk sampling of a surface: Alg. 1.
//
// The dissertation asks for each candidate whether a sample conflicts with it, by a second grid that holds the samples.
// Here a new sample retires all candidates closer than l, for good. The live candidates are then exactly those without
// conflict. That gives the same decisions with one grid. The work is linear, since a candidate dies once. The result is
// maximal once no candidate is left. And it needs distances from one sample, not between pairs: that is what a geodesic
// search gives.
#include "kernels/whole.h"
#include "runtime/frame/layout.h"
#include "runtime/solid/sampling/arguments.h"
#include "runtime/solid/sampling/candidate_grid.h"
#include "runtime/solid/sampling/geodesic.h"
#include "runtime/solid/sampling/methods.h"

namespace sandglass {
namespace {

constexpr uint32_t k_progress_interval = 1024;  // samples

struct SurfaceNeed {
  const sandglass_sample_desc& desc;
  double area;
  float bounds_min[3], bounds_max[3];
  uint32_t candidates;
  uint32_t bucket_bits;
  uint32_t capacity;  // samples
};

struct SurfaceMemory {
  double* running;
  CandidateGrid grid;
  uint32_t* samples;  // records
  uint32_t* active;   // records
  Geodesic geodesic;
};

sandglass_status measure(SurfaceNeed* need, const char** reason) {
  const sandglass_mesh* mesh = need->desc.mesh;
  const float distance = need->desc.distance;
  if (const sandglass_status status = sandglass_mesh_bounds(mesh, need->bounds_min, need->bounds_max, reason))
    return status;
  need->area = sum_areas(*mesh, nullptr);
  if (!(need->area > 0)) return refuse(reason, "the mesh's triangles have no area: check its vertices.");
  const double candidates = candidate_count(need->area, distance, need->desc.tries);
  if (!(candidates <= k_point_limit))
    return refuse(reason, "distance is too small: more than 2^30 candidates; enlarge it or shrink the mesh.");
  for (int k = 0; k < 3; ++k) {
    const double extent = static_cast<double>(need->bounds_max[k]) - static_cast<double>(need->bounds_min[k]);
    if (!(extent * cells_per_metre(distance) < k_axis_cell_limit))
      return refuse(reason, "distance is too small: more than 2^20 of it along the bounding box; enlarge it.");
  }
  need->candidates = to_whole<uint32_t>(candidates);
  // With 30 tries, a cell that the surface crosses holds about ten candidates.
  need->bucket_bits = 1;
  while ((1ull << need->bucket_bits) < need->candidates / 8) ++need->bucket_bits;
  return accept(reason);
}

SurfaceMemory lay_out(Layout* layout, const SurfaceNeed& need) {
  const uint64_t buckets = 1ull << need.bucket_bits;
  SurfaceMemory memory = {};
  memory.running = layout_region<double>(layout, "sampling.surface.running", need.desc.mesh->triangle_count);
  memory.grid.first = layout_region<uint32_t>(layout, "sampling.surface.first", buckets);
  memory.grid.live = layout_region<uint32_t>(layout, "sampling.surface.live", buckets);
  memory.grid.records = layout_region<Candidate>(layout, "sampling.surface.records", need.candidates);
  memory.samples = layout_region<uint32_t>(layout, "sampling.surface.samples", need.capacity);
  memory.active = layout_region<uint32_t>(layout, "sampling.surface.active", need.capacity);
  if (need.desc.metric == SANDGLASS_METRIC_GEODESIC)
    memory.geodesic = lay_out_geodesic(layout, need.desc.mesh, need.candidates);
  return memory;
}

void fill_grid(const SurfaceNeed& need, SurfaceMemory* memory) {
  CandidateGrid& grid = memory->grid;
  for (int k = 0; k < 3; ++k) grid.origin[k] = static_cast<double>(need.bounds_min[k]);
  grid.cells_per_metre = cells_per_metre(need.desc.distance);
  grid.bucket_bits = need.bucket_bits;
  sum_areas(*need.desc.mesh, memory->running);
  const uint32_t buckets = 1u << need.bucket_bits;
  for (uint32_t b = 0; b < buckets; ++b) grid.live[b] = 0;

  CandidateStream stream = candidate_stream(*need.desc.mesh, memory->running, need.area, need.desc.seed);
  for (uint32_t i = 0; i < need.candidates; ++i) ++grid.live[bucket_of(grid, draw_candidate(&stream).position)];
  uint32_t start = 0;
  for (uint32_t b = 0; b < buckets; ++b) {
    const uint32_t size = grid.live[b];
    grid.first[b] = grid.live[b] = start;
    start += size;
  }
  stream = candidate_stream(*need.desc.mesh, memory->running, need.area, need.desc.seed);
  for (uint32_t i = 0; i < need.candidates; ++i) {
    const Candidate candidate = draw_candidate(&stream);
    grid.records[grid.live[bucket_of(grid, candidate.position)]++] = candidate;
  }
}

struct SurfaceRun {
  const SurfaceNeed& need;
  SurfaceMemory& memory;
  Random random;
  double distance_squared;
  uint32_t sample_count, active_count;
  uint64_t retired;
};

uint32_t retire_euclidean(SurfaceRun* run, const Candidate& sample, const uint32_t* buckets, uint32_t bucket_count) {
  const CandidateGrid& grid = run->memory.grid;
  uint32_t retired = 0;
  for (uint32_t n = 0; n < bucket_count; ++n)
    for (uint32_t i = grid.first[buckets[n]]; i < grid.live[buckets[n]];) {
      if (distance_squared(grid.records[i].position, sample.position) < run->distance_squared) {
        retire(grid, buckets[n], i);
        ++retired;
      } else {
        ++i;
      }
    }
  return retired;
}

uint32_t retire_geodesic(SurfaceRun* run, const Candidate& sample, const uint32_t* buckets, uint32_t bucket_count) {
  const CandidateGrid& grid = run->memory.grid;
  Geodesic* geodesic = &run->memory.geodesic;
  begin_near(geodesic);  // a path along the surface is no shorter than the straight line
  for (uint32_t n = 0; n < bucket_count; ++n)
    for (uint32_t i = grid.first[buckets[n]]; i < grid.live[buckets[n]]; ++i)
      if (distance_squared(grid.records[i].position, sample.position) < run->distance_squared) add_near(geodesic, i);
  const double distance = static_cast<double>(run->need.desc.distance);
  measure_near(geodesic, sample.position, sample.triangle, distance);
  // Backwards: what is swapped into a retired place comes from further back, where all is decided.
  uint32_t retired = 0;
  for (uint32_t i = geodesic->near.count; i-- > 0;) {
    if (!(geodesic->near.distance[i] < distance)) continue;
    const uint32_t record = geodesic->near.record[i];
    retire(grid, bucket_of(grid, grid.records[record].position), record);
    ++retired;
  }
  return retired;
}

// Makes a live candidate a sample. False: there is no room for it.
bool take_sample(SurfaceRun* run, uint32_t bucket, uint32_t record) {
  if (run->sample_count == run->need.capacity) return false;
  SurfaceMemory& memory = run->memory;
  const uint32_t sample = retire(memory.grid, bucket, record);
  memory.samples[run->sample_count++] = sample;
  memory.active[run->active_count++] = sample;
  const Candidate candidate = memory.grid.records[sample];
  uint32_t buckets[27];
  const uint32_t bucket_count = neighbour_buckets(memory.grid, candidate.position, buckets);
  run->retired += 1 + (run->need.desc.metric == SANDGLASS_METRIC_GEODESIC
                           ? retire_geodesic(run, candidate, buckets, bucket_count)
                           : retire_euclidean(run, candidate, buckets, bucket_count));
  if (run->need.desc.progress != nullptr && run->sample_count % k_progress_interval == 0)
    run->need.desc.progress(run->need.desc.progress_user, run->retired, run->need.candidates);
  return true;
}

// Alg. 1, lines 6-19. The walk over the neighbouring cells starts at a random one, so that growth prefers no direction.
// As in Bridson 2007 a new sample lies within 2l of the active one.
bool grow(SurfaceRun* run) {
  const CandidateGrid& grid = run->memory.grid;
  while (run->active_count > 0) {
    const uint32_t chosen = run->random.below(run->active_count);
    const Candidate& centre = grid.records[run->memory.active[chosen]];
    uint32_t buckets[27];
    const uint32_t bucket_count = neighbour_buckets(grid, centre.position, buckets);
    const uint32_t start = run->random.below(bucket_count);
    bool found = false;
    for (uint32_t n = 0; n < bucket_count && !found; ++n) {
      const uint32_t bucket = buckets[(start + n) % bucket_count];
      for (uint32_t i = grid.first[bucket]; i < grid.live[bucket] && !found; ++i) {
        if (!(distance_squared(grid.records[i].position, centre.position) < 4 * run->distance_squared)) continue;
        if (!take_sample(run, bucket, i)) return false;
        found = true;
      }
    }
    if (!found) run->memory.active[chosen] = run->memory.active[--run->active_count];
  }
  return true;
}

bool sample_all(SurfaceRun* run) {
  const CandidateGrid& grid = run->memory.grid;
  for (uint32_t bucket = 0; bucket < 1u << grid.bucket_bits; ++bucket)
    while (grid.live[bucket] > grid.first[bucket])  // a seed: the first one, or in a part that growth could not reach
      if (!take_sample(run, bucket, grid.first[bucket]) || !grow(run)) return false;
  return true;
}

}  // namespace

sandglass_status sample_on_surface(const sandglass_sample_desc& desc, SampleCall* call, const char** reason) {
  SurfaceNeed need = {desc, 0, {}, {}, 0, 0, 0};
  if (const sandglass_status status = measure(&need, reason)) return status;
  need.capacity = call->capacity < need.candidates ? call->capacity : need.candidates;
  call->enough = need.candidates;
  Layout size;
  lay_out(&size, need);
  call->bytes = size.size;
  if (call->points == nullptr) return accept(reason);
  if (const sandglass_status status = check_block(call->scratch, call->scratch_bytes, call->bytes, reason))
    return status;

  Layout layout;
  layout.base = static_cast<uint8_t*>(call->scratch);
  SurfaceMemory memory = lay_out(&layout, need);
  fill_grid(need, &memory);
  if (desc.metric == SANDGLASS_METRIC_GEODESIC) build_geodesic(&memory.geodesic, memory.grid.records);
  const double l = static_cast<double>(desc.distance);
  SurfaceRun run = {need, memory, random_stream(desc.seed, k_stream_growth), l * l, 0, 0, 0};
  if (!sample_all(&run)) return refuse(reason, SANDGLASS_ERROR_CAPACITY, k_beyond_capacity);
  for (uint32_t i = 0; i < run.sample_count; ++i)
    for (int k = 0; k < 3; ++k) call->points[3ull * i + k] = memory.grid.records[memory.samples[i]].position[k];
  call->count = run.sample_count;
  return accept(reason);
}

}  // namespace sandglass
