#include "tests/laboratory/light/lighting_floor.h"

#include <algorithm>
#include <limits>

#include "models/rooms/panorama_file.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

constexpr double k_radius = 0.25;
constexpr const char* k_estimate = "estimate and ambient occlusion";

OneLight in_panorama(const View& view, LightLabels light) {
  return {ViewRotation(view).to_panorama(camera_to_rotated(light.direction)), light.contrast};
}

// The lights of a view: all contenders', then the estimate's mirror image.
std::vector<OneLight> lights_of(const LightView& view) {
  std::vector<OneLight> lights;
  for (const LightLabels& light : view.lights) lights.push_back(in_panorama(view.view, light));
  LightLabels mirrored = view.lights[static_cast<size_t>(Contender::estimate)];
  mirrored.direction.x *= -1;
  lights.push_back(in_panorama(view.view, mirrored));
  return lights;
}

}  // namespace

LightingFloor lighting_floor(const LightingVerdicts& verdicts, std::shared_ptr<const std::vector<FloorObject>> objects,
                             uint32_t threads) {
  LightingFloor floor = {{std::move(objects), std::vector<StudiedPlace>(verdicts.views.size())}, {}};
  const size_t each = verdicts.views.size() / verdicts.pictures.size();  // views of a panorama
  for_all(verdicts.pictures.size(), threads, "floors", [&](size_t i) {
    RadianceMap panorama = read_panorama(verdicts.views[i * each].path);
    fill_tripod(&panorama);
    const RadianceMap coarse = halved(panorama);
    for (size_t k = i * each; k < (i + 1) * each && !interrupted(); ++k) {
      const LightView& view = verdicts.views[k];
      StudiedPlace& place = floor.study.places[k];
      place = place_in(coarse, view.view.phi, k_radius, *floor.study.objects);
      place.panorama = view.path, place.location = view.location, place.estimates = lights_of(view);
    }
  });
  if (interrupted()) return {};
  const RoomStudy& study = floor.study;
  std::vector<Way> ways = {no_shadow(study), ambient_occlusion(study)};
  const auto add = [&](const std::string& name, size_t index, size_t away, double ambient, bool control) {
    const auto light = [&study, index, away](const StudiedPlace& p) {
      const auto at = static_cast<size_t>(&p - study.places.data());
      return study.places[(at + away) % study.places.size()].estimates[index];
    };
    ways.push_back(one_light(study, name, light, ambient, control));
  };
  for (const Contender c : {Contender::mean, Contender::brightest, Contender::grey, Contender::estimate})
    if (verdicts.has[static_cast<size_t>(c)])
      add(std::string(name_of(c)) + " and ambient occlusion", static_cast<size_t>(c), 0, 1.0, false);
  if (verdicts.has_estimate) {
    const auto estimate = static_cast<size_t>(Contender::estimate);
    add("estimate alone", estimate, 0, 0.0, false);
    add("control: estimate mirrored", k_light_sources, 0, 1.0, true);
    add("control: estimate in another room", estimate, study.places.size() / 2, 1.0, true);
  }
  const auto label = [](const StudiedPlace& p) { return p.label; };
  ways.push_back(one_light(study, "true label and ambient occlusion", label, 1.0));
  ways.push_back(in_cells(study, "true light in cells", [](const StudiedPlace& p) { return p.light.cells; }));
  floor.rows = drawn_rows(study, ways);
  return floor;
}

std::vector<Verdict> floor_verdicts(const std::vector<DrawnRow>& rows) {
  std::vector<Verdict> verdicts;
  const bool estimated = std::any_of(rows.begin(), rows.end(), [](const DrawnRow& r) { return r.name == k_estimate; });
  if (!estimated) return verdicts;
  const DrawnRow& estimate = row_of(rows, k_estimate);
  const auto add = [&](const std::string& name, double result, double limit, bool control) {
    verdicts.push_back({"floor", name, "", 0.0, result, limit, control ? result > limit : result <= limit, control});
  };
  add("estimate and AO against no shadow, 97.5 %", estimate.against_none.high, 0.0, false);
  add("estimate and AO against AO alone, mean", estimate.against_ambient.mean, std::numeric_limits<double>::infinity(),
      false);
  for (const DrawnRow& row : rows)
    if (row.control) add(row.name, row.floor.mean, estimate.floor.mean, true);
  return verdicts;
}

}  // namespace sandglass::host
