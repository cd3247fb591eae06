// The files that one command reads and writes. A command never writes over a file that it reads, and never writes two
// outputs to one name; symbolic and hard links are seen through. A folder that gets several outputs holds the file
// "incomplete.txt" until all of them are there, and belongs to one process at a time.
//
// The checks are on after watch_files(), which the program calls once. Tests and tools that write one file many times
// leave it out.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

void watch_files();

// Announces an output, before long work whose result goes there. Throws a Failure when it cannot be written, when
// another announced output has that name, or when the command has read it. `again_and_again`: it is written many times,
// such as a checkpoint. A command reads its own output by read_output (atomic_file.h).
void claim_output(const std::string& path, bool again_and_again = false);
// The same for a folder that lies in one of begin_folder, and for all files in it: their names are not known yet.
void claim_folder(const std::string& path);

// For files/atomic_file.cpp. A file that is read: throws a Failure when it is announced as an output.
void note_input(const std::string& path);
// A file that is about to be written: throws a Failure when the command has read it or written it already.
void note_output(const std::string& path);

constexpr const char* k_incomplete = "incomplete.txt";

// Makes a folder for several outputs, announces those, and marks it incomplete, before long work. Throws a Failure when
// another process is writing there.
void begin_folder(const std::string& path, const std::vector<std::string>& names);
// Removes an output of an earlier run, or one that is not needed any longer. Returns false where there is none. Throws
// a Failure when the command has read it.
bool remove_output(const std::string& path);
// Removes those of the named files of a folder that this command did not write: they are of an earlier run.
void remove_unwritten(const std::string& folder, const std::vector<std::string>& names);
// Takes the marks away, or throws a Failure where one stays.
void finish_folders();
// The other end, after Ctrl-C or a Failure: a folder into which nothing was written becomes what it was before
// begin_folder. Others stay marked. Returns what to say of the outputs, for example "nothing was written".
std::string leave_folders();
// Throws a Failure for a folder that is marked incomplete.
void require_complete(const std::string& folder);

}  // namespace sandglass::host
