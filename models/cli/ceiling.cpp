// `sandglass ceiling PANORAMAS`: what the labels themselves can do, by variant; see models/lighting/ceiling.h.
#include <cstdio>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/failure.h"
#include "models/host/mesh/generated.h"
#include "models/host/progress.h"
#include "models/lighting/ceiling.h"

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

void add_ceiling_command(Command& program, int* exit_code) {
  constexpr int k_exit_interrupted = 130;
  const auto options = std::make_shared<CeilingOptions>();
  const auto object = std::make_shared<std::string>("trefoil");
  const auto rows = std::make_shared<size_t>(100);
  Command command = program.add_subcommand("ceiling", "Measure how well true light labels light an object, by variant");
  command->add_option("panoramas", options->panoramas, ".hdr or .exr files, or folders of them")->required();
  command->add_option("--object", *object, "A mesh file or a generated mesh's name")->capture_default_str();
  command->add_option("--views", options->views, "Of each panorama's eight")->check(range(1, 8))->capture_default_str();
  command->add_option("--samples", options->samples, "Paths a pixel")->check(range(1, 4096))->capture_default_str();
  command->add_option("--rows", *rows, "Of the table, best first")->capture_default_str();
  command->add_option("--threads", options->threads, "Threads; the result does not depend on them")
      ->check(range(1u, 256u))
      ->capture_default_str();
  command->callback([options, object, rows, exit_code] {
    listen_for_interrupt();
    MeshResult mesh = make_named(*object);
    if (!mesh) mesh = load_mesh(*object);
    if (!mesh) throw Failure(mesh.error);
    options->object = mesh.mesh;
    const Ceiling ceiling = measure_ceiling(*options);
    *exit_code = interrupted() ? k_exit_interrupted : 0;
    if (*exit_code == 0) print(ceiling, *rows);
  });
}

}  // namespace sandglass::host
