// The calls that all methods of sampling share.
#include "runtime/frame/filled_struct.h"
#include "runtime/solid/sampling/arguments.h"
#include "runtime/solid/sampling/methods.h"

namespace sandglass {
namespace {

sandglass_status ask(const sandglass_sample_desc* desc, SampleCall* call, const char** reason) {
  if (desc == nullptr || desc->struct_size != sizeof *desc)
    return refuse(reason, "desc is NULL or its struct_size is wrong: start from sandglass_sample_desc_default.");
  if (!is_finite(desc->distance) || !(desc->distance > 0))
    return refuse(reason, "desc.distance is not a finite number above 0: give it in metres.");
  if (desc->tries < 1 || desc->tries > 1000) return refuse(reason, "desc.tries is not in 1..1000: 30 is a good value.");
  if (desc->metric != SANDGLASS_METRIC_EUCLIDEAN && desc->metric != SANDGLASS_METRIC_GEODESIC)
    return refuse(reason, "desc.metric is none of sandglass_metric: use EUCLIDEAN or GEODESIC.");
  switch (desc->method) {
    case SANDGLASS_SAMPLE_SURFACE:
      return sample_on_surface(*desc, call, reason);
    case SANDGLASS_SAMPLE_VOLUME:
      return sample_in_volume(*desc, call, reason);
    case SANDGLASS_SAMPLE_LATTICE:
      return sample_on_lattice(*desc, call, reason);
    default:
      return refuse(reason, "desc.method is none of sandglass_sample_method: use SURFACE, VOLUME or LATTICE.");
  }
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

extern "C" {

void sandglass_sample_desc_default(sandglass_sample_desc* desc) {
  if (!empty_struct(desc)) return;
  desc->tries = 30;
  desc->seed = 1;
}

sandglass_status sandglass_sample_capacity(const sandglass_sample_desc* desc, uint32_t* capacity, const char** reason) {
  SampleCall call = {};
  if (const sandglass_status status = ask(desc, &call, reason)) return status;
  if (capacity == nullptr) return refuse(reason, "capacity is NULL: pass room for a number.");
  *capacity = call.enough;
  return accept(reason);
}

sandglass_status sandglass_sample_bytes(const sandglass_sample_desc* desc, uint32_t capacity, uint64_t* bytes,
                                        const char** reason) {
  SampleCall call = {};
  call.capacity = capacity;
  if (const sandglass_status status = ask(desc, &call, reason)) return status;
  if (bytes == nullptr) return refuse(reason, "bytes is NULL: pass room for a number.");
  *bytes = call.bytes;
  return accept(reason);
}

sandglass_status sandglass_sample_points(const sandglass_sample_desc* desc, void* scratch, uint64_t scratch_bytes,
                                         float* points, uint32_t capacity, uint32_t* count, const char** reason) {
  if (count == nullptr) return refuse(reason, "count is NULL: pass room for a number.");
  *count = 0;
  if (points == nullptr) return refuse(reason, "points is NULL: pass room for 3 * capacity floats.");
  SampleCall call = {capacity, scratch, scratch_bytes, points, 0, 0, 0};
  const sandglass_status status = ask(desc, &call, reason);
  *count = call.count;
  return status;
}

}  // extern "C"
