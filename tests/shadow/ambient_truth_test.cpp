// Baked ambient shadows and surfaces against rays: the shipped chair in rooms that it was not fitted to, with controls
// that must fail; a turned object; vertices in the light of rooms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "models/baking/ambient_errors.h"
#include "models/baking/light_cells.h"
#include "models/baking/shadow_runner.h"
#include "models/baking/surface.h"
#include "models/baking/truth.h"
#include "models/files/aligned_bytes.h"
#include "models/mesh/generated.h"
#include "models/rooms/room_render.h"
#include "models/tracing/directions.h"
#include "models/work/random.h"
#include "runtime/asset/shadow_asset.h"
#include "runtime/light/harmonics.h"

namespace {

using namespace sandglass;
using namespace sandglass::host;
using Cells = std::array<double, SANDGLASS_LIGHT_CELLS>;

constexpr uint32_t k_rays = 96;
constexpr double k_yaw = 0.9;  // radians: 2.3 sectors

struct Chair {
  Mesh mesh = make_chair();
  std::string bytes = read_file(SANDGLASS_SHADOWS_DIR "/chair.shadow", "baked shadow");
  AlignedBytes aligned{std::string_view(bytes)};
  ShadowAsset asset = {};
  StandingObject object = stand_on_plane(mesh, "chair");
  EmbreeScene scene = EmbreeScene::triangles(object.mesh.vertices, object.mesh.indices, RTC_BUILD_QUALITY_HIGH);
  FloorSquare square;
  ThreadPool pool{1};
  ShadowRunner runner{{reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()},
                      "chair",
                      SANDGLASS_ISA_AUTOMATIC,
                      SANDGLASS_SHADOW_ADAPTIVE};

  Chair() {
    const char* reason = nullptr;
    EXPECT_EQ(open_shadow_asset(aligned.data(), bytes.size(), &asset, &reason), SANDGLASS_OK) << reason;
    square = {asset.ambient.half / object.scale, asset.ambient.side};
  }
  std::vector<float> truth(const Environment& room, uint64_t seed, uint32_t rays = k_rays) {
    return trace_ambient(scene, square, room, rays, seed, pool);
  }
};

// Without the noise of the truth, of which there are two (models/baking/ambient_errors.cpp).
double error_of(const std::vector<uint8_t>& texture, const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t t = 0; t < texture.size(); ++t)
    sum += (texture[t] / 255.0 - static_cast<double>(a[t])) * (texture[t] / 255.0 - static_cast<double>(b[t]));
  return std::sqrt(std::max(0.0, sum / static_cast<double>(texture.size())));
}

Cells moved(const Cells& cells, const std::function<uint32_t(uint32_t)>& sector) {
  Cells result = {};
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i)
    result[i / k_cell_sectors * k_cell_sectors + sector(i % k_cell_sectors) % k_cell_sectors] = cells[i];
  return result;
}

// The bar: half of what is left with ambient occlusion alone. With a wrong azimuth the shadow is worse than that alone.
TEST(AmbientTruth, TheChairsShadowIsWhatRaysSayAndControlsAreNot) {
  Chair chair;
  const std::vector<Environment> rooms = made_up_environments(8, 1);
  Cells uniform;
  uniform.fill(1.0 / SANDGLASS_LIGHT_CELLS);
  const std::vector<uint8_t> occlusion = chair.runner.ambient(uniform);
  double drawn = 0, alone = 0, mirrored = 0, turned = 0;
  for (size_t r = 0; r < rooms.size(); ++r) {
    const Cells& cells = rooms[r].cells();
    const std::vector<float> a = chair.truth(rooms[r], 100 + r), b = chair.truth(rooms[r], 200 + r);
    const auto error = [&](const Cells& q) {
      return error_of(chair.runner.ambient(q), a, b) / static_cast<double>(rooms.size());
    };
    drawn += error(cells);
    alone += error_of(occlusion, a, b) / static_cast<double>(rooms.size());
    mirrored += error(moved(cells, [](uint32_t s) { return k_cell_sectors - 1 - s; }));
    turned += error(moved(cells, [](uint32_t s) { return s + k_cell_sectors / 4; }));
  }
  std::printf("RMSE drawn %.4f, occlusion alone %.4f, mirrored %.4f, turned %.4f\n", drawn, alone, mirrored, turned);
  EXPECT_LE(drawn, 0.5 * alone);
  EXPECT_GT(mirrored, alone);
  EXPECT_GT(turned, alone);
}

