// The inside test of the public API: one of two prepared forms. Its handle stands at the head of the app's block.
#include "runtime/solid/sampling/inside.h"

#include "runtime/solid/sampling/arguments.h"

struct sandglass_mesh_inside {
  sandglass_inside_rule rule;
  sandglass::Parity parity;
  sandglass::Winding winding;
};

namespace sandglass {
namespace {

sandglass_status measure(const sandglass_mesh* mesh, sandglass_inside_rule rule, sandglass_mesh_inside* plan,
                         const char** reason) {
  float bounds_min[3], bounds_max[3];
  if (const sandglass_status status = sandglass_mesh_bounds(mesh, bounds_min, bounds_max, reason)) return status;
  *plan = {};
  plan->rule = rule;
  if (rule == SANDGLASS_INSIDE_PARITY) {
    plan->parity = measure_parity(*mesh, bounds_min, bounds_max);
  } else if (rule == SANDGLASS_INSIDE_WINDING) {
    plan->winding = measure_winding(*mesh);
  } else {
    return refuse(reason, "rule is none of sandglass_inside_rule: use PARITY or WINDING.");
  }
  return accept(reason);
}

sandglass_mesh_inside* lay_out(Layout* layout, const sandglass_mesh& mesh, sandglass_mesh_inside* plan) {
  auto* inside = layout_region<sandglass_mesh_inside>(layout, "sampling.inside", 1);
  if (plan->rule == SANDGLASS_INSIDE_PARITY) lay_out_parity(layout, mesh, &plan->parity);
  else lay_out_winding(layout, &plan->winding);
  return inside;
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

extern "C" {

sandglass_status sandglass_mesh_inside_bytes(const sandglass_mesh* mesh, sandglass_inside_rule rule, uint64_t* bytes,
                                             const char** reason) {
  sandglass_mesh_inside plan;
  if (const sandglass_status status = measure(mesh, rule, &plan, reason)) return status;
  if (bytes == nullptr) return refuse(reason, "bytes is NULL: pass room for a number.");
  Layout layout;
  lay_out(&layout, *mesh, &plan);
  *bytes = layout.size;
  return accept(reason);
}

sandglass_status sandglass_mesh_inside_create(const sandglass_mesh* mesh, sandglass_inside_rule rule, void* block,
                                              uint64_t bytes, sandglass_mesh_inside** inside, const char** reason) {
  sandglass_mesh_inside plan;
  if (inside == nullptr) return refuse(reason, "inside is NULL: pass room for a pointer.");
  if (const sandglass_status status = measure(mesh, rule, &plan, reason)) return status;
  Layout size;
  lay_out(&size, *mesh, &plan);
  if (const sandglass_status status = check_block(block, bytes, size.size, reason)) return status;
  Layout layout;
  layout.base = static_cast<uint8_t*>(block);
  sandglass_mesh_inside* made = lay_out(&layout, *mesh, &plan);
  float bounds_min[3], bounds_max[3];
  if (const sandglass_status status = sandglass_mesh_bounds(mesh, bounds_min, bounds_max, reason)) return status;
  if (rule == SANDGLASS_INSIDE_PARITY) build_parity(*mesh, &plan.parity);
  else build_winding(*mesh, bounds_min, bounds_max, &plan.winding);
  *made = plan;
  *inside = made;
  return accept(reason);
}

int32_t sandglass_mesh_inside_test(void* user, const float point[3]) {
  const auto* inside = static_cast<const sandglass_mesh_inside*>(user);
  if (inside == nullptr || point == nullptr) return 0;
  for (int k = 0; k < 3; ++k)
    if (!is_finite(point[k])) return 0;
  if (inside->rule == SANDGLASS_INSIDE_PARITY) return parity_inside(inside->parity, point) ? 1 : 0;
  const double number = winding_number(inside->winding, point);
  return number >= 0.5 || number <= -0.5 ? 1 : 0;
}

}  // extern "C"
