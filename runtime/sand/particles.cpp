// Particles and the boundary: where the records are, in which order, and the first of them on a ray.
#include "kernels/whole.h"
#include "runtime/math/finite.h"
#include "runtime/sand/granular.h"

namespace sandglass {

// ---- Particles

void particles_layout(Particles* p, const sandglass_granular_desc& d, Layout* layout) {
  p->rows = (d.particle_capacity + k_lane_group - 1) / k_lane_group * k_lane_group + k_array_slack;
  p->inert = p->rows + d.boundary_capacity;
  const uint64_t records = static_cast<uint64_t>(p->inert) + k_array_slack;
  // Pairs are solved in place.
  const uint32_t solving = d.reference.scheme == SANDGLASS_SCHEME_SMALL_STEP ? 1 : d.reference.solver_iterations;
  const bool several_passes = solving + d.reference.stabilisation_iterations > 1;
  p->records[0] = layout_region<Particle>(layout, "granular.particles", records);
  p->records[1] = layout_region<Particle>(layout, "granular.particles_next", records);
  p->records[2] = layout_region<Particle>(layout, "granular.particles_between", several_passes ? records : 0);
}

void particles_reset(Particles* p) {
  p->count = 0;
  p->bounds_known = false;
  p->speed_max = 0.0f;
  for (int k = 0; k < 3; ++k) p->low[k] = p->high[k] = 0.0f;
  for (Particle* records : p->records) {
    if (records != nullptr) records[p->inert] = inert_particle();
  }
}

void particles_swap(Particles* p) {
  Particle* state = p->records[1];
  p->records[1] = p->records[0];
  p->records[0] = state;
}

void particles_copy_to_all(const Particles& p, uint32_t first, uint32_t count) {
  for (int b = 1; b < 3; ++b) {
    if (p.records[b] != nullptr) __builtin_memcpy(p.records[b] + first, p.records[0] + first, count * sizeof(Particle));
  }
}

void particles_append(Particles* p, const float position[3], const float velocity[3], uint32_t number) {
  p->records[0][p->count++] = moving_particle(position, velocity, number);
  particles_include(p, position, velocity);
}

void particles_remove(Particles* p, uint32_t i) {
  const uint32_t last = --p->count;
  if (i != last) p->records[0][i] = p->records[0][last];
}

void particles_include(Particles* p, const float position[3], const float velocity[3]) {
  float speed2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    if (!p->bounds_known || position[k] < p->low[k]) p->low[k] = position[k];
    if (!p->bounds_known || position[k] > p->high[k]) p->high[k] = position[k];
    speed2 += velocity[k] * velocity[k];
  }
  p->bounds_known = true;
  const float speed = __builtin_sqrtf(speed2);
  if (speed > p->speed_max) p->speed_max = speed;
}

void particles_find_bounds(Particles* p) {
  for (uint32_t i = 0; i < p->count; ++i) {
    const float* at = p->records[0][i].position;
    for (int k = 0; k < 3; ++k) {
      if (i == 0 || at[k] < p->low[k]) p->low[k] = at[k];
      if (i == 0 || at[k] > p->high[k]) p->high[k] = at[k];
    }
  }
}

void particles_move(Particles* p, const SceneMove& move) {
  for (uint32_t i = 0; i < p->count; ++i) {
    move.move(p->records[0][i].position);
    move.turn(p->records[0][i].velocity);
  }
  particles_find_bounds(p);
}

void particles_restore(Particles* p, const SavedScene& s) {
  p->count = s.particles;
  __builtin_memcpy(p->low, s.state.low, sizeof p->low);
  __builtin_memcpy(p->high, s.state.high, sizeof p->high);
  p->speed_max = s.state.speed_max;
  p->bounds_known = s.state.bounds_known != 0;
}

void particles_recall(Particles* p) {
  for (uint32_t i = 0; i < p->count; ++i) {
    Particle* particle = &p->records[0][i];
    if (has_departed(*particle)) particles_include(p, particle->position, particle->velocity);
    set_departed(particle, false);
  }
}

