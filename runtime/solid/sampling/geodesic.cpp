// See geodesic.h.
#include "runtime/solid/sampling/geodesic.h"

#include "runtime/math/math.h"

namespace sandglass {
namespace {

constexpr uint32_t k_no_index = 0xFFFFFFFFu;  // heap_place: never in the heap; near lists: end
constexpr uint32_t k_settled = 0xFFFFFFFEu;   // heap_place: taken from the heap for good
constexpr double k_far = 1e30;

struct Vector {
  double x, y, z;
};

Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(Vector a) { return square_root(dot(a, a)); }
double hypotenuse(double x, double y) { return square_root(x * x + y * y); }
double clamp(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

Vector to_vector(const float p[3]) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

Vector place_of(const Geodesic& g, uint32_t vertex) { return to_vector(vertex_position(g.surface, vertex)); }

// A half-edge as the x axis of the plane of its triangle, which lies above it.
struct Frame {
  Vector origin, direction;
  double length;
};

Frame frame_of(const Geodesic& g, uint32_t h) {
  Frame frame;
  frame.origin = place_of(g, start_of(g.surface, h));
  const Vector edge = place_of(g, end_of(g.surface, h)) - frame.origin;
  frame.length = length(edge);
  const double inverse = frame.length > 0 ? 1 / frame.length : 0;
  frame.direction = {edge.x * inverse, edge.y * inverse, edge.z * inverse};
  return frame;
}

struct Planar {
  double x, y;
};

Planar unfold(const Frame& frame, Vector point) {
  const Vector d = point - frame.origin;
  const double x = dot(d, frame.direction), rest = dot(d, d) - x * x;
  return {x, rest > 0 ? square_root(rest) : 0};
}

// ---------------------------------------------------------------- heap of vertices, by distance

void heap_set(Geodesic* g, uint32_t place, uint32_t vertex) {
  g->heap[place] = vertex;
  g->heap_place[vertex] = place;
}

void heap_rise(Geodesic* g, uint32_t place) {
  const uint32_t vertex = g->heap[place];
  while (place > 0) {
    const uint32_t parent = (place - 1) / 2;
    if (!(g->distance[vertex] < g->distance[g->heap[parent]])) break;
    heap_set(g, place, g->heap[parent]);
    place = parent;
  }
  heap_set(g, place, vertex);
}

void heap_insert_or_rise(Geodesic* g, uint32_t vertex) {
  if (g->heap_place[vertex] == k_settled) return;
  if (g->heap_place[vertex] == k_no_index) heap_set(g, g->heap_count++, vertex);
  heap_rise(g, g->heap_place[vertex]);
}

uint32_t heap_take(Geodesic* g) {
  const uint32_t top = g->heap[0], vertex = g->heap[--g->heap_count];
  g->heap_place[top] = k_settled;
  if (g->heap_count == 0) return top;
  uint32_t place = 0;
  for (uint32_t child = 1; child < g->heap_count; child = 2 * place + 1) {
    if (child + 1 < g->heap_count && g->distance[g->heap[child + 1]] < g->distance[g->heap[child]]) ++child;
    if (!(g->distance[g->heap[child]] < g->distance[vertex])) break;
    heap_set(g, place, g->heap[child]);
    place = child;
  }
  heap_set(g, place, vertex);
  return top;
}

// Takes note of a path of length d to a vertex.
void offer(Geodesic* g, uint32_t vertex, double d, bool queue) {
  if (!(d < g->distance[vertex]) || !(d < g->radius)) return;
  if (g->distance[vertex] == k_far) g->touched[g->touched_count++] = vertex;
  g->distance[vertex] = d;
  if (queue) heap_insert_or_rise(g, vertex);
}

// ---------------------------------------------------------------- windows

// A window enters every other triangle at the half-edge h. (x, y) is the source as seen from h's own triangle. Dropped
// are windows out of reach, and windows whose far end is reached sooner from one of the edge's vertices along the edge:
// then every point of the window is.
void cross_edge(Geodesic* g, uint32_t h, const Frame& frame, double from, double to, Planar source, double sigma,
                uint32_t depth, bool forked) {
  const bool forks = g->surface.mate[g->surface.mate[h]] != h;
  if (!(to > from) || depth > g->surface.mesh->triangle_count || (forks && forked)) return;
  const double slack = 1e-12 * g->radius;
  const double nearest = hypotenuse(clamp(source.x, from, to) - source.x, source.y);
  if (!(sigma + nearest < g->radius)) return;
  const double start = g->distance[start_of(g->surface, h)], end = g->distance[end_of(g->surface, h)];
  if (sigma + hypotenuse(to - source.x, source.y) > start + to + slack) return;
  if (sigma + hypotenuse(from - source.x, source.y) > end + (frame.length - from) + slack) return;
  for (uint32_t m = g->surface.mate[h]; m != h; m = g->surface.mate[m]) {
    if (g->stack_count >= g->stack_capacity) return;
    Window window = {from, to, source.x, source.y, sigma, m, depth & 0x7FFFFFFFu, forks || forked ? 1u : 0u};
    if (start_of(g->surface, m) != start_of(g->surface, h)) {
      window.from = frame.length - to;
      window.to = frame.length - from;
      window.x = frame.length - source.x;
    }
    g->stack[g->stack_count++] = window;
  }
}

// The length of the path through the window to a point beyond it: straight where the window lets it pass, else around
// the window's end, which is a real path too but longer.
double path_through(const Window& w, Planar point) {
  const double height = w.y + point.y;
  const double straight = height > 0 ? w.x + (point.x - w.x) * (w.y / height) : clamp(point.x, w.from, w.to);
  const double x = clamp(straight, w.from, w.to);
  if (x == straight) return w.sigma + hypotenuse(point.x - w.x, height);
  return w.sigma + hypotenuse(x - w.x, w.y) + hypotenuse(point.x - x, point.y);
}

void light_candidates(Geodesic* g, const Window& w, const Frame& frame, uint32_t triangle) {
  for (uint32_t i = g->near_head[triangle]; i != k_no_index; i = g->near.next[i]) {
    const double d = path_through(w, unfold(frame, to_vector(g->records[g->near.record[i]].position)));
    if (d < g->near.distance[i]) g->near.distance[i] = d;
  }
}

double fraction(double numerator, double denominator) {
  return denominator != 0 ? clamp(numerator / denominator, 0, 1) : 1;
}

void cross_triangle(Geodesic* g, const Window& w, bool queue) {
  const uint32_t h = w.half_edge, right = next_half_edge(h), left = previous_half_edge(h);
  const Frame frame = frame_of(*g, h);
  light_candidates(g, w, frame, h / 3);
  const uint32_t apex = start_of(g->surface, left);
  const Planar c = unfold(frame, place_of(*g, apex));
  offer(g, apex, path_through(w, c), queue);

  // The line from the source to the apex splits the window in two where it crosses the edge.
  const double height = w.y + c.y, split = height > 0 ? w.x + (c.x - w.x) * (w.y / height) : c.x;
  // A source on the edge's own line sees either the whole triangle or only that line.
  const bool on_edge = !(w.y > 1e-12 * frame.length), sees_all = on_edge && w.x >= w.from && w.x <= w.to;
  if (on_edge && !sees_all) return;

  if (sees_all || w.from < split) {
    const Frame far = frame_of(*g, left);  // from the apex to the start of h
    const auto hit = [&](double t) { return fraction(w.y * t, c.x * w.y - c.y * (t - w.x)); };
    const double near_end = sees_all ? 0 : hit(w.from), far_end = sees_all || split <= w.to ? 1 : hit(w.to);
    const double dx = -c.x, dy = -c.y, inverse = far.length > 0 ? 1 / far.length : 0;
    const double sx = w.x - c.x, sy = -w.y - c.y;
    const Planar source = {(sx * dx + sy * dy) * inverse, absolute(sx * dy - sy * dx) * inverse};
    cross_edge(g, left, far, far.length * (1 - far_end), far.length * (1 - near_end), source, w.sigma, w.depth + 1,
               w.forked != 0);
  }
  if (sees_all || w.to > split) {
    const Frame far = frame_of(*g, right);  // from the end of h to the apex
    const double l = frame.length;
    const auto hit = [&](double t) { return fraction(w.y * (t - l), (c.x - l) * w.y - c.y * (t - w.x)); };
    const double near_end = sees_all ? 0 : hit(w.to), far_end = sees_all || split >= w.from ? 1 : hit(w.from);
    const double dx = c.x - l, dy = c.y, inverse = far.length > 0 ? 1 / far.length : 0;
    const double sx = w.x - l, sy = -w.y;
    const Planar source = {(sx * dx + sy * dy) * inverse, absolute(sx * dy - sy * dx) * inverse};
    cross_edge(g, right, far, far.length * near_end, far.length * far_end, source, w.sigma, w.depth + 1, w.forked != 0);
  }
}

void drain_windows(Geodesic* g, bool queue) {
  while (g->stack_count > 0) {
    const Window window = g->stack[--g->stack_count];
    cross_triangle(g, window, queue);
  }
}

// `source`, a point of the triangle, sees everything in the triangle directly, and through the edge h what lies behind
// it.
void light_triangle(Geodesic* g, Vector source, double sigma, uint32_t triangle) {
  for (uint32_t i = g->near_head[triangle]; i != k_no_index; i = g->near.next[i]) {
    const double d = sigma + length(to_vector(g->records[g->near.record[i]].position) - source);
    if (d < g->near.distance[i]) g->near.distance[i] = d;
  }
}

void light_across(Geodesic* g, Vector source, double sigma, uint32_t h) {
  const Frame frame = frame_of(*g, h);
  cross_edge(g, h, frame, 0, frame.length, unfold(frame, source), sigma, 1, false);
}

// ---------------------------------------------------------------- the three phases

// The two edges of a triangle that meet at v, one of which is h.
void relax_ends(Geodesic* g, uint32_t v, uint32_t h) {
  const uint32_t ends[2] = {end_of(g->surface, h), start_of(g->surface, previous_half_edge(h))};
  for (uint32_t end : ends) offer(g, end, g->distance[v] + length(place_of(*g, end) - place_of(*g, v)), true);
}

// Dijkstra along the edges. It gives upper bounds of the vertices' distances, by which most useless windows are dropped
// at once.
void bound_vertices(Geodesic* g) {
  while (g->heap_count > 0) {
    const uint32_t v = heap_take(g);
    for (uint32_t i = g->surface.corner_first[v]; i < g->surface.corner_first[v + 1]; ++i)
      relax_ends(g, v, g->surface.corners[i]);
  }
}

// A vertex that is taken from the heap has its final distance: all that is found later is further away.
void turn_at_vertices(Geodesic* g) {
  for (uint32_t i = 0; i < g->touched_count; ++i) g->heap_place[g->touched[i]] = k_no_index;
  for (uint32_t i = 0; i < g->touched_count; ++i) heap_insert_or_rise(g, g->touched[i]);
  while (g->heap_count > 0) {
    const uint32_t v = heap_take(g);
    if (!g->surface.bends[v]) continue;
    const Vector here = place_of(*g, v);
    for (uint32_t i = g->surface.corner_first[v]; i < g->surface.corner_first[v + 1]; ++i) {
      const uint32_t h = g->surface.corners[i];
      relax_ends(g, v, h);
      light_triangle(g, here, g->distance[v], h / 3);
      light_across(g, here, g->distance[v], next_half_edge(h));
      drain_windows(g, true);
    }
  }
}

}  // namespace

Geodesic lay_out_geodesic(Layout* layout, const sandglass_mesh* mesh, uint64_t candidates) {
  const uint64_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
  Geodesic g = {};
  g.surface = lay_out_geodesic_mesh(layout, mesh);
  g.near.record = layout_region<uint32_t>(layout, "sampling.geodesic.near.record", candidates);
  g.near.next = layout_region<uint32_t>(layout, "sampling.geodesic.near.next", candidates);
  g.near.distance = layout_region<double>(layout, "sampling.geodesic.near.distance", candidates);
  g.near_head = layout_region<uint32_t>(layout, "sampling.geodesic.near.head", triangles);
  g.distance = layout_region<double>(layout, "sampling.geodesic.distance", vertices);
  g.heap = layout_region<uint32_t>(layout, "sampling.geodesic.heap", vertices);
  g.heap_place = layout_region<uint32_t>(layout, "sampling.geodesic.heap_place", vertices);
  g.touched = layout_region<uint32_t>(layout, "sampling.geodesic.touched", vertices);
  // In a depth-first walk every step removes one window and adds two, so the stack never exceeds the depth plus two. A
  // shortest path crosses a triangle once. The second term is for edges with three or more triangles.
  g.stack_capacity = 2 * triangles + 64;
  g.stack = layout_region<Window>(layout, "sampling.geodesic.stack", g.stack_capacity);
  return g;
}

void build_geodesic(Geodesic* g, const Candidate* records) {
  build_geodesic_mesh(g->surface);
  g->records = records;
  for (uint32_t v = 0; v < g->surface.mesh->vertex_count; ++v) {
    g->distance[v] = k_far;
    g->heap_place[v] = k_no_index;
  }
  for (uint32_t t = 0; t < g->surface.mesh->triangle_count; ++t) g->near_head[t] = k_no_index;
}

void begin_near(Geodesic* g) { g->near.count = 0; }

void add_near(Geodesic* g, uint32_t record) {
  const uint32_t i = g->near.count++, triangle = g->records[record].triangle;
  g->near.record[i] = record;
  g->near.distance[i] = k_far;
  g->near.next[i] = g->near_head[triangle];
  g->near_head[triangle] = i;
}

void measure_near(Geodesic* g, const float source[3], uint32_t triangle, double radius) {
  g->radius = radius;
  g->heap_count = g->touched_count = g->stack_count = 0;
  const Vector here = to_vector(source);
  light_triangle(g, here, 0, triangle);
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t v = start_of(g->surface, 3 * triangle + k);
    offer(g, v, length(place_of(*g, v) - here), true);
  }
  bound_vertices(g);
  for (uint32_t k = 0; k < 3; ++k) light_across(g, here, 0, 3 * triangle + k);
  drain_windows(g, false);
  turn_at_vertices(g);

  for (uint32_t i = 0; i < g->touched_count; ++i) {
    g->distance[g->touched[i]] = k_far;
    g->heap_place[g->touched[i]] = k_no_index;
  }
  for (uint32_t i = 0; i < g->near.count; ++i) g->near_head[g->records[g->near.record[i]].triangle] = k_no_index;
}

}  // namespace sandglass
