// What an interrupted bake needs to go on: the traced values and the state of training, under a key of everything that
// they depend on.
#pragma once

#include <cstdint>
#include <string>

#include "models/baking/trainer.h"

namespace sandglass::host {

void save_checkpoint(const std::string& path, uint64_t key, const TrainingSet& set, const TrainingState& state);

// False: there is none. A Failure: it is damaged, or of another mesh or other settings.
bool load_checkpoint(const std::string& path, uint64_t key, TrainingSet* set, TrainingState* state);

}  // namespace sandglass::host
