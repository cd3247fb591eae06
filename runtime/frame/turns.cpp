// Whose unit of a group is next. capability.h has the rule.
#include "runtime/frame/capability.h"

namespace sandglass {
namespace {

struct Turn {
  const Members* members = nullptr;
  Member* member = nullptr;
  uint32_t first_kind = 0;
  WorkUnit unit;
};

double urgency(const Member& member) {
  const Capability& c = *member.capability;
  if (c.urgency != nullptr) return c.urgency(&member);
  return c.under_way(&member) ? 1 : 0;
}

// The handle of one capability that is next, if one of them has work. Says whether one is under way.
bool choose_member(const Members& members, uint32_t level, Turn* turn) {
  bool goes_on = false;
  double greatest = 0;
  for (uint32_t i = 0; i < members.count; ++i) {
    Member* member = member_at(members, i);
    WorkUnit unit;
    if (!member->capability->next(member, level, &unit)) continue;
    goes_on = goes_on || member->capability->under_way(member);
    const double here = urgency(*member);
    const bool later =
        turn->member != nullptr && (here < greatest || (here == greatest && member->served >= turn->member->served));
    if (later) continue;
    greatest = here;
    turn->members = &members;
    turn->member = member;
    turn->unit = unit;
  }
  return goes_on;
}

uint64_t last_served(const Members& members) {
  uint64_t last = 0;
  for (uint32_t i = 0; i < members.count; ++i) {
    const uint64_t served = member_at(members, i)->served;
    last = served > last ? served : last;
  }
  return last;
}

// Turn::member is null where none has work.
Turn choose(const Group& group, uint32_t level) {
  Turn chosen;
  uint32_t first_kind = 0;
  uint64_t longest_ago = 0;
  for (uint32_t i = 0; i < group.count; ++i) {
    const Members& members = group.members[i];
    Turn turn;
    const bool goes_on = choose_member(members, level, &turn);
    turn.first_kind = first_kind;
    first_kind += members.kinds;
    if (turn.member == nullptr) continue;
    if (goes_on) return turn;
    const uint64_t served = last_served(members);
    if (chosen.member != nullptr && served >= longest_ago) continue;
    chosen = turn;
    longest_ago = served;
  }
  return chosen;
}

void run_turn(const Group& group, const Turn& turn, uint32_t level) {
  const Capability& c = *turn.member->capability;
  c.run(turn.member, level);
  uint64_t last = 0;
  for (uint32_t i = 0; i < group.count; ++i) {
    const uint64_t served = last_served(group.members[i]);
    last = served > last ? served : last;
  }
  turn.member->served = last + 1;
  if (c.served == nullptr) return;
  for (uint32_t i = 0; i < turn.members->count; ++i) c.served(member_at(*turn.members, i), turn.member);
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const Turn turn = choose(*static_cast<const Group*>(state), level);
  if (turn.member == nullptr) return false;
  *unit = turn.unit;
  unit->kind += turn.first_kind;
  return true;
}

void run(void* state, uint32_t level) {
  const Group& group = *static_cast<const Group*>(state);
  const Turn turn = choose(group, level);
  if (turn.member != nullptr) run_turn(group, turn, level);
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Group& group = *static_cast<const Group*>(state);
  uint32_t count = 0, first_kind = 0;
  for (uint32_t i = 0; i < group.count; ++i) {
    const Members& members = group.members[i];
    const uint32_t begin = count;
    for (uint32_t k = 0; k < members.count; ++k) {
      Member* member = member_at(members, k);
      const uint32_t more = member->capability->forecast(member, level, entries + count), end = count + more;
      for (uint32_t e = count; e < end; ++e) {
        const Forecast entry = {first_kind + entries[e].kind, entries[e].items, entries[e].spread};
        uint32_t same = begin;
        while (same < count && entries[same].kind != entry.kind) ++same;
        const uint64_t others = same < count ? entries[same].items : 0;
        entries[same] = {entry.kind, others + entry.items, entry.spread};
        if (same == count) ++count;
      }
    }
    first_kind += members.kinds;
  }
  return count;
}

void run_alone(void* handle, uint32_t level) {
  Member* member = static_cast<Member*>(handle);
  const Capability& c = *member->capability;
  c.run(handle, level);
  ++member->served;
  if (c.served != nullptr) c.served(handle, handle);
}

// The stage of a group of one handle: nobody takes turns with it.
Stage begin_alone(const Group& group, const FrameView& view) {
  uint32_t i = 0, kinds_before = 0;
  for (; group.members[i].count == 0; ++i) kinds_before += group.members[i].kinds;
  Member* member = member_at(group.members[i], 0);
  const Capability& c = *member->capability;
  const uint32_t units = group.mandatory + c.begin_frame(member, view);
  Stage stage = {member, c.next, run_alone, c.forecast, group.kinds, units, group.share};
  stage.first_kind = kinds_before;
  return stage;
}

}  // namespace

Stage begin_group(Group* group, const FrameView& view) {
  if (group->handles == 0) return stage_without_work(group->kinds);
  if (group->handles == 1) return begin_alone(*group, view);
  uint32_t units = group->mandatory;
  for (uint32_t i = 0; i < group->count; ++i) {
    const Members& members = group->members[i];
    for (uint32_t k = 0; k < members.count; ++k) {
      Member* member = member_at(members, k);
      units += member->capability->begin_frame(member, view);
    }
  }
  return {group, next, run, forecast, group->kinds, units, group->share};
}

void end_group(const Group& group, sandglass_frame_report* report) {
  for (uint32_t i = 0; i < group.count; ++i) {
    const Members& members = group.members[i];
    for (uint32_t k = 0; k < members.count; ++k) {
      Member* member = member_at(members, k);
      if (member->capability->end_frame != nullptr) member->capability->end_frame(member, report);
    }
  }
}

uint32_t run_members(const Members& members, uint32_t units) {
  const Group group = {{members}, 1, members.count, members.kinds, 1.0f, 0};
  uint32_t done = 0;
  for (; done < units; ++done) {
    const Turn turn = choose(group, 0);
    if (turn.member == nullptr) break;
    run_turn(group, turn, 0);
  }
  return done;
}

}  // namespace sandglass
