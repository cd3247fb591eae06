// Sand in bulk, with laws from the laboratory as the truth: collapsing columns, draining silos, loaded tubes, piles.
// Every function takes solver settings, friction and radius from the description and sets the capacities itself. d is
// the diameter of a particle. Sand always starts as a random pouring: a lattice would collapse along its own axes.
// `step` is called after every frame; an exception that it throws ends the case.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

using CaseStep = std::function<void()>;

// A column is let go on a floor and leaves a deposit. a = height over radius.
//
// Run-out (R - R0)/R0. The deposit is the particles that a chain of neighbours less than 1.1 d apart joins to its
// middle, so single ones that slide ahead do not count. R is the mean, over 24 sectors about the axis, of the distance
// of the outermost of them, plus r: the front as Staron and Hinch (2005) define it for particles.
struct Collapse {
  double runout = 0.0;
  double packing = 0.0;  // of the column before it was let go
};
struct CollapseSetting {
  double aspect = 1.0, radius_d = 12.0, seconds = 3.0;  // radius_d: R0 in d
  uint64_t seed = 1;
  bool at_far_end = false;  // 900 m from the scene's origin
};
Collapse collapse(const sandglass_scene_desc& desc, const CollapseSetting& setting, const CaseStep& step);
double lube_runout(double aspect);  // Lube et al. 2004: 1.24 a, above 1.7 1.6 sqrt(a)

// The angle of repose by draining, in degrees. A column stands on a round platform of its own radius. Its tube is taken
// away; what cannot stay falls off the rim, and what stays is a pile whose toe is the rim. The angle is that of a cone
// of the pile's volume on the platform, so no line has to be fitted to a surface of a few particles.
double repose(const sandglass_scene_desc& desc, double radius_d, double aspect, uint64_t seed, const CaseStep& step);

// A flat-bottomed silo 40 d wide, kept more than 20 d full by an emitter that pours back what the sink has taken.
struct Discharge {
  double orifice_d = 0.0;  // D in d
  double rate = 0.0;       // particles a second, mean
  double unsteady = 0.0;   // largest deviation of a quarter of the time from the mean, relative
  double head_d = 0.0;     // least height of the bed while it was measured, in d
};
struct DischargeSetting {
  std::vector<double> orifices_d;
  double settle_seconds = 2.0;  // the filled bed is denser than a flowing one
  // The measurement ends when so many particles have come out, or after so many seconds. The count of a quarter of them
  // has an error of 1.3 % if they come at random. Near the width at which sand arches they come in gusts: more.
  double enough_particles = 24000.0, measure_seconds = 80.0;
};
struct DischargeCurve {
  std::vector<Discharge> points;
  double exponent = 0.0;  // of the rate in D - 1.4 d, least squares
  double packing = 0.0;
};
DischargeCurve discharge(const sandglass_scene_desc& desc, const DischargeSetting& setting, const CaseStep& step);

// How much of the sand's weight the bottom of a tube carries. The tube is 8 d wide and filled to several heights. The
// floor is left out for one sub-step in each frame. Colliders come last in a sub-step, so how far the sand sinks below
// the floor is how far the floor would have lifted it: that is the load. The scene itself is measured, not a restored
// copy, whose lists are new. By Janssen's law the walls take what is added to a high column.
struct TubeLoad {
  double marginal = 0.0;  // (load of the fullest - load of the middle filling) / (difference of their weights)
  double carried = 0.0;   // load of the fullest / its weight
};
TubeLoad tube_load(const sandglass_scene_desc& desc, bool frictionless, const CaseStep& step);

}  // namespace sandglass::host
