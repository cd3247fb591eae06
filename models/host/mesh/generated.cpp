// See generated.h.
#include "models/host/mesh/generated.h"

#include <array>
#include <map>

#include "runtime/core/math.h"

namespace sandglass::host {
namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector normalised(const Vector& a) {
  const double length = square_root(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  return {a[0] / length, a[1] / length, a[2] / length};
}

void add_vertex(Mesh* mesh, const Vector& p) {
  for (double x : p) mesh->vertices.push_back(static_cast<float>(x));
}

// Quads of a closed strip of closed rings, each split along the same diagonal. u runs along, v around, u x v outwards.
void add_tube_triangles(Mesh* mesh, uint32_t along, uint32_t around) {
  for (uint32_t i = 0; i < along; ++i)
    for (uint32_t j = 0; j < around; ++j) {
      const uint32_t a = i * around + j, b = (i + 1) % along * around + j;
      const uint32_t c = (i + 1) % along * around + (j + 1) % around, d = i * around + (j + 1) % around;
      mesh->indices.insert(mesh->indices.end(), {a, b, c, a, c, d});
    }
}

}  // namespace

Mesh make_trefoil(float size, float tube, uint32_t along, uint32_t around) {
  Mesh mesh;
  for (uint32_t i = 0; i < along; ++i) {
    const double t = static_cast<double>(i) / along;
    const SinCos one = sin_cos_turns(t), two = sin_cos_turns(2 * t), three = sin_cos_turns(3 * t);
    const double scale = static_cast<double>(size) / 3;
    const Vector centre = {(one.sin + 2 * two.sin) * scale, (one.cos - 2 * two.cos) * scale, -three.sin * scale};
    const Vector first = {one.cos + 4 * two.cos, -one.sin + 4 * two.sin, -3 * three.cos};
    const Vector second = {-one.sin - 8 * two.sin, -one.cos + 8 * two.cos, 9 * three.sin};
    // Frenet's frame: the knot has curvature everywhere, so it exists and closes.
    const Vector tangent = normalised(first), binormal = normalised(cross(first, second)),
                 normal = cross(binormal, tangent);
    for (uint32_t j = 0; j < around; ++j) {
      const SinCos v = sin_cos_turns(static_cast<double>(j) / around);
      Vector p;
      for (size_t k = 0; k < 3; ++k)
        p[k] = centre[k] + static_cast<double>(tube) * (v.cos * normal[k] - v.sin * binormal[k]);
      add_vertex(&mesh, p);
    }
  }
  add_tube_triangles(&mesh, along, around);
  return mesh;
}

Mesh make_trefoil() { return make_trefoil(0.1f, 0.018f, 400, 32); }

Mesh make_torus(float major, float minor, uint32_t along, uint32_t around) {
  Mesh mesh;
  for (uint32_t i = 0; i < along; ++i) {
    const SinCos u = sin_cos_turns(static_cast<double>(i) / along);
    for (uint32_t j = 0; j < around; ++j) {
      const SinCos v = sin_cos_turns(static_cast<double>(j) / around);
      const double ring = static_cast<double>(major) + static_cast<double>(minor) * v.cos;
      add_vertex(&mesh, {ring * u.cos, static_cast<double>(minor) * v.sin, -ring * u.sin});
    }
  }
  add_tube_triangles(&mesh, along, around);
  return mesh;
}

Mesh make_box(const float size[3]) {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back((corner >> k & 1 ? 0.5f : -0.5f) * size[k]);
  mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

Mesh make_icosphere(float radius, uint32_t subdivisions) {
  const double g = (1 + square_root(5.0)) / 2;
  std::vector<Vector> points;
  for (const Vector& p : {Vector{-1, g, 0},
                          {1, g, 0},
                          {-1, -g, 0},
                          {1, -g, 0},
                          {0, -1, g},
                          {0, 1, g},
                          {0, -1, -g},
                          {0, 1, -g},
                          {g, 0, -1},
                          {g, 0, 1},
                          {-g, 0, -1},
                          {-g, 0, 1}})
    points.push_back(normalised(p));
  std::vector<uint32_t> triangles = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                                     4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                                     6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (uint32_t s = 0; s < subdivisions; ++s) {
    std::map<std::array<uint32_t, 2>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [entry, is_new] =
          middles.emplace(std::array{std::min(a, b), std::max(a, b)}, static_cast<uint32_t>(points.size()));
      if (is_new)
        points.push_back(
            normalised({points[a][0] + points[b][0], points[a][1] + points[b][1], points[a][2] + points[b][2]}));
      return entry->second;
    };
    std::vector<uint32_t> finer;
    for (size_t t = 0; t < triangles.size(); t += 3) {
      const uint32_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca});
    }
    triangles = finer;
  }
  Mesh mesh;
  for (const Vector& p : points)
    add_vertex(&mesh, {p[0] * static_cast<double>(radius), p[1] * static_cast<double>(radius),
                       p[2] * static_cast<double>(radius)});
  mesh.indices = triangles;
  return mesh;
}