TEST(AmbientTruth, TheFileStatesItsError) {
  Chair chair;
  const std::vector<float> hidden(size_t{chair.square.side} * chair.square.side * SANDGLASS_LIGHT_CELLS);
  const AmbientCandidate candidate = {
      chair.scene, chair.square, hidden, {reinterpret_cast<const uint8_t*>(chair.bytes.data()), chair.bytes.size()}};
  const AmbientErrors errors = measure_ambient(candidate, made_up_environments(8, 1), 77, chair.pool);
  EXPECT_NEAR(errors.shipped, static_cast<double>(chair.asset.ambient.rmse), 0.001);
  EXPECT_LE(errors.shipped, 0.5 * errors.occlusion);
}

// Nothing is drawn beyond the square, so the texture ends without a seam, whatever the light.
TEST(AmbientTruth, NothingIsHiddenAlongTheRim) {
  Chair chair;
  const uint32_t last = chair.square.side - 1;
  for (uint32_t cell = 0; cell < SANDGLASS_LIGHT_CELLS; ++cell) {
    Cells single = {};
    single[cell] = 1;
    const std::vector<uint8_t> texture = chair.runner.ambient(single);
    EXPECT_LT(*std::min_element(texture.begin(), texture.end()), 128) << cell;
    for (uint32_t i = 0; i <= last; ++i)
      for (const uint32_t texel : {i, last * (last + 1) + i, i * (last + 1), i * (last + 1) + last})
        ASSERT_EQ(texture[texel], 255) << cell;
  }
}

// Rays against the turned mesh, in the world; the texture stays in the object's frame. Yaw of the wrong sign must fail.
TEST(AmbientTruth, YawTurnsTheLightAgainstTheObject) {
  Chair chair;
  const float up[3] = {0, 1, 0};
  float rotation[4];
  ASSERT_EQ(sandglass_rotation_about(up, static_cast<float>(k_yaw), rotation), 1);
  const Quaternion turn = {rotation[0], rotation[1], rotation[2], rotation[3]};
  Mesh turned = chair.object.mesh;
  for (size_t i = 0; i < turned.vertices.size(); i += 3)
    to_floats(rotate(turn, from_floats(&turned.vertices[i])), &turned.vertices[i]);
  const EmbreeScene scene = EmbreeScene::triangles(turned.vertices, turned.indices);
  const double step = 2 * chair.square.half / chair.square.side;
  double squares[3] = {};
  uint32_t count = 0;
  for (const Environment& room : made_up_environments(4, 1)) {
    std::array<float, SANDGLASS_LIGHT_CELLS> cells;
    for (size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<float>(room.cells()[i]);
    std::vector<std::vector<uint8_t>> textures;
    for (const double yaw : {k_yaw, 0.0, -k_yaw}) {
      ASSERT_EQ(sandglass_shadow_set_cells(chair.runner.handle(), cells.data(), static_cast<float>(yaw), nullptr),
                SANDGLASS_OK);
      sandglass_shadow* const handle = chair.runner.handle();
      while (sandglass_shadow_run(&handle, 1, 100) > 0) {
      }
      sandglass_texture now = {};
      now.struct_size = sizeof now;
      sandglass_shadow_get_ambient(handle, &now);
      textures.emplace_back(now.bytes, now.bytes + now.side * now.side);
    }
    for (uint32_t v = 1; v < chair.square.side; v += 3)
      for (uint32_t u = 1; u < chair.square.side; u += 3, ++count) {
        double truth[2] = {};
        uint64_t random = random_mix(count);
        for (uint32_t i = 0; i < 2 * k_rays; ++i) {
          double at[5];
          for (double& x : at) {
            random = random_mix(random);
            x = random_unit(random);
          }
          const Vec3 place = {step * (u + at[0]) - chair.square.half, 0, step * (v + at[1]) - chair.square.half};
          truth[i % 2] +=
              scene.occluded(rotate(turn, place) + Vec3{0, 1e-5, 0}, room.direction(at[2], at[3], at[4]), 1e9)
                  ? 0.0
                  : 1.0 / k_rays;
        }
        for (size_t method = 0; method < 3; ++method) {
          const double drawn = textures[method][size_t{v} * chair.square.side + u] / 255.0;
          squares[method] += (drawn - truth[0]) * (drawn - truth[1]);
        }
      }
  }
  std::printf("RMSE with yaw %.4f, without %.4f, of the wrong sign %.4f\n", std::sqrt(squares[0] / count),
              std::sqrt(squares[1] / count), std::sqrt(squares[2] / count));
  EXPECT_LE(squares[0], 0.4 * squares[1]);
  EXPECT_LE(squares[0], 0.4 * squares[2]);
}

// A ball hides nothing of itself, so its coefficients are those of the clamped cosine about the normal: 1, 2/3 and 1/4
// times the harmonic. Rays are 576; a byte has half a step.
TEST(SurfaceTruth, OfABallTheClampedCosineIsLeft) {
  const Mesh ball = make_icosphere(0.5f, 4);
  const EmbreeScene scene = EmbreeScene::triangles(ball.vertices, ball.indices);
  const std::vector<SurfacePoint> points = surface_points(ball);
  ASSERT_EQ(points.size(), ball.vertex_count());  // no creases
  ThreadPool pool(1);
  const std::vector<float> transfer = trace_transfer(points, scene, 1, pool, [](uint32_t) { return true; });
  double worst = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double n[3] = {points[i].normal.x, points[i].normal.y, points[i].normal.z};
    double polynomials[k_transfer];
    harmonic_polynomials(n, polynomials);
    for (uint32_t j = 0; j < k_transfer; ++j)
      worst = std::max(worst, std::fabs(static_cast<double>(transfer[i * k_transfer + j]) -
                                        k_cosine_factors[j] * k_harmonic_factors[j] * polynomials[j]));
  }
  EXPECT_LE(worst, 0.02);
}

