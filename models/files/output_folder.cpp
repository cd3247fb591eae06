// A program that is killed leaves at most a folder "NAME.unfinished.NUMBER".
#include "models/files/output_folder.h"

#include <unistd.h>

#include <filesystem>

#include "models/files/failure.h"

namespace sandglass::host {

namespace fs = std::filesystem;

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  if (path_.empty()) return;
  std::error_code error;
  path_ = fs::weakly_canonical(fs::absolute(path), error).string();
  if (path_.ends_with('/')) path_.pop_back();
  if (fs::exists(path_, error) && !(fs::is_directory(path_, error) && fs::is_empty(path_, error)))
    throw cannot("write into", path_, "it is there already", "Remove it, or name a new folder");
  const std::string filled = path_ + ".unfinished." + std::to_string(getpid());
  make_folder(filled);
  filled_ = filled;
  listed_.emplace(filled_);
}

OutputFolder::~OutputFolder() {
  std::error_code error;
  if (!filled_.empty() && !kept_) fs::remove_all(filled_, error);
}

void OutputFolder::keep() {
  if (filled_.empty()) return;
  std::error_code error;
  fs::rename(filled_, path_, error);  // over an empty folder, too
  if (error) throw cannot("write", path_, error.message(), "Name another folder");
  kept_ = true;
  listed_.reset();
}

}  // namespace sandglass::host
