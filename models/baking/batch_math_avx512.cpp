// batch_math.inl for avx512.
#define SANDGLASS_BATCH_SET batch_avx512
#define SANDGLASS_BATCH_EIGEN Eigen_avx512
#include "models/baking/batch_math.inl"
