// Faults that the symbol test must find, one in each build.
#include <cmath>
#include <cstdlib>

#if defined(CONTROL_ALLOCATION)
int* fault(std::size_t n) { return new int[n]; }
#elif defined(CONTROL_CONSTRUCTOR)
struct Counter {
  Counter();
  int value;
};
Counter::Counter() : value(std::rand()) {}
Counter fault;
#elif defined(CONTROL_THREAD_LOCAL)
thread_local int fault;
int* address() { return &fault; }
#elif defined(CONTROL_TRANSCENDENTAL)
float fault(float x) { return std::sin(x); }
#endif