// `count` points anywhere on a mesh, on no vertex, that are not inside another part of it.
std::vector<SurfacePoint> points_anywhere(const Mesh& mesh, const EmbreeScene& scene, size_t count) {
  std::vector<double> areas = {0};
  const auto corner = [&mesh](size_t i) { return from_floats(&mesh.vertices[3 * size_t{mesh.indices[i]}]); };
  const auto across = [&corner](size_t t) { return cross(corner(t + 1) - corner(t), corner(t + 2) - corner(t)); };
  for (size_t t = 0; t < mesh.indices.size(); t += 3) areas.push_back(areas.back() + length(across(t)));
  std::vector<SurfacePoint> points;
  for (uint64_t random = 1; points.size() < count;) {
    double drawn[3];
    for (double& x : drawn) {
      random = random_mix(random);
      x = random_unit(random);
    }
    const auto above = std::upper_bound(areas.begin() + 1, areas.end() - 1, drawn[0] * areas.back());
    const size_t t = 3 * static_cast<size_t>(above - areas.begin() - 1);
    const double root = std::sqrt(drawn[1]), u = root * (1 - drawn[2]), v = root * drawn[2];
    SurfacePoint p = {corner(t) * (1 - root) + corner(t + 1) * u + corner(t + 2) * v, normalised(across(t))};
    int open = 0;
    for (uint32_t s = 0; s < 64; ++s) {
      const Vec3 d = cosine_direction(p.normal, (s % 8 + 0.5) / 8, (s / 8 + 0.5) / 8);
      open += scene.occluded(p.position + p.normal * 1e-4, d, 1e9) ? 0 : 1;
    }
    if (open > 0) points.push_back(p);
  }
  return points;
}

