// It includes what stands on it.
#include "runtime/frame/governor.h"
