// The light that a shot is drawn in, whoever says so: the session's room, the true light, or one light alone. All are
// sandglass_room_light in the scene's frame and in the picture's scale, where radiance 1 is white; so one way of drawing
// serves them all.
#pragma once

#include <functional>
#include <span>

#include "models/geometry/vec3.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama.h"
#include "sandglass/estimator.h"
#include "sandglass/room.h"

namespace sandglass::host {

using ShotLight = sandglass_room_light;

// What a shiny thing reflects: the radiance from a direction, in the picture's scale.
using Reflected = std::function<Vec3(Vec3 direction)>;

// The light where the object stands, and where the sand lies.
struct PlacedLight {
  ShotLight object = {}, sand = {};
  Reflected reflected;  // none: what is known is the light of all directions about one
  PlacedLight() = default;
  PlacedLight(const ShotLight& everywhere) : object(everywhere), sand(everywhere) {}
  PlacedLight(const ShotLight& at_object, const ShotLight& at_sand) : object(at_object), sand(at_sand) {}
};

inline Vec3 irradiance_of(const ShotLight& light) { return from_floats(light.irradiance); }
inline Vec3 main_direction_of(const ShotLight& light) { return from_floats(light.main_direction); }
// Towards the middle of the floor's light, main light and all.
Vec3 mean_direction_of(const ShotLight& light);

// The radiance that a white surface shows that faces `normal` and that nothing hides.
Vec3 shown_by(const ShotLight& light, Vec3 normal);
// The part of it that comes from the main light: as the harmonics have it, and by its cosine.
Vec3 main_in_harmonics(const ShotLight& light, Vec3 normal);
Vec3 main_by_cosine(const ShotLight& light, Vec3 normal);

// The part of it that comes from the floor below.
Vec3 from_floor(const ShotLight& light, Vec3 normal);

// The light of a panorama, whose own centre looks along `view`: each cell, harmonics and level as they are. None of it
// is a main light.
ShotLight light_of(const RadianceMap& panorama, View view);
// The same of its upper half, on a floor of this radiance.
ShotLight light_above_floor(const RadianceMap& panorama, View view, Vec3 floor);

// One light and nothing else, as the app draws it that knows of no more: a share of the floor's irradiance is the
// opacity of its shadow, the rest comes from all sides and hides nothing.
ShotLight one_light(Vec3 towards, double share, Vec3 irradiance);
// What the network of estimator.h says.
ShotLight one_light(const sandglass_estimator_light& estimate);

// The light times a factor, with another level or from another scale.
ShotLight scaled(ShotLight light, double factor);
// As if the room were seen in a mirror across the plane z = 0.
ShotLight mirrored(const ShotLight& light);
// The mean light: shares and harmonics as parts of the floor's irradiance, with the geometric mean of the level.
ShotLight mean_light(std::span<const ShotLight> lights);

}  // namespace sandglass::host
