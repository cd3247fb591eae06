// What an interrupted bake needs to go on: the traced values and the state of training. A key in the file is a hash of
// everything that they depend on.
#pragma once

#include <cstdint>
#include <string>

#include "models/baking/trainer.h"

namespace sandglass::host {

void save_checkpoint(const std::string& path, uint64_t key, const TrainingSet& set, const TrainingState& state);

// Throws a Failure when a file that is no checkpoint has this name.
void require_own_checkpoint(const std::string& path);

// Returns false when there is no checkpoint. Throws a Failure when it is damaged or belongs to another mesh or other
// settings.
bool load_checkpoint(const std::string& path, uint64_t key, TrainingSet* set, TrainingState* state);

}  // namespace sandglass::host
