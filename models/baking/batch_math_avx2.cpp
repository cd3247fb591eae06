// batch_math.inl for avx2.
#define SANDGLASS_BATCH_SET batch_avx2
#define SANDGLASS_BATCH_EIGEN Eigen_avx2
#include "models/baking/batch_math.inl"
