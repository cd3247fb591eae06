// The back ends of this build: the project's own kernels and, with SANDGLASS_HAVE_XNNPACK, XNNPACK's convolutions.
#include "runtime/light/network/backends.h"

#include "runtime/frame/refuse.h"

namespace sandglass {

bool find_light_backend(sandglass_estimator_backend choice, const LightBackend** backend, const char** reason) {
  *backend = nullptr;
  switch (choice) {
    case SANDGLASS_ESTIMATOR_BACKEND_OWN:
      return true;
    case SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32:
    case SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8:
#ifdef SANDGLASS_HAVE_XNNPACK
      *backend = choice == SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32 ? &k_light_xnnpack_f32 : &k_light_xnnpack_int8;
      return true;
#else
      (void)refuse(reason,
                   "desc.backend is XNNPACK, which this build leaves out: configure it with SANDGLASS_XNNPACK=ON.");
      return false;
#endif
    default:
      (void)refuse(reason,
                   "desc.backend is not one of sandglass_estimator_backend: take SANDGLASS_ESTIMATOR_BACKEND_OWN.");
      return false;
  }
}

}  // namespace sandglass
