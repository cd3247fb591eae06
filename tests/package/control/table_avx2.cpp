// A fault that the symbol test must find: an object of one instruction set that also defines a function whose name
// another object may share. Not part of the library.
inline float shared_with_the_rest(float x) { return x * x; }

namespace avx2 {
extern float (*const k_square)(float);
float (*const k_square)(float) = shared_with_the_rest;
}  // namespace avx2
