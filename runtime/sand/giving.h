// What no collider holds gives way to what goes on without time for it (Carry, in solver.h).
#pragma once

#include "runtime/sand/holding.h"

namespace sandglass {

void giving_layout(Carry* carry, const sandglass_granular_desc& desc, Layout* layout);
// Before all particles are looked at.
void giving_begin(Carry* carry, const Granular& granular);
// Notes particles that may have to give way: those of the bits of `which`, from `first` on. Their copies hold `scale`
// seconds of their velocity.
void giving_note(Carry* carry, const Granular& granular, const Bounds& box, uint32_t first, uint32_t which,
                 float scale);
// Items of the next unit, after all have been looked at; 0: nothing gives way.
uint32_t giving_items(const Carry& carry);
// One unit. True once all have given way.
bool giving_run(Carry* carry, const Granular& granular);

// These are in carry.cpp. A bound of the displacements of what is in a box; *after grows to hold the box after the
// motion.
float carry_box(const RigidMotion& motion, const Bounds& box, Bounds* after);
// Whether a collider holds its place against what one group moves.
bool carry_stands(const Granular& granular, uint32_t collider, uint32_t group);
// Puts a particle elsewhere, without a velocity.
void carry_put(Carry* carry, const Granular& granular, uint32_t particle, const Quad& to);
// The group that moves, if it is the only one; else k_carry_groups.
inline uint32_t carry_group_alone(const Carry& carry) { return carry.group_count == 1 ? 0 : k_carry_groups; }

}  // namespace sandglass
