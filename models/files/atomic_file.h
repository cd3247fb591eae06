// No half-written file, ever: content goes to a temporary name beside the target and is renamed when complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sandglass::host {

// Whether write_file could write there, as far as can be told without making or changing anything; else a Failure.
// Called before long work whose result goes to `path`.
void require_writable(const std::string& path);

void write_file(const std::string& path, std::string_view content);
void write_file(const std::string& path, std::span<const uint8_t> content);

// The name under which a program that is not ours (ffmpeg) writes before finish_file renames the result; the extension
// is kept.
std::string unfinished_name(const std::string& path);
void finish_file(const std::string& path);

// The whole file, or a Failure that names it. `kind` is what the file should be: "scene", "recording".
std::string read_file(const std::string& path, const std::string& kind);

// A Failure where writing `output` would destroy one of the files that a command reads.
void keep_inputs(const std::string& output, const std::vector<std::string>& inputs);

// Removes what write_file has not finished: for a signal's handler that is about to end the program, and may call it.
void remove_unfinished();

// Makes a folder and its parents, or a Failure.
void make_folder(const std::string& path);

}  // namespace sandglass::host
