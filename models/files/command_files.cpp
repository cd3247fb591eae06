// Files are compared by their canonical path and, if they exist, by device and inode number.
#include "models/files/command_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

struct Identity {
  std::string path;
  bool exists = false;
  dev_t device = 0;
  ino_t number = 0;

  bool operator==(const Identity& other) const {
    return path == other.path || (exists && other.exists && device == other.device && number == other.number);
  }
};

struct Output {
  Identity file;
  enum class Kind { once, again_and_again, folder } kind = Kind::once;

  bool is(const Identity& other) const {
    return file == other || (kind == Kind::folder && other.path.starts_with(file.path + "/"));
  }
  // A file, whose name is wanted for a folder that holds `path`.
  bool bars(const std::string& path) const { return kind != Kind::folder && path.starts_with(file.path + "/"); }
};

struct Folder {
  int mark;                       // open and locked
  bool was_marked;                // by an earlier process
  std::vector<std::string> made;  // the folder and its parents that were not there, innermost first
};

// What the command has read, announced and written so far.
struct Watch {
  std::mutex mutex;
  bool on = false;
  std::vector<Identity> inputs;
  std::vector<Output> claimed;
  std::vector<std::string> written;       // canonical paths
  std::map<std::string, Folder> folders;  // by canonical path
};

Watch& watch() {
  static Watch the_watch;
  return the_watch;
}

Identity identity_of(const std::string& path) {
  std::error_code error;
  Identity identity;
  identity.path = fs::weakly_canonical(fs::absolute(path, error), error).string();
  if (error) identity.path = path;
  struct stat status = {};
  identity.exists = stat(path.c_str(), &status) == 0;
  identity.device = status.st_dev, identity.number = status.st_ino;
  return identity;
}

template <class Range>
bool has(const Range& range, const Identity& file) {
  return std::find(range.begin(), range.end(), file) != range.end();
}

Failure reads_it(const std::string& path) {
  return cannot("write", path, "the same command reads it", "Write somewhere else");
}
Failure twice(const std::string& path) {
  return cannot("write", path, "two outputs of the command have this name", "Give each a name of its own");
}

constexpr std::string_view k_mark =
    "sandglass is writing into this folder, or did not finish: files may be missing, or be of an earlier run.\n";

// A file, link or pipe that has the mark's name and was not made by begin_folder.
Failure foreign_mark(const std::string& mark) {
  return cannot("write", mark, "another file has the name of the mark", "Remove it, or name another folder");
}

// True for a new mark, and for one that an earlier process left.
bool is_mark(int file, const struct stat& status) {
  char text[k_mark.size() + 1];
  const ssize_t size = S_ISREG(status.st_mode) && status.st_nlink == 1 ? pread(file, text, sizeof text, 0) : -1;
  return size >= 0 && k_mark.starts_with(std::string_view(text, static_cast<size_t>(size)));
}

// Opens the mark of a folder and locks it. Returns -1 when another process holds the lock.
int locked_mark(const std::string& folder, const std::string& mark) {
  for (;;) {
    const int file = open(mark.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file < 0 && errno == ELOOP) throw foreign_mark(mark);
    if (file < 0) throw cannot("write into", folder, std::strerror(errno), "Name another folder");
    if (flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      close(file);
      return -1;
    }
    // The process that held the lock may have removed the mark in between.
    struct stat ours = {}, there = {};
    const bool answered = fstat(file, &ours) == 0 && (lstat(mark.c_str(), &there) == 0 || errno == ENOENT);
    const bool same = answered && ours.st_ino == there.st_ino;
    if (same && is_mark(file, ours)) return file;
    close(file);
    if (!answered) throw cannot("write into", folder, "the disk does not answer", "Name another folder");
    if (same) throw foreign_mark(mark);
  }
}

// The folder and its parents that do not exist, innermost first.
std::vector<std::string> missing_folders(const std::string& path) {
  std::vector<std::string> missing;
  std::error_code error;
  fs::path at = identity_of(path).path;
  for (; at.has_relative_path() && !fs::exists(at, error); at = at.parent_path()) missing.push_back(at.string());
  return missing;
}

}  // namespace

void watch_files() { watch().on = true; }

// Throws a Failure when the command has read the output, or has announced it already.
static void require_unused(const Watch& w, const std::string& path, const Output& output) {
  for (const Identity& input : w.inputs)
    if (output.is(input)) throw reads_it(path);
  for (const Output& other : w.claimed)
    if (other.file == output.file) throw twice(path);
    else if (other.bars(output.file.path) || output.bars(other.file.path))
      throw cannot("write", path, "\"" + other.file.path + "\" is an output, too, and a file is no folder",
                   "Give each a name of its own");
}

static void claim(const std::string& path, Output::Kind kind) {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  if (!w.on) return;
  const Output output = {identity_of(path), kind};
  require_unused(w, path, output);
  w.claimed.push_back(output);
}

