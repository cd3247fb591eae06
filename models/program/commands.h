// The commands of the program. Each function adds one with its options; what the command returns is the exit code.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"

namespace sandglass::host {

class Command;
struct Option;

// Bad input, a Failure, is the program's exit code 2.
constexpr int k_exit_done = 0, k_exit_check_failed = 1, k_exit_bad_input = 2, k_exit_interrupted = 130;

void add_run_command(Command& program, const std::string& group);
void add_view_command(Command& program, const std::string& group);
void add_inspect_command(Command& program, const std::string& group);
void add_light_command(Command& program, const std::string& group);
void add_bake_command(Command& program, const std::string& group);
void add_sample_command(Command& program, const std::string& group);
void add_room_command(Command& program, const std::string& group);
void add_dataset_command(Command& program, const std::string& group);
void add_light_features_command(Command& program, const std::string& group);
void add_quantise_light_command(Command& program, const std::string& group);
void add_ceiling_command(Command& program, const std::string& group);
void add_bench_command(Command& program, const std::string& group);
void add_verify_command(Command& program, const std::string& group);

// Options that several commands have, in the same words.
Option& add_threads(Command& command, uint32_t& threads);
Option& add_thread_counts(Command& command, std::vector<uint32_t>& threads);
Option& add_isa(Command& command, std::string& isa);
Option& add_json(Command& command, std::string& file);

// The mesh that a command line names: a generated one (models/mesh/generated.h), or a file.
MeshResult named_mesh(const std::string& name_or_file);

}  // namespace sandglass::host
