// Writes files whole or not at all: content goes to a temporary name beside the target and is renamed when complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sandglass::host {

// Throws a Failure when write_file could not write there, as far as one can tell without changing anything. Call it
// before long work whose result goes to `path`.
void require_writable(const std::string& path);

void write_file(const std::string& path, std::string_view content);
void write_file(const std::string& path, std::span<const uint8_t> content);

// The name under which another program (ffmpeg) writes, with the same extension. finish_file then renames the result to
// `path`.
std::string unfinished_name(const std::string& path);
void finish_file(const std::string& path);

// Reads the whole file. Throws a Failure that names it. `kind` is what the file should be, for example "scene".
std::string read_file(const std::string& path, const std::string& kind);

// Throws a Failure when writing `output` would destroy one of the files that a command reads.
void keep_inputs(const std::string& output, const std::vector<std::string>& inputs);

// Removes the files that write_file has not finished. A signal handler that is about to end the program may call it.
void remove_unfinished();

// Makes a folder and its parents, or throws a Failure.
void make_folder(const std::string& path);

}  // namespace sandglass::host
