// How far an estimated light turns with the camera, which a room's light does not. A camera stands in a panorama and
// then turns by 90 degrees; the runtime estimates the light and filters it in the world's frame, as in an app. Two
// yardsticks: the labels of the same views, which move a little because they belong to the place in front of the
// camera, and a light that is fixed to the camera.
#pragma once

#include <string>
#include <vector>

#include "models/lighting/lit_view.h"

namespace sandglass::host {

constexpr double k_turn_deg = 90.0, k_turn_step_deg = 3.0;  // an estimate each step
constexpr int k_standing_estimates = 12;                    // before it turns; a quarter of a second each
constexpr int k_label_steps = 15;                           // labels are looked up every so many steps

// Directions towards the light in the panorama's frame, from the first step of the turn to its end. `fixed`: the first
// filtered direction, turned with the camera.
struct Turn {
  std::vector<Vec3> filtered, latest, labels, fixed;
};

// The first view is level and looks along azimuth `phi`. A Failure names a file that is not a network.
Turn turn_camera(const std::string& network, const LitPanorama& panorama, double phi);

// Root mean square of the angles from the directions to their mean, degrees.
double wander_deg(const std::vector<Vec3>& directions);

}  // namespace sandglass::host
