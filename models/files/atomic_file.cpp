// A file is written under a temporary name, closed, checked and renamed. A program that is killed leaves at most a
// "*.unfinished.*" file behind. A program that Ctrl-C ends removes it.
#include "models/files/atomic_file.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "models/files/failure.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

// Names of the files that are being written. A signal handler reads them, so there is no lock and no heap. A file
// without a free place here is written all the same, but Ctrl-C does not remove it.
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
  throw cannot("write", path, error.message(), "Check the folder's permissions");
}

// Only asks the file system and writes nothing. A full or failing disk is noticed later, on writing.
void require_writable(const std::string& path) {
  if (path.empty()) throw cannot("write", path, "the file has no name", "Name it");
  std::error_code error;
  const fs::file_status target = fs::status(path, error);
  if (fs::is_directory(target)) throw cannot("write", path, "it is a folder", "Name a file in it");
  if (fs::exists(target) && !fs::is_regular_file(target))
    throw cannot("write", path, "it is no ordinary file", "Name another");
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const bool has_name = fs::path(path).has_filename();
  const fs::file_status unfinished =
      fs::symlink_status(unfinished_name(path), error);  // this name is the longer one, so test it
  if (!has_name || unfinished.type() == fs::file_type::none || !fs::is_directory(folder, error) ||
      access(folder.c_str(), W_OK | X_OK) != 0)
    throw cannot("write", path, "its folder is missing, full or may not be written to", "Check the folder");
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
    throw cannot("write", path, "its folder is missing, full or may not be written to", "Check the folder");
  }
  finish_file(path);
}

void write_file(const std::string& path, std::span<const uint8_t> content) {
  write_file(path, std::string_view(reinterpret_cast<const char*>(content.data()), content.size()));
}

std::string read_file(const std::string& path, const std::string& kind) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw cannot("read " + kind, path, "it is a folder", "Name a file");
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) throw cannot("read " + kind, path, "it does not exist or may not be read", "Check the path");
  std::string content;
  char buffer[65536];
  for (size_t got; (got = std::fread(buffer, 1, sizeof buffer, file)) > 0;) content.append(buffer, got);
  const bool good = std::ferror(file) == 0;
  std::fclose(file);
  if (!good) throw cannot("read " + kind, path, "the disk stops within it", "Check the disk");
  return content;
}

void keep_inputs(const std::string& output, const std::vector<std::string>& inputs) {
  std::error_code error;  // set for a path that does not exist; then the files differ
  for (const std::string& input : inputs)
    if (fs::equivalent(fs::weakly_canonical(output, error), input, error))
      throw cannot("write", output, "the same command reads it", "Write somewhere else with -o");
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path, error))
    throw cannot("make folder", path, "its parent may not be written to, or a file has that name", "Name another");
}

}  // namespace sandglass::host
