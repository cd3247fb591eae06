// The output: every grain is written to the app's buffer, at the end of each frame, whatever the budget.
#pragma once

#include "runtime/core/governor.h"
#include "sandglass/sandglass.h"

namespace sandglass {

struct Granular;

struct Output {
  const sandglass_frame_input* input;  // of this frame
  uint32_t cursor;                     // next grain, then next free number
};

void output_begin_frame(Output* output, const sandglass_frame_input* input);
// What was written is out of date.
void output_restart(Output* output);

Stage granular_output_stage(Granular* granular);

}  // namespace sandglass