void claim_output(const std::string& path, bool again_and_again) {
  require_writable(path);
  claim(path, again_and_again ? Output::Kind::again_and_again : Output::Kind::once);
}

void claim_folder(const std::string& path) {
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error))
    throw cannot("make folder", path, "a file has that name", "Name another");
  claim(path, Output::Kind::folder);
}

static void claim_files(const std::string& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::string path = (fs::path(folder) / name).string();
    if (fs::exists(path)) require_writable(path);
    claim(path, Output::Kind::once);
  }
}

void note_input(const std::string& path) {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  if (!w.on) return;
  const Identity file = identity_of(path);
  for (const Output& output : w.claimed)
    if (output.is(file)) throw reads_it(path);
  if (!has(w.inputs, file)) w.inputs.push_back(file);
}

void note_output(const std::string& path) {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  if (!w.on) return;
  const Identity file = identity_of(path);
  if (has(w.inputs, file)) throw reads_it(path);
  for (const Output& output : w.claimed)
    if (output.file == file && output.kind == Output::Kind::again_and_again) return;
  if (std::find(w.written.begin(), w.written.end(), file.path) != w.written.end()) throw twice(path);
  w.written.push_back(file.path);
}

void begin_folder(const std::string& path, const std::vector<std::string>& names) {
  claim_files(path, names);
  const std::vector<std::string> made = missing_folders(path);
  make_folder(path);
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  const std::string folder = identity_of(path).path;
  if (!w.on || w.folders.count(folder) != 0) return;
  const std::string mark = (fs::path(folder) / k_incomplete).string();
  require_unused(w, mark, {identity_of(mark)});
  const int file = locked_mark(path, mark);
  if (file < 0)
    throw cannot("write into", path, "another process of sandglass is writing there", "Wait for it, or name another");
  struct stat status = {};
  const bool was_marked = fstat(file, &status) == 0 && status.st_size > 0;
  if (pwrite(file, k_mark.data(), k_mark.size(), 0) != static_cast<ssize_t>(k_mark.size())) {
    close(file);
    throw cannot("write into", path, "the disk is full or failing", "Name another folder");
  }
  w.folders[folder] = {file, was_marked, made};
  w.claimed.push_back({identity_of(mark)});
  w.written.push_back(w.claimed.back().file.path);
}

static bool remove_unread(const Watch& w, const std::string& path) {
  if (has(w.inputs, identity_of(path)))
    throw cannot("remove", path, "the same command reads it", "Write somewhere else");
  return unlink(path.c_str()) == 0;
}

bool remove_output(const std::string& path) {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  return remove_unread(w, path);
}

void remove_unwritten(const std::string& folder, const std::vector<std::string>& names) {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  if (!w.on) return;
  for (const std::string& name : names) {
    const std::string file = (fs::path(folder) / name).string();
    if (std::find(w.written.begin(), w.written.end(), identity_of(file).path) == w.written.end())
      remove_unread(w, file);
  }
}

void finish_folders() {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  std::string kept, why;
  for (const auto& [folder, state] : w.folders) {
    const std::string mark = (fs::path(folder) / k_incomplete).string();
    if (unlink(mark.c_str()) != 0 && errno != ENOENT) kept = mark, why = std::strerror(errno);
    close(state.mark);
  }
  w.folders.clear();
  if (!kept.empty()) throw cannot("remove", kept, why, "Its folder is whole: remove the file yourself");
}

std::string leave_folders() {
  Watch& w = watch();
  const std::lock_guard lock(w.mutex);
  const bool nothing = std::all_of(w.written.begin(), w.written.end(),
                                   [](const std::string& file) { return fs::path(file).filename() == k_incomplete; });
  std::string left = nothing ? "nothing was written" : "each file that was written is whole";
  for (auto at = w.folders.rbegin(); at != w.folders.rend(); ++at) {  // what lies in a folder comes behind it
    const auto& [folder, state] = *at;
    const std::string mark = (fs::path(folder) / k_incomplete).string();
    const bool untouched = std::none_of(
        w.written.begin(), w.written.end(),
        [&, below = folder + "/"](const std::string& file) { return file != mark && file.starts_with(below); });
    if (untouched && !state.was_marked) unlink(mark.c_str());
    else left = "\"" + folder + "\" is incomplete";
    close(state.mark);
    if (untouched)
      for (const std::string& made : state.made) rmdir(made.c_str());  // one that holds something stays
  }
  w.folders.clear();
  return left;
}

void require_complete(const std::string& folder) {
  std::error_code error;
  if (fs::exists(fs::path(folder) / k_incomplete, error))
    throw cannot("use", folder, std::string("it is incomplete: it holds ") + k_incomplete, "Make it again");
}

}  // namespace sandglass::host
