// See bake_ambient.h.
#include "models/baking/bake_ambient.h"

#include <algorithm>

#include "models/baking/shadow_runner.h"
#include "models/work/progress.h"

namespace sandglass::host {
namespace {

constexpr size_t k_pictures = 2;  // rooms in the picture

}  // namespace

bool bake_ambient(const AmbientSettings& settings, uint64_t seed, uint32_t threads, ShadowFile* file,
                  AmbientReport* report, std::vector<Picture>* pictures) {
  if (settings.texels == 0) return true;
  const StandingObject& object = file->geometry.object;
  const EmbreeScene scene = EmbreeScene::triangles(object.mesh.vertices, object.mesh.indices, RTC_BUILD_QUALITY_HIGH);
  const FloorSquare square = ambient_square(object.box, settings.texels);
  ThreadPool pool(threads);
  Progress rows("tracing the floor", square.side);
  const std::vector<float> hidden =
      trace_hidden(scene, square, HiddenOf::cells, seed, pool, [&](uint32_t done) { return rows.goes_on(done); });
  if (hidden.empty()) return false;
  std::vector<SurfacePoint> points = surface_points(object.mesh);
  Progress vertices("tracing the surface", static_cast<uint32_t>(points.size()));
  std::vector<float> transfer =
      trace_transfer(points, scene, seed, pool, [&](uint32_t done) { return vertices.goes_on(done); });
  if (transfer.empty()) return false;
  drop_buried(&points, &transfer);
  file->surface = round_surface(points, transfer);
  file->ambient = find_components(square, hidden, settings.components);

  const std::vector<Environment> rooms = made_up_environments(settings.rooms, threads);
  if (interrupted()) return false;
  const std::vector<uint8_t> bytes = shadow_file_bytes(*file);
  const AmbientCandidate candidate = {scene, square, hidden, bytes};
  report->made_up = measure_ambient(candidate, rooms, seed, pool);
  file->ambient.rmse = report->made_up.shipped;
  if (!settings.data.empty())
    report->captured = measure_ambient(candidate, captured_environments(settings.data), seed, pool);
  report->components = file->ambient.components;
  report->points = file->surface.vertices;
  report->ms = ShadowRunner(bytes, "baked", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE).ambient_ms();
  if (pictures != nullptr)
    *pictures = ambient_pictures(candidate, std::span(rooms).first(std::min(k_pictures, rooms.size())), pool);
  return !interrupted();
}

}  // namespace sandglass::host
