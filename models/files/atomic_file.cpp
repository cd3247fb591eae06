// Temporary name, flush, check, rename. A program that is killed leaves at most a "*.unfinished.*" file behind; one
// that is ended by Ctrl-C removes it.
#include "models/files/atomic_file.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "models/work/failure.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

// Names of files that are being written, as a signal's handler can read them: no lock, no heap. A file that finds no
// place here is written all the same.
struct Writing {
  std::atomic<bool> taken, named;
  char name[4096];
};
constexpr size_t k_writers = 32;
Writing writing[k_writers];

class Noted {
 public:
  explicit Noted(const std::string& name) {
    if (name.size() >= sizeof Writing::name) return;
    for (size_t i = 0; i < k_writers && place_ == nullptr; ++i)
      if (!writing[i].taken.exchange(true)) place_ = &writing[i];
    if (place_ == nullptr) return;
    std::memcpy(place_->name, name.c_str(), name.size() + 1);
    place_->named = true;
  }
  ~Noted() {
    if (place_ != nullptr) place_->named = false, place_->taken = false;
  }
  Noted(const Noted&) = delete;
  Noted& operator=(const Noted&) = delete;

 private:
  Writing* place_ = nullptr;
};

}  // namespace

void remove_unfinished() {
  for (const Writing& file : writing)
    if (file.named) unlink(file.name);
}

std::string unfinished_name(const std::string& path) {
  const fs::path target(path);
  return (target.parent_path() /
          (target.stem().string() + ".unfinished." + std::to_string(getpid()) + target.extension().string()))
      .string();
}

void finish_file(const std::string& path) {
  std::error_code error, of_removal;
  fs::rename(unfinished_name(path), path, error);
  if (!error) return;
  fs::remove(unfinished_name(path), of_removal);
  throw Failure("cannot finish the file '" + path + "': " + error.message() + "; check the folder's permissions");
}

// Looks only: what a file system says without being written to. Space, and a disk that fails, show when it is.
void require_writable(const std::string& path) {
  if (path.empty()) throw Failure("cannot write a file without a name; name one");
  std::error_code error;
  const fs::file_status target = fs::status(path, error);
  if (fs::is_directory(target)) throw Failure("cannot write '" + path + "', which is a folder; name a file in it");
  if (fs::exists(target) && !fs::is_regular_file(target))
    throw Failure("cannot write '" + path + "', which is no ordinary file; name one");
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const bool has_name = fs::path(path).has_filename();
  const fs::file_status unfinished = fs::symlink_status(unfinished_name(path), error);  // its name is the longer one
  if (!has_name || unfinished.type() == fs::file_type::none || !fs::is_directory(folder, error) ||
      access(folder.c_str(), W_OK | X_OK) != 0)
    throw Failure("cannot write '" + path + "'; check that the folder exists, may be written to and has space left");
}

void write_file(const std::string& path, std::string_view content) {
  require_writable(path);
  const std::string unfinished = unfinished_name(path);
  const Noted noted(unfinished);
  std::FILE* file = std::fopen(unfinished.c_str(), "wb");
  bool good = file != nullptr;
  if (good) {
    good = std::fwrite(content.data(), 1, content.size(), file) == content.size();
    good = std::fclose(file) == 0 && good;
  }
  if (!good) {
    std::remove(unfinished.c_str());
    throw Failure("cannot write '" + path + "'; check that the folder exists, may be written to and has space left");
  }
  finish_file(path);
}

void write_file(const std::string& path, std::span<const uint8_t> content) {
  write_file(path, std::string_view(reinterpret_cast<const char*>(content.data()), content.size()));
}

std::string read_file(const std::string& path, const std::string& kind) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw Failure("the " + kind + " '" + path + "' is a folder; name a file");
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) throw Failure("cannot open the " + kind + " '" + path + "'; check the path");
  std::string content;
  char buffer[65536];
  for (size_t got; (got = std::fread(buffer, 1, sizeof buffer, file)) > 0;) content.append(buffer, got);
  const bool good = std::ferror(file) == 0;
  std::fclose(file);
  if (!good) throw Failure("reading the " + kind + " '" + path + "' failed part of the way; check the disk");
  return content;
}

void keep_inputs(const std::string& output, const std::vector<std::string>& inputs) {
  std::error_code error;  // of a path that is nowhere: then they are not the same
  for (const std::string& input : inputs)
    if (fs::equivalent(fs::weakly_canonical(output, error), input, error))
      throw Failure("'" + output + "' would be written over, and it is read; write somewhere else with -o");
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path, error))
    throw Failure("cannot make the folder '" + path +
                  "'; check that its parent may be written to and no file has that name");
}

}  // namespace sandglass::host
