// See generated.h.
#include "models/mesh/generated.h"

#include <array>
#include <filesystem>
#include <map>

#include "models/files/failure.h"
#include "models/geometry/vec3.h"
#include "runtime/math/math.h"

namespace sandglass::host {
namespace {

// By division: golden hashes depend on its bits.
Vec3 unit(Vec3 a) { return {a.x / length(a), a.y / length(a), a.z / length(a)}; }

void add_vertex(Mesh* mesh, Vec3 p) {
  for (const double x : {p.x, p.y, p.z}) mesh->vertices.push_back(static_cast<float>(x));
}

// The quads of a closed strip of closed rings, each split along the same diagonal. u runs along the strip, v around it;
// u x v points outwards.
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
    const SinCos at_t = sin_cos_turns(t), at_2t = sin_cos_turns(2 * t), at_3t = sin_cos_turns(3 * t);
    const double scale = static_cast<double>(size) / 3;
    const Vec3 centre = {(at_t.sin + 2 * at_2t.sin) * scale, (at_t.cos - 2 * at_2t.cos) * scale, -at_3t.sin * scale};
    const Vec3 first = {at_t.cos + 4 * at_2t.cos, -at_t.sin + 4 * at_2t.sin, -3 * at_3t.cos};
    const Vec3 second = {-at_t.sin - 8 * at_2t.sin, -at_t.cos + 8 * at_2t.cos, 9 * at_3t.sin};
    // Frenet's frame. The knot has curvature everywhere, so the frame exists and closes.
    const Vec3 tangent = unit(first), binormal = unit(cross(first, second)), normal = cross(binormal, tangent);
    for (uint32_t j = 0; j < around; ++j) {
      const SinCos v = sin_cos_turns(static_cast<double>(j) / around);
      add_vertex(&mesh, centre + (normal * v.cos - binormal * v.sin) * static_cast<double>(tube));
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
  std::vector<Vec3> points;
  const auto add = [&](double x, double y, double z) { points.push_back(unit({x, y, z})); };
  for (const double y : {g, -g}) {
    add(-1, y, 0);
    add(1, y, 0);
  }
  for (const double z : {g, -g}) {
    add(0, -1, z);
    add(0, 1, z);
  }
  for (const double x : {g, -g}) {
    add(x, 0, -1);
    add(x, 0, 1);
  }
  std::vector<uint32_t> triangles = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                                     4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                                     6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (uint32_t s = 0; s < subdivisions; ++s) {
    std::map<std::array<uint32_t, 2>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [entry, is_new] =
          middles.emplace(std::array{std::min(a, b), std::max(a, b)}, static_cast<uint32_t>(points.size()));
      if (is_new) points.push_back(unit(points[a] + points[b]));
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
  for (const Vec3 p : points) add_vertex(&mesh, p * static_cast<double>(radius));
  mesh.indices = triangles;
  return mesh;
}

Mesh make_revolved(const Profile& profile, uint32_t around) {
  Mesh mesh;
  const uint32_t corners = static_cast<uint32_t>(profile.size());
  std::vector<uint32_t> first;  // first vertex of each corner: one vertex on the axis, else a ring
  for (const auto& [r, y] : profile) {
    first.push_back(mesh.vertex_count());
    for (uint32_t j = 0; j < (r > 0.0 ? around : 1); ++j) {
      const SinCos turn = sin_cos_turns(static_cast<double>(j) / around);
      add_vertex(&mesh, {r * turn.cos, y, -r * turn.sin});
    }
  }
  for (uint32_t i = 0; i < corners; ++i) {
    const uint32_t next = (i + 1) % corners;
    const bool pole = !(profile[i][0] > 0.0), next_pole = !(profile[next][0] > 0.0);
    if (pole && next_pole) continue;
    for (uint32_t j = 0; j < around; ++j) {
      const uint32_t turned = (j + 1) % around;
      const uint32_t a = first[i] + (pole ? 0 : j), d = first[i] + (pole ? 0 : turned);
      const uint32_t b = first[next] + (next_pole ? 0 : j), c = first[next] + (next_pole ? 0 : turned);
      if (!pole) mesh.indices.insert(mesh.indices.end(), {a, d, b});
      if (!next_pole) mesh.indices.insert(mesh.indices.end(), {b, d, c});
    }
  }
  return mesh;
}

Mesh make_chair() {
  // Low and high corners in metres.
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

namespace {

// The bulb begins to close at this share of half the height. Its flat end has this share of the bulb's radius.
constexpr double k_bulb_closes = 0.75, k_flat_end = 0.6;

}  // namespace

double hourglass_radius(double height, double bulb, double neck, double y) {
  const double t = absolute(y - 0.5 * height) / (0.5 * height);
  if (t > 1.0) return 0.0;
  if (t <= k_bulb_closes) return neck + (bulb - neck) * 0.5 * (1.0 - sin_cos_turns(0.5 * t / k_bulb_closes).cos);
  const double s = (t - k_bulb_closes) / (1.0 - k_bulb_closes);
  return bulb * (k_flat_end + (1.0 - k_flat_end) * square_root(1.0 - s * s));
}

Profile hourglass_profile(double height, double bulb, double neck, uint32_t steps) {
  Profile upper;  // from the neck up to the axis
  for (uint32_t i = 0; i <= steps; ++i) {
    const double t = k_bulb_closes * i / steps;
    upper.push_back({hourglass_radius(height, bulb, neck, 0.5 * height * (1.0 + t)), 0.5 * height * (1.0 + t)});
  }
  for (uint32_t i = 1; i <= steps; ++i) {
    const SinCos turn = sin_cos_turns(0.25 * i / steps);
    upper.push_back({bulb * (k_flat_end + (1.0 - k_flat_end) * turn.cos),
                     0.5 * height * (1.0 + k_bulb_closes + (1.0 - k_bulb_closes) * turn.sin)});
  }
  upper.push_back({0.0, height});
  Profile profile;
  for (size_t i = upper.size() - 1; i > 0; --i) profile.push_back({upper[i][0], height - upper[i][1]});
  profile.insert(profile.end(), upper.begin(), upper.end());
  return profile;
}

Profile bucket_profile(double height, double bottom, double top, double thickness) {
  const double rim = height - 2.0 * thickness;
  return {{0.0, 0.0},
          {bottom, 0.0},
          {bottom + (top - bottom) * rim / height, rim},
          {top + thickness, rim},
          {top + thickness, height},
          {top - thickness, height},
          {bottom - thickness, thickness},
          {0.0, thickness}};
}

Profile silo_profile(double height, double radius, double cone, double outlet, double thickness) {
  return {{outlet, 0.0},
          {outlet + thickness, 0.0},
          {radius + thickness, cone},
          {radius + thickness, height},
          {radius, height},
          {radius, cone}};
}

const std::vector<std::string>& mesh_names() {
  static const std::vector<std::string> names = {"trefoil",   "torus",  "box",  "sphere",
                                                 "hourglass", "bucket", "silo", "chair"};
  return names;
}

MeshResult make_named(const std::string& name) {
  const float cube[3] = {0.1f, 0.1f, 0.1f};
  if (name == "trefoil") return {make_trefoil(), {}, "", {}};
  if (name == "torus") return {make_torus(0.1f, 0.04f, 96, 48), {}, "", {}};
  if (name == "box") return {make_box(cube), {}, "", {}};
  if (name == "sphere") return {make_icosphere(0.1f, 4), {}, "", {}};
  if (name == "hourglass") return {make_revolved(hourglass_profile(0.3, 0.08, 0.02, 48), 96), {}, "", {}};
  if (name == "bucket") return {make_revolved(bucket_profile(0.2, 0.07, 0.1, 0.01), 96), {}, "", {}};
  if (name == "silo") return {make_revolved(silo_profile(0.3, 0.08, 0.1, 0.02, 0.01), 96), {}, "", {}};
  if (name == "chair") return {make_chair(), {}, "", {}};
  std::string list;
  for (const std::string& known : mesh_names()) list += (list.empty() ? "" : ", ") + known;
  return {{}, {}, message("make", name, "no generated mesh has this name", "Take one of " + list), {}};
}

MeshResult named_mesh(const MeshFile& name_or_file) {
  MeshResult result = make_named(name_or_file.path);
  if (result) return result;
  if (std::error_code error; !std::filesystem::exists(name_or_file.path, error))
    throw cannot("find", name_or_file.path, "no file and no generated mesh has this name",
                 "Name a mesh file, or " + list_of(mesh_names(), "or"));
  return load_mesh_for_command(name_or_file);
}

}  // namespace sandglass::host
