// 64-bit ARM under iOS and macOS: the system has a named value for each feature. A name that it does not know means
// "no".
#if defined(__aarch64__) && defined(__APPLE__)

#include "platform/cpu_features.h"

#include <sys/types.h>

#include <sys/sysctl.h>

namespace sandglass {
namespace {

bool has_feature(const char* name) {
  int value = 0;
  size_t bytes = sizeof(value);
  return sysctlbyname(name, &value, &bytes, nullptr, 0) == 0 && bytes == sizeof(value) && value != 0;
}

}  // namespace

CpuFeatures cpu_features() {
  CpuFeatures features;
  features.neon = true;  // part of every 64-bit Apple processor
  features.dotprod = has_feature("hw.optional.arm.FEAT_DotProd");
  features.i8mm = has_feature("hw.optional.arm.FEAT_I8MM");
  return features;
}

}  // namespace sandglass

#endif
