// A folder of outputs that appears whole: it is filled under another name beside, and gets its own when the work is done.
// Nothing that is there already is changed: such a folder is refused, unless it is empty.
#pragma once

#include <optional>
#include <string>

#include "models/files/atomic_file.h"

namespace sandglass::host {

class OutputFolder {
 public:
  // Makes the folder to fill. An empty `path`: none is wanted. Throws a Failure where it could not be kept later.
  explicit OutputFolder(const std::string& path);
  // Removes what was not kept.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // Where to write; empty where none is wanted.
  const std::string& path() const { return filled_; }
  // The folder gets its name.
  void keep();

 private:
  std::string path_, filled_;
  std::optional<UnfinishedFile> listed_;  // against Ctrl-C
  bool kept_ = false;
};

}  // namespace sandglass::host
