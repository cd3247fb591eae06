// Particles, grains and points as the floats that load_records and store_records take.

SANDGLASS_INLINE const float* floats_of(const void* records) { return static_cast<const float*>(records); }
SANDGLASS_INLINE float* floats_of(void* records) { return static_cast<float*>(records); }
