// Reads NumPy's .npz: a zip of .npy arrays, as numpy.savez writes it (stored, not compressed). Arrays of 32-bit floats
// and of bytes, in C order, come back as floats. The file may be damaged: every offset and length is checked.
#pragma once

#include <map>
#include <string>

#include "models/files/npy.h"

namespace sandglass::host {

// The arrays by their names without ".npy". A Failure names the file, and the array if one is at fault.
std::map<std::string, NpyArray> read_npz(const std::string& path);

}  // namespace sandglass::host
