/* The public headers in C99. They compile, `struct_size` is the first field of every struct that has one, enumerations
 * have four bytes, and the structs that types.h calls frozen have no hidden padding. The C++ tests compare the other
 * sizes with these. */
#include "sandglass/light.h"
#include "sandglass/room.h"
#include "sandglass/sandglass.h"
#include "sandglass/shadow.h"

#define CLAIM(name, condition) typedef char claim_##name[(condition) ? 1 : -1]

CLAIM(status, sizeof(sandglass_status) == 4);
CLAIM(isa, sizeof(sandglass_isa) == 4);
CLAIM(shape, sizeof(sandglass_shape) == 4);
CLAIM(stage, sizeof(sandglass_stage) == 4);
CLAIM(scheme, sizeof(sandglass_scheme) == 4);
CLAIM(blend, sizeof(sandglass_blend) == 4);
CLAIM(body_pose, sizeof(sandglass_body_pose) == 4 * (3 + 4 + 3 + 3));
CLAIM(emitter, sizeof(sandglass_emitter) == 4 * (3 + 4 + 1 + 1 + 1));
CLAIM(reference_scheme, sizeof(sandglass_reference_scheme) == 4 * 5);
CLAIM(mesh, sizeof(sandglass_mesh) == 4 * sizeof(void*));
CLAIM(region, sizeof(sandglass_region) == (sizeof(void*) + 7) / 8 * 8 + 16);
CLAIM(clock, sizeof(sandglass_clock) == 2 * sizeof(void*));
CLAIM(parallel, sizeof(sandglass_parallel) == 2 * sizeof(void*));
CLAIM(trace, sizeof(sandglass_trace) == 3 * sizeof(void*));
CLAIM(log, sizeof(sandglass_log) == 2 * sizeof(void*));
CLAIM(grain, sizeof(sandglass_grain) == 4 * 4);
CLAIM(collider, sizeof(sandglass_collider) == 4 + 4 * (3 + 4 + 3 + 3 + 3) + 4 + 2 * sizeof(void*));
CLAIM(plan_run, sizeof(sandglass_plan_run) == 8);
CLAIM(plan, sizeof(sandglass_plan) == 12 + 8 * SANDGLASS_PLAN_RUNS);
CLAIM(stage_report, sizeof(sandglass_stage_report) == 16);
CLAIM(scene_desc_first, offsetof(sandglass_scene_desc, struct_size) == 0);
CLAIM(frame_input_first, offsetof(sandglass_frame_input, struct_size) == 0);
CLAIM(frame_report_first, offsetof(sandglass_frame_report, struct_size) == 0);
CLAIM(shadow_desc_first, offsetof(sandglass_shadow_desc, struct_size) == 0);
CLAIM(shadow_info_first, offsetof(sandglass_shadow_info, struct_size) == 0);
CLAIM(shadow_texture_first, offsetof(sandglass_shadow_texture, struct_size) == 0);
CLAIM(shadow_ambient_first, offsetof(sandglass_shadow_ambient, struct_size) == 0);
CLAIM(camera_image_first, offsetof(sandglass_camera_image, struct_size) == 0);
CLAIM(light_desc_first, offsetof(sandglass_light_desc, struct_size) == 0);
CLAIM(light_info_first, offsetof(sandglass_light_info, struct_size) == 0);
CLAIM(light_estimate_first, offsetof(sandglass_light_estimate, struct_size) == 0);
CLAIM(camera_format, sizeof(sandglass_camera_format) == 4);
CLAIM(light_estimate, sizeof(sandglass_light_estimate) == 8 + 2 * 8 + 4 * (3 + 3 + 1 + 3 + 1 + 1 + 3 + 27));
CLAIM(light_filament_first, offsetof(sandglass_light_filament, struct_size) == 0);
CLAIM(light_arkit_first, offsetof(sandglass_light_arkit, struct_size) == 0);
CLAIM(light_arcore_first, offsetof(sandglass_light_arcore, struct_size) == 0);
CLAIM(light_unity_first, offsetof(sandglass_light_unity, struct_size) == 0);
CLAIM(light_filament, sizeof(sandglass_light_filament) == 4 * (1 + 3 + 3 + 1 + 27 + 1));
CLAIM(light_arkit, sizeof(sandglass_light_arkit) == 4 * (1 + 3 + 1 + 4 + 1 + 1 + 27));
CLAIM(light_arcore, sizeof(sandglass_light_arcore) == 4 * (1 + 3 + 3 + 27));
CLAIM(light_unity, sizeof(sandglass_light_unity) == 4 * (1 + 3 + 4 + 3 + 1 + 27));
CLAIM(hit, sizeof(sandglass_hit) == 4);
CLAIM(ray_hit, sizeof(sandglass_ray_hit) == 4 * (1 + 1 + 1 + 3 + 3));
CLAIM(plan_first, offsetof(sandglass_plan, struct_size) == 0);

const uint32_t c99_struct_sizes[] = {sizeof(sandglass_scene_desc), sizeof(sandglass_frame_input),
                                     sizeof(sandglass_frame_report), sizeof(sandglass_granular_desc)};
