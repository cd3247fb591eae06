// The public headers in the oldest C++ that they promise, without exceptions and RTTI, with the layout that C has.
#include "sandglass/camera.h"
#include "sandglass/cast.h"
#include "sandglass/estimator.h"
#include "sandglass/field.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/renderers.h"
#include "sandglass/room.h"
#include "sandglass/sandglass.hpp"
#include "sandglass/shadow.h"
#include "sandglass/skin.h"
// Claims for every size and offset, which C99 fulfils too.
#include "layout.c"

static_assert(__cplusplus == 201703L, "this file is meant for C++17");
