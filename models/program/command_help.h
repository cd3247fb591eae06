// The help of a command as text: one line a command, and for each option its unit, range and default.
#pragma once

#include <string>

#include "models/program/command_line.h"

namespace sandglass::host {

std::string help_of(const Command& command);

}  // namespace sandglass::host
