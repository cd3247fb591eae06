#pragma once
#include <filament/stand_in.h>
