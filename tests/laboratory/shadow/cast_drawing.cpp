#include "tests/laboratory/shadow/cast_drawing.h"

#include "models/files/failure.h"
#include "runtime/shadow/cast/cast.h"
#include "tests/laboratory/shadow/app_cast.h"

namespace sandglass::host {

Drawn cast_of(const Mesh& mesh, const Light& light, const CastChoice& choice, Cast* kept) {
  sandglass_cast_desc desc = cast_desc();
  desc.texels = choice.cells ? 0 : choice.texels;
  desc.ambient_texels = choice.cells ? choice.texels : 0;
  desc.triangle_capacity = mesh.triangle_count() + (choice.real != nullptr ? choice.real->triangle_count() : 0);
  Cast fresh;
  Cast& cast = kept != nullptr ? *kept : fresh;
  if (!cast)
    if (const Status made = cast.create(desc); !made) throw Failure(made.reason);
  cast.get()->cast.desc.directions = choice.directions;  // controls take fewer than an app may
  cast.get()->cast.targets[k_cast_light].draft = false;
  sandglass_cast_plane plane = cast_plane();
  if (choice.limits) {
    plane.low[0] = static_cast<float>(choice.limits->low_x);
    plane.low[1] = static_cast<float>(choice.limits->low_z);
    plane.high[0] = static_cast<float>(choice.limits->high_x);
    plane.high[1] = static_cast<float>(choice.limits->high_z);
  }
  std::vector<sandglass_cast_mesh> meshes = {cast_mesh_of(mesh, choice.closed, false)};
  meshes[0].version = choice.version;
  if (choice.real != nullptr) meshes.push_back(cast_mesh_of(*choice.real, true, true));
  std::array<float, 3> towards;
  for (size_t i = 0; i < 3; ++i) towards[i] = static_cast<float>(light.direction[i]);
  (void)cast.set_plane(plane);
  (void)cast.set_meshes(meshes.data(), static_cast<uint32_t>(meshes.size()));
  cast.get()->cast.targets[k_cast_light].draft = false;
  (void)cast.set_light(towards, static_cast<float>(2 * light.half));
  if (choice.cells) (void)cast.set_cells(*choice.cells);
  cast.run();
  const sandglass_texture t = choice.cells ? cast.ambient() : cast.texture();
  Drawn drawn;
  drawn.texels = t.side;
  drawn.open = static_cast<double>(cast.report().open);
  drawn.rectangle = {t.corner[0], t.corner[2], static_cast<double>(t.corner[0]) + static_cast<double>(t.along[0]),
                     static_cast<double>(t.corner[2]) + static_cast<double>(t.across[2])};
  for (uint32_t i = 0; i < t.side * t.side; ++i) {
    const float byte = static_cast<float>(t.bytes[i]) / 255.0f;
    drawn.left.push_back(choice.cells ? byte : 1 - byte);
  }
  return drawn;
}

Truth truth_of(const Mesh& mesh, const Light& light, const Drawn& drawn, uint64_t stream, ThreadPool& pool) {
  const ShadowCaster first(mesh, light.half, {2, 8}, 1), second(mesh, light.half, {2, 8}, 2);
  return {first.texture(drawn.rectangle, light.direction, stream, drawn.texels, pool),
          second.texture(drawn.rectangle, light.direction, stream, drawn.texels, pool)};
}

double error_of(const std::function<double(size_t)>& left, const Truth& truth, double texel, double area) {
  double sum = 0;
  for (size_t i = 0; i < truth.a.size(); ++i)
    sum += (left(i) - static_cast<double>(truth.a[i])) * (left(i) - static_cast<double>(truth.b[i]));
  return std::sqrt(std::max(sum, 0.0) * texel / area);
}

ShadowRectangle fitted(const ShadowBox& box, const Light& light) {
  double low[2] = {0, 0}, high[2] = {0, 0};
  const Direction& d = light.direction;
  const double flat = std::hypot(d[0], d[2]), ax = flat > 0 ? d[0] / flat : 1, az = flat > 0 ? d[2] / flat : 0;
  for (int i = 0; i < 720; ++i) {
    const double f = 2 * std::numbers::pi * i / 720, a = std::sin(light.half) * std::cos(f),
                 b = std::sin(light.half) * std::sin(f);
    const double y = std::max(std::cos(light.half) * d[1] + a * flat, 0.02), p = std::cos(light.half) * flat - a * d[1];
    const double x = (p * ax - b * az) / y, z = (p * az + b * ax) / y, length = std::hypot(x, z),
                 k = length > 4 ? 4 / length : 1;
    low[0] = std::min(low[0], k * x);
    high[0] = std::max(high[0], k * x);
    low[1] = std::min(low[1], k * z);
    high[1] = std::max(high[1], k * z);
  }
  return {-box.half_x - high[0] * box.height, -box.half_z - high[1] * box.height, box.half_x - low[0] * box.height,
          box.half_z - low[1] * box.height};
}

}  // namespace sandglass::host