void particles_take_extent(Particles* p, const ContactExtent& e, const Bounds& resting) {
  p->speed_max = __builtin_sqrtf(e.speed_squared);
  for (int k = 0; k < 3; ++k) {
    if (e.low[k] > e.high[k]) continue;
    p->low[k] = e.low[k] < resting.low[k] ? e.low[k] : resting.low[k];
    p->high[k] = e.high[k] > resting.high[k] ? e.high[k] : resting.high[k];
  }
}

void particles_narrow(Particles* p, const Bounds& all, float speed_max) {
  for (int k = 0; k < 3 && !is_empty(all); ++k) {
    p->low[k] = all.low[k];
    p->high[k] = all.high[k];
  }
  p->speed_max = speed_max;
}

void particles_expect_speed(Particles* p, float speed) {
  if (speed > p->speed_max) p->speed_max = speed;
}

void particles_stand(Particles* p) { p->speed_max = 0.0f; }

void particles_seal(const Particles& p) {
  for (uint32_t i = p.count; i < p.rows && i < p.count + k_array_slack; ++i) {
    for (Particle* records : p.records) {
      if (records != nullptr) records[i] = inert_particle();
    }
  }
}

// ---- Boundary

void boundary_layout(Boundary* b, const sandglass_granular_desc& d, Layout* layout) {
  const char* const axes[3] = {"granular.boundary_x", "granular.boundary_y", "granular.boundary_z"};
  const uint64_t capacity = d.boundary_capacity;
  if (capacity == 0) return;
  for (int k = 0; k < 3; ++k) b->positions[k] = layout_region<float>(layout, axes[k], capacity + k_array_slack);
  cell_sort_layout(&b->sort, layout, "granular.boundary_cells", "granular.boundary_keys", capacity, 4 * capacity);
}

Particle* boundary_particles(const Granular& g) { return g.particles.records[0] + g.particles.rows; }

void boundary_reset(Boundary* boundary) {
  boundary->count = 0;
  boundary->bounds = k_nowhere;
}

void boundary_sort(Boundary* own, const Granular& g, uint32_t count) {
  Boundary& boundary = *own;
  const Particles& p = g.particles;
  boundary.count = count;
  boundary.bounds = k_nowhere;
  if (count != 0) {
    Particle* sorted = boundary_particles(g);
    Particle* unsorted = p.records[1] + p.rows;
    __builtin_memcpy(unsorted, sorted, count * sizeof(Particle));
    for (uint32_t i = 0; i < count; ++i) bounds_include(&boundary.bounds, unsorted[i].position);
    cell_sort_begin(&boundary.sort, neighbours_reach(g), boundary.bounds.low, boundary.bounds.high, 2);
    const SortTarget target = {
        as_records(sorted), {boundary.positions[0], boundary.positions[1], boundary.positions[2]}, false};
    while (boundary.sort.phase != k_sort_done)
      cell_sort_run(&boundary.sort, *g.kernels, as_records(unsorted), count, g.unit, target);
    particles_copy_to_all(p, p.rows, count);
  }
  for (Particle* records : p.records) {
    if (records != nullptr) records[p.inert] = inert_particle();
  }
}

void boundary_move(Boundary* boundary, const Granular& g, const SceneMove& move) {
  Particle* const particles = boundary_particles(g);
  for (uint32_t i = 0; i < boundary->count; ++i) {
    move.move(particles[i].position);
    move.turn(particles[i].velocity);
  }
  boundary_sort(boundary, g, boundary->count);
}

// ---- CellSort

