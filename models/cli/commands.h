// The sub-commands of the program. Each adds its options (options.h) and, when chosen, runs and sets *exit_code: 0
// done, 1 a check failed, 2 bad input (also through a Failure), 130 interrupted.
#pragma once

namespace sandglass::host {

class Command;

void add_run_command(Command& program, int* exit_code);
void add_view_command(Command& program, int* exit_code);
void add_bake_command(Command& program, int* exit_code);  // in builds with Embree
void add_bench_command(Command& program, int* exit_code);
void add_verify_command(Command& program, int* exit_code);
void add_inspect_command(Command& program, int* exit_code);
void add_room_command(Command& program, int* exit_code);
void add_dataset_command(Command& program, int* exit_code);
void add_ceiling_command(Command& program, int* exit_code);
void add_light_command(Command& program, int* exit_code);
void add_quantise_light_command(Command& program, int* exit_code);
void add_light_features_command(Command& program, int* exit_code);

}  // namespace sandglass::host
