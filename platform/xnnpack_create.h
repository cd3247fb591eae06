// One call for all versions of XNNPACK. They differ in how many pointers to caches stand before the operator that is
// created; no cache is used.
#pragma once

#include <xnnpack.h>

#include <cstddef>

namespace sandglass {

template <class... Parameters, class... Arguments>
xnn_status xnnpack_create_operator(xnn_status (*function)(Parameters...), xnn_operator_t* result,
                                   Arguments... arguments) {
  constexpr size_t k_caches = sizeof...(Parameters) - sizeof...(Arguments) - 1;
  static_assert(k_caches <= 2);
  if constexpr (k_caches == 0) return function(arguments..., result);
  else if constexpr (k_caches == 1) return function(arguments..., nullptr, result);
  else return function(arguments..., nullptr, nullptr, result);
}

}  // namespace sandglass
