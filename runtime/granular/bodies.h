// Rigid bodies by shape matching (4.28-4.36). The particles of a body take part in the contact pass like sand, each
// with its own inverse mass. After it, the rigid motion that fits their displacements best replaces them. So contacts
// push bodies and bodies push sand, and linear momentum is what the particles' was.
//
// A body carries its pose (centre in double, rotation). What is matched is the displacement of the sub-step: small
// quantities, never differences of stored positions (correction to Alg. 4). Positions then follow from the pose, so a
// body stays rigid to the rounding of a float however often it moves.
//
// A body sleeps and wakes as a whole.
#pragma once

#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

struct RigidBody {
  uint32_t first, count;        // slots of its particles
  double center[3];             // of mass
  double rotation[4];           // from the rest shape
  float linear[3], angular[3];  // velocities, m/s and rad/s
};

// Sums over a body's particles, and the motion that they give.
struct BodyMatch {
  double shift[3], stabilised[3], offset[3], a[9];
  double spread[9], spin[3];  // sums of r r^T and of r x displacement
  double turn[4];
};

// Each particle of a body has a slot; a body's slots follow each other, and no slot is free in between. A body that was
// removed leaves a number free: in its place stands a body of nothing but zeros. The last one has particles.
struct Bodies {
  RigidBody* all;
  float* rest_shape;  // 3 a slot: position from the centre of mass, unturned
  uint32_t* rows;     // the index of each slot's particle
  uint32_t* numbers;  // and its number
  uint32_t* inside;   // of each body: particles that the drain under way found in a sink
  uint32_t count, particle_count;
  float densest;  // density relative to sand
  // Progress of the phase: the particles of a body are summed up, then moved.
  uint32_t cursor, particle;
  bool moves;
  BodyMatch match;
};

void bodies_layout(Bodies* bodies, const sandglass_granular_desc& desc, Layout* layout);
void bodies_reset(Bodies* bodies);

sandglass_status granular_add_body(Granular* granular, const sandglass_body* body, uint32_t* index,
                                   const char** reason);
sandglass_status granular_remove_body(Granular* granular, uint32_t index, const char** reason);
sandglass_status granular_set_body(Granular* granular, uint32_t index, const sandglass_body_pose* pose,
                                   const char** reason);
sandglass_status granular_push_body(Granular* granular, uint32_t index, const float impulse[3], const float* point,
                                    const char** reason);
void granular_body_pose(const Granular& granular, uint32_t index, sandglass_body_pose* pose);

bool bodies_has(const Bodies& bodies, uint32_t index);
// Takes the body out, with its particles. No phase of the bodies may be under way.
void bodies_remove(Granular* granular, uint32_t index);
// Gives the particles of a body the velocities that its own say.
void bodies_set_velocities(Granular* granular, const RigidBody& body);
// Where the pose of a body puts the particle of a slot.
void bodies_place(const Bodies& bodies, const RigidBody& body, uint32_t slot, float position[3]);
void bodies_move(Bodies* bodies, uint32_t index, const double rotation[4], const float shift[3]);

// The phase of a sub-step. False: no body is awake.
bool bodies_begin(Granular* granular);
uint32_t bodies_items(const Granular& granular);  // of the next unit
bool bodies_run(Granular* granular);              // true once all are done

// Where the particles of bodies are after sorting: of all, and of the particle with this index.
void bodies_find_rows(Granular* granular);
void bodies_note_row(Granular* granular, uint32_t index);

// Sinks take the bodies of which they hold every particle. The drain notes each awake particle of body `index` that it
// finds inside.
void bodies_begin_drain(Bodies* bodies);
void bodies_note_inside(Bodies* bodies, uint32_t index);
void bodies_drain(Granular* granular);

// Bodies whose particles have all kept still for `patience` checks fall asleep.
void bodies_put_to_sleep(Granular* granular, uint32_t patience);

}  // namespace sandglass
