// The public headers in the oldest C++ that they promise, without exceptions and RTTI.
#include "sandglass/field.h"
#include "sandglass/light.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/room.h"
#include "sandglass/sandglass.hpp"
#include "sandglass/shadow.h"

static_assert(__cplusplus == 201703L, "this file is meant for C++17");
