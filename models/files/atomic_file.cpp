// A file is written under a temporary name, closed, checked and renamed. A program that is killed leaves at most a
// "*.unfinished.*" file behind. A program that Ctrl-C ends removes it.
#include "models/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
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

}  // namespace

UnfinishedFile::UnfinishedFile(const std::string& name) : place_(k_writers) {
  if (name.size() >= sizeof Writing::name) return;
  for (size_t i = 0; i < k_writers && place_ == k_writers; ++i)
    if (!writing[i].taken.exchange(true)) place_ = i;
  if (place_ == k_writers) return;
  std::memcpy(writing[place_].name, name.c_str(), name.size() + 1);
  writing[place_].named = true;
}
UnfinishedFile::~UnfinishedFile() {
  if (place_ < k_writers) {
    writing[place_].named = false;
    writing[place_].taken = false;
  }
}

void remove_unfinished() {
  for (const Writing& file : writing) {
    if (!file.named || unlink(file.name) == 0 || (errno != EISDIR && errno != EPERM)) continue;
    const pid_t child = fork();  // it is a folder
    if (child == 0) {
      execlp("rm", "rm", "-rf", "--", file.name, nullptr);
      _exit(1);
    }
    if (child > 0) waitpid(child, nullptr, 0);
  }
}

namespace {

constexpr const char *k_unwritable = "its folder is missing, full or may not be written to",
                     *k_check = "Check the folder";

// The file behind symbolic links. A link that leads nowhere is replaced.
fs::path behind_links(const std::string& path) {
  std::error_code error;
  const fs::path target = fs::canonical(path, error);
  return error ? fs::path(path) : target;
}

std::string unfinished_name(const std::string& path) {
  return behind_links(path).string() + ".unfinished." + std::to_string(getpid());
}

}  // namespace

// Only asks the file system and writes nothing. A full or failing disk is noticed later, on writing.
void require_writable(const std::string& path) {
  if (path.empty()) throw cannot("write", path, "the file has no name", "Name it");
  std::error_code error;
  const fs::file_status target = fs::status(path, error);
  if (fs::is_directory(target)) throw cannot("write", path, "it is a folder", "Name a file in it");
  if (fs::exists(target) && !fs::is_regular_file(target))
    throw cannot("write", path, "it is no ordinary file", "Name another");
  constexpr fs::perms k_any_writer = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  if (fs::exists(target) && (target.permissions() & k_any_writer) == fs::perms::none)
    throw cannot("write", path, "it is write-protected", "Name another, or allow to write it");
  const fs::path parent = behind_links(path).parent_path(), folder = parent.empty() ? fs::path(".") : parent;
  const bool has_name = fs::path(path).has_filename();
  const fs::file_status unfinished =
      fs::symlink_status(unfinished_name(path), error);  // this name is the longer one, so test it
  if (!has_name || unfinished.type() == fs::file_type::none || !fs::is_directory(folder, error) ||
      access(folder.c_str(), W_OK | X_OK) != 0)
    throw cannot("write", path, k_unwritable, k_check);
}

void require_space(const std::string& path) {
  constexpr uintmax_t k_free_min = 1 << 20;
  std::error_code error;
  fs::path folder = fs::absolute(behind_links(path), error).parent_path();
  while (!fs::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  const fs::space_info disk = fs::space(folder, error);
  if (!error && disk.available < k_free_min)
    throw cannot("write", path, "the disk has less than 1 MiB left", "Make room, or name another");
}

void write_file(const std::string& path, std::string_view content) {
  require_writable(path);
  const std::string unfinished = unfinished_name(path);
  const UnfinishedFile listed(unfinished);
  std::FILE* file = std::fopen(unfinished.c_str(), "wb");
  bool good = file != nullptr;
  if (good) {
    good = std::fwrite(content.data(), 1, content.size(), file) == content.size();
    good = std::fclose(file) == 0 && good;
  }
  std::error_code error;
  if (good) fs::rename(unfinished, behind_links(path), error);
  if (good && !error) return;
  std::remove(unfinished.c_str());
  throw cannot("write", path, k_unwritable, k_check);
}

void write_file(const std::string& path, std::span<const uint8_t> content) {
  write_file(path, std::string_view(reinterpret_cast<const char*>(content.data()), content.size()));
}

std::string read_file(const std::string& path, const std::string& kind, uint64_t limit) {
  const auto fail = [&](const std::string& why, const char* remedy) {
    return cannot("read " + kind, path, why, remedy);
  };
  // Opening a pipe would wait for its writer.
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw fail("it does not exist or may not be read", "Check the path");
  const std::unique_ptr<const int, void (*)(const int*)> closed(&file, [](const int* f) { close(*f); });
  struct stat status = {};
  if (fstat(file, &status) != 0) throw fail("the disk does not answer", "Check the disk");
  if (S_ISDIR(status.st_mode)) throw fail("it is a folder", "Name a file");
  if (!S_ISREG(status.st_mode)) throw fail("it is no ordinary file", "Name a file");
  const auto too_large = [&] {
    return fail("it has more than " + std::to_string(limit >> 20) + " MiB", "Name a smaller file");
  };
  if (static_cast<uint64_t>(status.st_size) > limit) throw too_large();
  std::string content;
  content.reserve(static_cast<size_t>(status.st_size));
  char buffer[65536];
  for (ssize_t got; (got = read(file, buffer, sizeof buffer)) != 0;) {
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw fail("the disk stops within it", "Check the disk");
    content.append(buffer, static_cast<size_t>(got));
    if (content.size() > limit) throw too_large();  // the file grows, or does not tell its size
  }
  if (content.starts_with(k_lfs_pointer))
    throw fail("it is a Git LFS pointer, not the file itself", "Fetch that with git lfs pull");
  return content;
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path, error))
    throw cannot("make folder", path, "its parent may not be written to, or a file has that name", "Name another");
}

}  // namespace sandglass::host
