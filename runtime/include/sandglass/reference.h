/* Sandglass reference: the schemes that results are compared with. An app never needs this header: it leaves
 * sandglass_granular_desc.reference as the defaults fill it. */
#ifndef SANDGLASS_REFERENCE_H
#define SANDGLASS_REFERENCE_H

#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How the contacts of one sub-step are resolved.
 *
 * SMALL_STEP (the default): pair by pair. A pair corrects both its particles at once, and the next pair sees that
 * (Gauss-Seidel). What one particle gains the other loses, so momentum is conserved. It takes many small steps, and
 * then only one iteration.
 *
 * AVERAGED: all pairs see the same positions (Jacobi). The sum of a particle's corrections is divided by the number of
 * constraints that acted on it (4.37). `relaxation` multiplies that mean; the product is never above 1 per
 * constraint. */
typedef int32_t sandglass_scheme;
enum { SANDGLASS_SCHEME_SMALL_STEP = 0, SANDGLASS_SCHEME_AVERAGED = 1 };

/* How grains blend between the flow and free flight (4.43), by the factor lambda.
 *
 * CONTINUOUS (the default): lambda falls smoothly to 0 inside the material. Grains follow once a frame, by the
 * particles' displacements, and keep an even density. Among particles that fall freely they fall on their own.
 *
 * SOURCE: (4.44) as printed, once every refine_step. Lambda jumps from 0.298 to 0, and grains pop; they gather around
 * the particles. It costs several times as much.
 *
 * MEANS: CONTINUOUS, but a grain in free flight knows no particle of its own. It does not turn where its particle hits
 * something, and sand is drawn where none is. */
typedef int32_t sandglass_blend;
enum { SANDGLASS_BLEND_CONTINUOUS = 0, SANDGLASS_BLEND_SOURCE = 1, SANDGLASS_BLEND_MEANS = 2 };

/* How one sub-step is solved. An app leaves this struct as sandglass_scene_desc_default filled it: every measured
 * number and the quality ladder hold for these defaults. Its other values are the solver of the dissertation as printed
 * (Alg. 4), and are here so that the library can be compared with it. */
typedef struct sandglass_reference_scheme {
  /* Default: SANDGLASS_SCHEME_SMALL_STEP. */
  sandglass_scheme scheme;
  /* Default: SANDGLASS_BLEND_CONTINUOUS. */
  sandglass_blend blend;
  /* Iterations a sub-step, 1..64. Default: 1. */
  uint32_t solver_iterations;
  /* Iterations that move overlapping particles apart before the solver runs, 0..8 (Alg. 4, lines 6 to 12). Default:
   * 0. */
  uint32_t stabilisation_iterations;
  /* SMALL_STEP: the share of a pair's correction that is made, above 0, at most 1. AVERAGED: above 0, at most 2.
   * Default: 1. */
  float relaxation;
} sandglass_reference_scheme;

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_REFERENCE_H */