namespace {

// As many cells are cleared or summed for what moving one record costs.
constexpr uint32_t k_cells_per_item = 8;

// What a unit costs besides its items, in items. Without it the last, short unit of a phase would look expensive.
constexpr uint32_t k_unit_overhead = 64;

uint32_t power_of_two(uint64_t at_least) {
  uint32_t p = 512;  // 8 cells an axis, the fewest that a sweep looks at
  while (p < at_least && p < (1u << 30)) p *= 2;
  return p;
}

uint32_t unit_size(const CellSort& sort, uint32_t unit) {
  return sort.phase == k_sort_clear || sort.phase == k_sort_prefix ? unit * k_cells_per_item : unit;
}

// Finds the places in the order of the records from `first` to `last`.
void find_places(CellSort* sort, uint32_t first, uint32_t last) {
  for (uint32_t i = first; i < last; ++i) sort->keys[i] = sort->starts[sort->keys[i] + 1]++;
}

// Swaps records into their places, or passes those that are there, `steps` times. Returns the first that is not in its
// place. Each swap puts a record into its place for good, so there are two steps a record at most.
uint32_t swap_records(Record* records, uint32_t* places, uint32_t first, uint32_t count, uint32_t steps) {
  uint32_t i = first;
  for (; steps != 0 && i < count; --steps) {
    const uint32_t place = places[i];
    if (place == i) {
      ++i;
      continue;
    }
    const Record moved = records[i];
    records[i] = records[place];
    records[place] = moved;
    places[i] = places[place];
    places[place] = place;
  }
  return i;
}

// To where the target wants them.
void scatter(CellSort* sort, const Record* records, uint32_t first, uint32_t last, const SortTarget& target) {
  for (uint32_t i = first; i < last; ++i) {
    const uint32_t to = sort->starts[sort->keys[i] + 1]++;
    target.records[to] = records[i];
    if (target.positions[0] == nullptr) continue;
    const bool hidden = target.sand_only && in_body(as_particle(records[i]));
    for (int k = 0; k < 3; ++k) target.positions[k][to] = hidden ? k_inert_position : records[i].position[k];
  }
}

uint32_t phase_end(const CellSort& sort, uint32_t record_count) {
  if (sort.phase == k_sort_clear) return sort.cells + 2;
  if (sort.phase == k_sort_prefix) return sort.cells;
  return record_count;
}

}  // namespace

void cell_sort_layout(CellSort* sort, Layout* layout, const char* starts_name, const char* keys_name, uint64_t records,
                      uint64_t cells) {
  sort->cells_max = power_of_two(cells);
  sort->starts = layout_region<uint32_t>(layout, starts_name, static_cast<uint64_t>(sort->cells_max) + k_array_slack);
  sort->keys = layout_region<uint32_t>(layout, keys_name, records + k_array_slack);
}

void cell_sort_begin(CellSort* sort, float cell, const float low[3], const float high[3], uint32_t bits_min) {
  const float inverse = 1.0f / cell;
  uint32_t bits[3];
  for (int k = 0; k < 3; ++k) {
    const float extent = (high[k] - low[k]) * inverse + 2.0f;
    const uint32_t cells = extent > 1.0f && extent < 1048576.0f ? to_whole<uint32_t>(extent) : 1048576u;
    bits[k] = bits_min;
    while ((1u << bits[k]) < cells) ++bits[k];
  }
  while ((1ull << (bits[0] + bits[1] + bits[2])) > sort->cells_max) {
    const int longest = bits[0] >= bits[1] && bits[0] >= bits[2] ? 0 : bits[1] >= bits[2] ? 1 : 2;
    if (bits[longest] == bits_min) break;
    --bits[longest];
  }
  sort->grid.inverse_cell = inverse;
  for (int k = 0; k < 3; ++k) {
    sort->grid.bits[k] = bits[k];
    const float scaled = low[k] * inverse;
    sort->first[k] = scaled > -1e9f && scaled < 1e9f ? to_whole<int32_t>(scaled) - 1 : 0;
  }
  sort->grid.starts = sort->starts;
  sort->cells = 1u << (bits[0] + bits[1] + bits[2]);
  sort->phase = k_sort_clear;
  sort->cursor = 0;
  sort->sum = 0;
}

uint32_t cell_sort_items(const CellSort& sort, uint32_t record_count, uint32_t unit) {
  const uint32_t left = phase_end(sort, record_count) - sort.cursor, size = unit_size(sort, unit);
  const uint32_t items = left < size ? left : size;
  return k_unit_overhead +
         (sort.phase == k_sort_clear || sort.phase == k_sort_prefix ? items / k_cells_per_item : items);
}