Mesh make_chair() {
  // Low and high corners, metres.
  constexpr float k_boxes[][6] = {
      {-0.22f, 0.43f, -0.22f, 0.22f, 0.46f, 0.22f},    // seat
      {-0.21f, 0.00f, 0.17f, -0.17f, 0.43f, 0.21f},    // front legs
      {0.17f, 0.00f, 0.17f, 0.21f, 0.43f, 0.21f},      //
      {-0.21f, 0.00f, -0.21f, -0.17f, 0.43f, -0.17f},  // back legs
      {0.17f, 0.00f, -0.21f, 0.21f, 0.43f, -0.17f},    //
      {-0.21f, 0.46f, -0.21f, -0.17f, 0.90f, -0.17f},  // posts of the back
      {0.17f, 0.46f, -0.21f, 0.21f, 0.90f, -0.17f},    //
      {-0.17f, 0.82f, -0.20f, 0.17f, 0.89f, -0.18f},   // top rail
      {-0.11f, 0.46f, -0.20f, -0.07f, 0.82f, -0.18f},  // slats
      {-0.02f, 0.46f, -0.20f, 0.02f, 0.82f, -0.18f},   //
      {0.07f, 0.46f, -0.20f, 0.11f, 0.82f, -0.18f},    //
      {-0.17f, 0.15f, -0.20f, 0.17f, 0.18f, -0.18f},   // stretchers
      {-0.20f, 0.20f, -0.17f, -0.18f, 0.23f, 0.17f},   //
      {0.18f, 0.20f, -0.17f, 0.20f, 0.23f, 0.17f},     //
  };
  Mesh mesh;
  for (const float(&box)[6] : k_boxes) {
    const float size[3] = {box[3] - box[0], box[4] - box[1], box[5] - box[2]};
    const Mesh part = make_box(size);
    const uint32_t base = mesh.vertex_count();
    for (size_t i = 0; i < part.vertices.size(); ++i)
      mesh.vertices.push_back(part.vertices[i] + 0.5f * (box[i % 3] + box[i % 3 + 3]));
    for (const uint32_t index : part.indices) mesh.indices.push_back(base + index);
  }
  return mesh;
}

MeshResult make_named(const std::string& name) {
  const float cube[3] = {0.1f, 0.1f, 0.1f};
  if (name == "trefoil") return {make_trefoil(), {}, ""};
  if (name == "torus") return {make_torus(0.1f, 0.04f, 96, 48), {}, ""};
  if (name == "box") return {make_box(cube), {}, ""};
  if (name == "sphere") return {make_icosphere(0.1f, 4), {}, ""};
  if (name == "chair") return {make_chair(), {}, ""};
  return {{}, {}, "no generated mesh is called '" + name + "': use trefoil, torus, box, sphere or chair"};
}

}  // namespace sandglass::host
