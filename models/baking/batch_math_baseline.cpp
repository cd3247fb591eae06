// batch_math.inl for baseline.
#define SANDGLASS_BATCH_SET batch_baseline
#define SANDGLASS_BATCH_EIGEN Eigen_baseline
#include "models/baking/batch_math.inl"
