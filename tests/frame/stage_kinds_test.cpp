// Every stage counts its kinds of work unit from 0. The array of stages gives them their places among all kinds.
#include <gtest/gtest.h>

#include "runtime/frame/capability.h"

namespace sandglass::governor_test {
namespace {

// A stage with one work unit, of its last kind.
Stage stage_of(uint32_t* kinds) {
  return {kinds,
          [](const void* state, uint32_t, WorkUnit* unit) {
            *unit = {*static_cast<const uint32_t*>(state) - 1, 1, "fake"};
            return true;
          },
          [](void*, uint32_t) {},
          [](const void* state, uint32_t, Forecast* entries) -> uint32_t {
            const uint32_t count = *static_cast<const uint32_t*>(state);
            for (uint32_t k = 0; k < count; ++k) entries[k] = {k, 1};
            return count;
          },
          *kinds,
          1,
          1.0f};
}

uint32_t kind_offered(const Stage& stage) {
  WorkUnit unit;
  return stage_next(stage, 0, &unit) ? unit.kind : k_unit_kind_none;
}

TEST(StageKinds, BeginWhereThoseOfTheStageBeforeEnd) {
  uint32_t three = 3, two = 2, none = k_unit_kind_none + 1;
  // The third has the state of the first, and so its kinds. The last one offers a unit without a kind.
  Stage stages[4] = {stage_of(&three), stage_of(&two), stage_of(&three), stage_of(&none)};
  stages[3].kinds = 0;
  assign_kinds(stages, 4);
  EXPECT_EQ(kind_offered(stages[0]), 2u);
  EXPECT_EQ(kind_offered(stages[1]), 4u);
  EXPECT_EQ(kind_offered(stages[2]), 2u);
  EXPECT_EQ(kind_offered(stages[3]), k_unit_kind_none);
  Forecast entries[k_unit_kinds];
  ASSERT_EQ(stage_forecast(stages[1], 0, entries), 2u);
  EXPECT_EQ(entries[0].kind, 3u);
  EXPECT_EQ(entries[1].kind, 4u);
}

// The predictor remembers costs by place. So a capability that joins or leaves must not move the places of the others.
TEST(StageKinds, StayWhereTheyAreWhenACapabilityIsLeftOut) {
  uint32_t three = 3, two = 2, one = 1;
  Stage with[3] = {stage_of(&three), stage_of(&two), stage_of(&one)};
  Stage without[3] = {stage_without_work(3), stage_without_work(2), stage_of(&one)};
  assign_kinds(with, 3);
  assign_kinds(without, 3);
  EXPECT_EQ(kind_offered(without[0]), k_unit_kind_none);
  EXPECT_EQ(kind_offered(without[2]), kind_offered(with[2]));
}

// A handle whose one unit is of its kind 1.
struct Fake {
  Member member;
  bool works;
};
constexpr Capability k_fake = {
    [](void*, const FrameView&) -> uint32_t { return 0; },
    [](const void* handle, uint32_t, WorkUnit* unit) {
      *unit = {1, 1, "fake"};
      return static_cast<const Fake*>(handle)->works;
    },
    [](void*, uint32_t) {},
    [](const void*, uint32_t, Forecast* entries) -> uint32_t {
      entries[0] = {1, 1};
      return 1;
    },
    [](const void*) { return false; },
};

// The same in a group: of a handle that is alone there, and of one beside another that has no work.
TEST(StageKinds, StayWhereTheyAreWhenAHandleIsAlone) {
  Fake first = {{&k_fake, 0}, false}, second = {{&k_fake, 0}, true};
  for (Fake* beside : {&first, static_cast<Fake*>(nullptr)}) {
    Fake* handle = &second;
    Group group;
    clear_group(&group, 1.0f, 0);
    add_members(&group, member_of(beside, 2));
    add_members(&group, member_of(handle, 3));
    uint32_t four = 4;
    Stage stages[2] = {stage_of(&four), begin_group(&group, {})};
    assign_kinds(stages, 2);
    EXPECT_EQ(kind_offered(stages[1]), 4u + 2 + 1);
    Forecast entries[k_unit_kinds];
    const uint32_t count = stage_forecast(stages[1], 0, entries);
    ASSERT_GT(count, 0u);
    EXPECT_EQ(entries[count - 1].kind, 4u + 2 + 1);
    const uint64_t served = second.member.served;
    stages[1].run(stages[1].state, 0);
    EXPECT_EQ(second.member.served, served + 1);
  }
}

}  // namespace
}  // namespace sandglass::governor_test
