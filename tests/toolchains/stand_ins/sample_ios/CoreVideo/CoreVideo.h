#pragma once
#include "apple_stand_in.h"
