// The sort by cell in place: the order of the sort that copies, and never a record lost or doubled on the way.
#include "runtime/sand/particles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "runtime/math/random.h"

namespace {

using namespace sandglass;

constexpr uint32_t k_count = 3000, k_cells = 512, k_unit = 64;

std::vector<Grain> scattered_grains() {
  std::vector<Grain> grains(k_count + k_array_slack);
  Random random = {1};
  for (uint32_t i = 0; i < k_count; ++i) {
    for (float& x : grains[i].position) x = static_cast<float>(random.uniform());
    grains[i].number = i;
  }
  return grains;
}

struct Sort {
  Sort() : starts(k_cells + k_array_slack), keys(k_count + k_array_slack) {
    sort.cells_max = k_cells;
    sort.starts = starts.data();
    sort.keys = keys.data();
    const float low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    cell_sort_begin(&sort, 0.2f, low, high, 3);
  }
  bool run(const std::vector<Grain>& from, std::vector<Grain>* to) {
    const SortTarget target = {as_records(to->data()), {nullptr, nullptr, nullptr}, false};
    cell_sort_run(&sort, *select_kernels(SANDGLASS_ISA_AUTOMATIC), as_records(from.data()), k_count, k_unit, target);
    return sort.phase != k_sort_done;
  }
  std::vector<uint32_t> starts, keys;
  CellSort sort = {};
};

bool each_is_there(const std::vector<Grain>& grains) {
  std::vector<uint32_t> numbers;
  for (uint32_t i = 0; i < k_count; ++i) numbers.push_back(grains[i].number);
  std::sort(numbers.begin(), numbers.end());
  for (uint32_t i = 0; i < k_count; ++i) {
    if (numbers[i] != i) return false;
  }
  return true;
}

TEST(CellSort, InPlaceGivesTheOrderOfTheCopy) {
  const std::vector<Grain> before = scattered_grains();
  std::vector<Grain> copied(before.size()), swapped = before;
  Sort copying, in_place;
  while (copying.run(before, &copied)) {
  }
  uint32_t units = 0;
  while (in_place.run(swapped, &swapped)) {
    ASSERT_TRUE(each_is_there(swapped)) << "after unit " << units;
    // To clear, count, sum and find places takes 2 + 47 + 1 + 47 units; then there are two steps a grain at most.
    ASSERT_LT(++units, 97 + 2 * k_count / k_unit + 2);
  }
  uint32_t moved = 0;
  for (uint32_t i = 0; i < k_count; ++i) {
    EXPECT_EQ(swapped[i].number, copied[i].number);
    moved += copied[i].number != i ? 1 : 0;
  }
  EXPECT_GT(moved, k_count / 2);  // else nothing was shown
}

}  // namespace
