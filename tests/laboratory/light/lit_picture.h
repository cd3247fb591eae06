// The picture of an object in the light that labels describe, from its pictures in a directional and an ambient light of
// strength 1. The directional light is as strong as makes its share of the level floor's irradiance the contrast.
#pragma once

#include "models/lighting/labels.h"

namespace sandglass::host {

// No channel of the result is above 1. The labels' direction has y up.
RadianceMap lit_by(const LightLabels& labels, const RadianceMap& directional, const RadianceMap& ambient);
// What a camera with this tone map shows of it. No channel is above 1.
RadianceMap shown_by(RadianceMap radiance, double white);

}  // namespace sandglass::host
