// Descriptions and inputs as an app starts from. The defaults of the sand are calibrated: see the fields' comments.
#include "runtime/frame/filled_struct.h"
#include "sandglass/sandglass.h"

void sandglass_scene_desc_default(sandglass_scene_desc* desc) {
  if (!sandglass::empty_struct(desc)) return;
  desc->unit_items = 1024;
  desc->gravity[1] = -9.81f;
  sandglass_granular_desc& g = desc->granular;
  g.collider_capacity = 16;
  g.particle_radius = 0.01f;
  g.static_friction = 0.16f;
  g.kinetic_friction = 0.16f;
  g.height_weighting = 0.45f;
  g.courant = 0.5f;
  g.list_margin = 0.8f;
  g.sleep_after = 0.5f;
  g.refine_step = 0.008f;
  g.collider_band = 0.003f;
  g.lowest = 20.0f;
  g.reference.scheme = SANDGLASS_SCHEME_SMALL_STEP;
  g.reference.blend = SANDGLASS_BLEND_CONTINUOUS;
  g.reference.solver_iterations = 1;
  g.reference.relaxation = 1.0f;
}

void sandglass_frame_input_default(sandglass_frame_input* input) {
  if (!sandglass::empty_struct(input)) return;
  input->thermal_headroom = 1.0f;
  input->grain_stride = sizeof(sandglass_grain);
}

void sandglass_collider_default(sandglass_collider* collider) {
  if (collider == nullptr) return;
  *collider = {};
  collider->shape = SANDGLASS_SHAPE_HALF_SPACE;
  collider->rotation[3] = 1.0f;
  for (float& size : collider->size) size = 1.0f;
}

void sandglass_emitter_default(sandglass_emitter* emitter) {
  if (emitter == nullptr) return;
  *emitter = {};
  emitter->rotation[3] = 1.0f;
  emitter->radius = 0.03f;
  emitter->speed = 0.5f;
}

void sandglass_body_default(sandglass_body* body) {
  if (!sandglass::empty_struct(body)) return;
  body->density_ratio = 1.0f;
}