// Between the chair's own vertices points are baked too, and none that lies where a leg ends in the seat.
TEST(SurfaceTruth, PointsLieEverywhereAndNoneIsBuried) {
  Chair chair;
  EXPECT_GT(chair.asset.surface.vertices, 14u * 24u);  // boxes: three sides at each of eight corners
  for (uint32_t i = 0; i < chair.asset.surface.vertices; ++i)
    EXPECT_GT(chair.asset.surface.transfer[k_transfer * i], 0) << i;
  std::vector<SurfacePoint> points(3);
  std::vector<float> transfer(3 * k_transfer, 0.1f);
  points[1].position = {1, 2, 3};
  points[2].position = {4, 5, 6};
  transfer[k_transfer] = 0.005f;
  transfer[2 * k_transfer + 8] = 0.7f;
  drop_buried(&points, &transfer);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].position.y, 5);
  EXPECT_EQ(transfer.back(), 0.7f);
}

// The light that reaches points of the chair in made-up rooms, by rays, and by the coefficients that the runtime looks
// up. The points are not those that were baked.
TEST(SurfaceTruth, ShadesTheChairAsRaysDoAndBetterThanWithoutVisibility) {
  Chair chair;
  const EmbreeScene scene = EmbreeScene::triangles(chair.mesh.vertices, chair.mesh.indices);
  const std::vector<SurfacePoint> points = points_anywhere(chair.mesh, scene, 600);
  std::vector<float> positions, normals, transfer(points.size() * k_transfer);
  for (const SurfacePoint& p : points) {
    for (const double x : {p.position.x, p.position.y, p.position.z}) positions.push_back(static_cast<float>(x));
    for (const double x : {p.normal.x, p.normal.y, p.normal.z}) normals.push_back(static_cast<float>(x));
  }
  ASSERT_EQ(sandglass_shadow_transfer(chair.aligned.data(), chair.bytes.size(), positions.data(), normals.data(),
                                      static_cast<uint32_t>(points.size()), transfer.data(), nullptr),
            SANDGLASS_OK);
  double squares[2] = {}, level = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const RadianceMap room = trace_room(make_room(880'000 + seed), {128, 8, 1}).radiance;
    double sh[k_transfer] = {}, polynomials[k_transfer];
    for (int v = 0; v < room.height; ++v)
      for (int u = 0; u < room.width; ++u) {
        const Vec3 d = panorama_direction(u, v, room.width, room.height);
        const double direction[3] = {d.x, d.y, d.z};
        harmonic_polynomials(direction, polynomials);
        for (uint32_t j = 0; j < k_transfer; ++j)
          sh[j] += k_harmonic_factors[j] * polynomials[j] * luminance(room.colour(u, v)) *
                   pixel_solid_angle(v, room.width, room.height);
      }
    double mean = 0;
    std::vector<std::array<double, 3>> values;
    for (size_t i = 0; i < points.size(); ++i) {
      uint64_t random = random_mix(seed * 10'007 + i);
      double traced = 0, baked = 0, open = 0;
      constexpr uint32_t k_strata = 32;
      for (uint32_t s = 0; s < k_strata * k_strata; ++s) {
        random = random_mix(random);
        const double a = (s % k_strata + random_unit(random)) / k_strata;
        random = random_mix(random);
        const Vec3 d = cosine_direction(points[i].normal, a, (s / k_strata + random_unit(random)) / k_strata);
        if (!scene.occluded(points[i].position + points[i].normal * 1e-4, d, 1e9))
          traced += luminance(look_up(room, d)) / (k_strata * k_strata);
      }
      const double n[3] = {points[i].normal.x, points[i].normal.y, points[i].normal.z};
      harmonic_polynomials(n, polynomials);
      for (uint32_t j = 0; j < k_transfer; ++j) {
        baked += sh[j] * static_cast<double>(transfer[i * k_transfer + j]);
        open += sh[j] * k_cosine_factors[j] * k_harmonic_factors[j] * polynomials[j];
      }
      mean += traced / static_cast<double>(points.size());
      values.push_back({traced, baked, open});
    }
    for (const auto& [traced, baked, open] : values) {
      squares[0] += std::pow((baked - traced) / mean, 2);
      squares[1] += std::pow((open - traced) / mean, 2);
      level += 1;
    }
  }
  std::printf("RMSE of the irradiance over its mean: %.3f, without visibility %.3f\n", std::sqrt(squares[0] / level),
              std::sqrt(squares[1] / level));
  EXPECT_LE(squares[0], 0.25 * squares[1]);
}

}  // namespace
