// The sub-commands of the program. Each adds its options to CLI11 and, when chosen, runs and sets *exit_code: 0 done, 1
// a check failed, 2 bad input (also through a Failure), 130 interrupted.
#pragma once

namespace CLI {
class App;
}

namespace sandglass::host {

void add_run_command(CLI::App& program, int* exit_code);
void add_view_command(CLI::App& program, int* exit_code);
void add_bake_command(CLI::App& program, int* exit_code);  // in builds with Embree
void add_bench_command(CLI::App& program, int* exit_code);
void add_verify_command(CLI::App& program, int* exit_code);
void add_inspect_command(CLI::App& program, int* exit_code);
void add_room_command(CLI::App& program, int* exit_code);
void add_dataset_command(CLI::App& program, int* exit_code);
void add_ceiling_command(CLI::App& program, int* exit_code);
void add_light_command(CLI::App& program, int* exit_code);
void add_quantise_light_command(CLI::App& program, int* exit_code);
void add_light_features_command(CLI::App& program, int* exit_code);

}  // namespace sandglass::host