void cell_sort_run(CellSort* sort, const Kernels& kernels, const Record* records, uint32_t record_count, uint32_t unit,
                   const SortTarget& target) {
  const uint32_t end = phase_end(*sort, record_count), size = unit_size(*sort, unit);
  const uint32_t first = sort->cursor;
  uint32_t last = end - first < size ? end : first + size;
  uint32_t* starts = sort->starts;
  switch (sort->phase) {
    case k_sort_clear:
      for (uint32_t c = first; c < last; ++c) starts[c] = 0;
      break;
    case k_sort_count: {
      const GridCellsArgs args = {
          sort->grid, records, sort->keys, sort->serpentine ? 1 : 0, {sort->first[0], sort->first[1], sort->first[2]}};
      uint32_t unused = 0;
      kernels.grid_cells(&args, first, last, &unused);
      // Counts stand two places on, so the sums stand one place on, and scattering moves them into place.
      for (uint32_t i = first; i < last; ++i) ++starts[sort->keys[i] + 2];
      break;
    }
    case k_sort_prefix: {
      uint32_t sum = sort->sum;
      for (uint32_t c = first; c < last; ++c) {
        sum += starts[c + 1];
        starts[c + 1] = sum;
      }
      sort->sum = sum;
      break;
    }
    case k_sort_scatter:
      if (target.records == records) find_places(sort, first, last);
      else scatter(sort, records, first, last, target);
      break;
    default:
      last = swap_records(target.records, sort->keys, first, end, size);
      break;
  }
  sort->cursor = last;
  if (last == end) {
    sort->cursor = 0;
    ++sort->phase;
    if (sort->phase == k_sort_swap && target.records != records) sort->phase = k_sort_done;
  }
}

// ---- The particle on a ray
//
// From a finger on the screen to a place on the sand: the first particle on a ray. It asks every particle, in double,
// so that a far origin costs no digits: the search is a fraction of a millisecond in any scene that a phone can
// simulate.

void granular_ray(const Granular& g, const float origin[3], const float direction[3], float reach,
                  sandglass_ray_hit* hit) {
  *hit = {};
  const double o[3] = {static_cast<double>(origin[0]), static_cast<double>(origin[1]), static_cast<double>(origin[2])};
  double u[3], length2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    u[k] = static_cast<double>(direction[k]);
    length2 += u[k] * u[k];
  }
  // The squares of the smallest floats are above 0 in double.
  if (!all_finite(origin, 3) || !is_finite(length2) || !(length2 > 0.0) || !(reach > 0.0f)) return;
  for (double& x : u) x /= __builtin_sqrt(length2);
  const double radius2 = static_cast<double>(g.desc.particle_radius) * static_cast<double>(g.desc.particle_radius);
  double nearest = static_cast<double>(reach);
  const Particle* found = nullptr;
  for (uint32_t i = 0; i < g.particles.count; ++i) {
    const Particle& p = g.particles.records[0][i];
    const double x = static_cast<double>(p.position[0]) - o[0], y = static_cast<double>(p.position[1]) - o[1],
                 z = static_cast<double>(p.position[2]) - o[2];
    const double along = x * u[0] + y * u[1] + z * u[2];  // to the foot of the centre
    const double a = x - along * u[0], b = y - along * u[1], c = z - along * u[2];
    const double half2 = radius2 - (a * a + b * b + c * c);
    if (!(half2 >= 0.0)) continue;
    const double half = __builtin_sqrt(half2);
    if (along + half < 0.0) continue;  // behind
    const double at = along - half > 0.0 ? along - half : 0.0;
    const bool nearer = found != nullptr && at == nearest ? number_of(p) < number_of(*found) : at <= nearest;
    if (nearer) {
      nearest = at;
      found = &p;
    }
  }
  if (found == nullptr) return;
  hit->what = in_body(*found) ? SANDGLASS_HIT_BODY : SANDGLASS_HIT_SAND;
  hit->index = in_body(*found) ? body_of(*found) - 1 : number_of(*found);
  hit->distance = static_cast<float>(nearest);
  double normal[3], size2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double point = o[k] + nearest * u[k];
    hit->point[k] = static_cast<float>(point);
    normal[k] = point - static_cast<double>(found->position[k]);
    size2 += normal[k] * normal[k];
  }
  for (int k = 0; k < 3; ++k)
    hit->normal[k] = static_cast<float>(size2 > 0.0 ? normal[k] / __builtin_sqrt(size2) : -u[k]);
}

}  // namespace sandglass
