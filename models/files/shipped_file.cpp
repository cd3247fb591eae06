// See shipped_file.h.
#include "models/files/shipped_file.h"

#include <filesystem>

namespace sandglass::host {

namespace fs = std::filesystem;

std::vector<std::string> shipped_folders(const std::string& kind) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return {SANDGLASS_MODELS_DIR "/" + kind, (program.parent_path() / ".." / "share" / "sandglass" / kind).string()};
}

std::string shipped_file(const std::string& kind, const std::string& name) {
  std::error_code error;
  for (const std::string& folder : shipped_folders(kind))
    if (fs::is_regular_file(fs::path(folder) / name, error)) return (fs::path(folder) / name).string();
  return "";
}

}  // namespace sandglass::host
