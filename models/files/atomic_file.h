// Writes files whole or not at all: content goes to a temporary name beside the target and is renamed when complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sandglass::host {

// Throws a Failure when write_file could not write there, as far as one can tell without changing anything. Call it
// before long work whose result goes to `path`.
void require_writable(const std::string& path);

// Throws a Failure where the disk is as good as full: less than a MiB is left. Only long work needs to ask.
void require_space(const std::string& path);

// A symbolic link stays, and the file that it names is written.
void write_file(const std::string& path, std::string_view content);
void write_file(const std::string& path, std::span<const uint8_t> content);

// Lives while a file or a folder has that name: then a Ctrl-C that ends the program removes it.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::string& name);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 private:
  size_t place_;
};

// The largest files that are read, in bytes. A larger one is refused before its first byte is read. A text that a
// person writes, such as a scene, is far smaller than a mesh or a panorama.
constexpr uint64_t k_text_limit = uint64_t{16} << 20, k_asset_limit = uint64_t{256} << 20,
                   k_file_limit = uint64_t{1} << 30;

// What a checkout without Git LFS holds instead of a large file begins so; read_file refuses it.
constexpr std::string_view k_lfs_pointer = "version https://git-lfs.github.com/spec/";

// Reads the whole file. Throws a Failure that names it. `kind` is what the file should be, for example "scene". Only
// ordinary files of at most `limit` bytes are read: no pipe, device or folder.
std::string read_file(const std::string& path, const std::string& kind, uint64_t limit = k_file_limit);

// Removes the files that write_file has not finished. A signal handler that is about to end the program may call it.
void remove_unfinished();

// Makes a folder and its parents, or throws a Failure.
void make_folder(const std::string& path);

}  // namespace sandglass::host
