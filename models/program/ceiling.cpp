// `sandglass ceiling PANORAMAS`: what the labels themselves can do, by variant; see models/laboratory/light/ceiling.h.
#include <cstdio>

#include "models/laboratory/light/ceiling.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

void print(const Ceiling& ceiling, size_t rows) {
  std::printf("%zu views of %zu panoramas\n\n", ceiling.views, ceiling.panoramas);
  std::printf("%-15s %-12s %-14s %-13s %8s %8s %8s %8s %8s\n", "colours", "ambient by", "light", "contrast", "RMSE",
              "nRMSE", "siRMSE", "RMLE", "RGB deg");
  for (size_t i = 0; i < std::min(rows, ceiling.variants.size()); ++i) {
    const CeilingVariant& v = ceiling.variants[i];
    const ImageErrors& e = v.mean;
    std::printf("%-15s %-12s %-14s %-13s %8.4f %8.4f %8.4f %8.4f %8.3f\n", name_of(v.range), name_of(v.weight),
                name_of(v.radiometry), v.radiometry == Radiometry::plain ? "-" : name_of(v.contrast), e.rmse,
                e.relative, e.scale_invariant, e.logarithmic, e.angle_deg);
  }
  std::printf("\n%-15s %12s %12s %10s %10s %10s\n", "contrast", "shadow RMSE", "|o - best|", "least o", "mean o",
              "most o");
  for (int c = 0; c < k_contrasts; ++c) {
    const ContrastError& e = ceiling.contrasts[c];
    std::printf("%-15s %12.4f %12.4f %10.3f %10.3f %10.3f\n", name_of(static_cast<Contrast>(c)), e.shadow_rmse,
                e.offset, e.low, e.mean, e.high);
  }
  std::printf("%-15s %12.4f\n", "best possible", ceiling.best_contrast_rmse);
  std::printf("\nlights beyond 45 degrees from the zenith %.1f %%, beyond 70 %.1f %%, below the horizon %.1f %%\n",
              100.0 * ceiling.lights_beyond_45, 100.0 * ceiling.lights_beyond_70, 100.0 * ceiling.lights_below_horizon);
}

}  // namespace

int ceiling_command(const CeilingCommandOptions& options) {
  listen_for_interrupt();
  CeilingOptions ceiling = options.ceiling;
  ceiling.object = named_mesh(options.object).mesh;
  const Ceiling measured = measure_ceiling(ceiling);
  if (interrupted()) return k_exit_interrupted;
  print(measured, options.rows);
  return k_exit_done;
}

}  // namespace sandglass::host
