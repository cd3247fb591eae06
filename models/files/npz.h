// NumPy's .npz: a zip of .npy arrays, as numpy.savez writes it (stored, not compressed). Arrays of 32-bit floats and of
// bytes, in C order, come back as floats. The file may be damaged: every offset and length is checked.
#pragma once

#include <map>
#include <string>

#include "models/files/npy.h"

namespace sandglass::host {

// By name without ".npy"; a Failure that names the file, and the array where one is at fault.
std::map<std::string, NpyArray> read_npz(const std::string& path);

}  // namespace sandglass::host
