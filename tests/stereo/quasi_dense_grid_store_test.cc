#include "lsmvs/stereo/quasi_dense/grid_store.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <vector>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs::quasi_dense {
namespace {

constexpr int kNumViews = 6;

// A grid that tells which one it is.
PointGrid NumberedGrid(int number, int width, int height) {
  PointGrid grid;
  grid.spacing = 1.0f + static_cast<float>(number);
  grid.cells = Raster<InterestPoint>(width, height);
  for (size_t cell = 0; cell < grid.cells.size(); ++cell) {
    InterestPoint& point = grid.cells.pixels[cell];
    point.position = {static_cast<float>(number), static_cast<float>(cell)};
    point.plane = {0.5f + static_cast<float>(number), 1, static_cast<float>(cell)};
    point.slots = static_cast<uint32_t>(cell);
  }
  return grid;
}

void ExpectNumbered(const PointGrid& grid, int number, int width, int height) {
  const PointGrid expected = NumberedGrid(number, width, height);
  EXPECT_EQ(grid.spacing, expected.spacing);
  ASSERT_EQ(grid.cells.width, width);
  ASSERT_EQ(grid.cells.height, height);
  for (size_t cell = 0; cell < expected.cells.size(); ++cell) {
    const InterestPoint &point = grid.cells.pixels[cell], &truth = expected.cells.pixels[cell];
    ASSERT_EQ(point.position, truth.position);
    ASSERT_EQ(point.plane.q, truth.plane.q);
    ASSERT_EQ(point.plane.qy, truth.plane.qy);
    ASSERT_EQ(point.slots, truth.slots);
  }
}

size_t GridBytes(int width, int height) {
  return static_cast<size_t>(width) * static_cast<size_t>(height) * sizeof(InterestPoint);
}

TEST(GridStore, GivesBackWhatWasPutLastWhateverTheBudget) {
  for (const size_t num_held : {0, 1, 3, 100}) {
    GridStore store(kNumViews, num_held * GridBytes(40, 30));
    std::vector<int> number(kNumViews, -1), width(kNumViews, 0);
    std::mt19937 random(5);
    for (int step = 0; step < 300; ++step) {
      const int view = static_cast<int>(random() % kNumViews);
      const size_t v = static_cast<size_t>(view);
      if (random() % 3 == 0) {
        number[v] = step;
        width[v] = 10 + static_cast<int>(random() % 31);  // larger and smaller than the one before
        store.Put(view, NumberedGrid(step, width[v], 30));
      } else if (number[v] >= 0) {
        ExpectNumbered(*store.Get(view), number[v], width[v], 30);
      } else {
        EXPECT_TRUE(store.Get(view)->cells.empty());
      }
      EXPECT_LE(store.held_bytes(), std::max<size_t>(1, num_held) * GridBytes(40, 30));
    }
  }
}

TEST(GridStore, WhatIsInUseOutlivesItsPlace) {
  GridStore store(kNumViews, 0);
  store.Put(0, NumberedGrid(7, 20, 20));
  const auto grid = store.Get(0);
  store.Put(1, NumberedGrid(8, 20, 20));
  store.Put(0, NumberedGrid(9, 20, 20));
  ExpectNumbered(*grid, 7, 20, 20);
}

TEST(GridStore, LeavesNoFileAndNamesTheFolderThatItCannotUse) {
  const TemporaryFolder folder;
  setenv("TMPDIR", folder.path().c_str(), 1);
  {
    GridStore store(kNumViews, 0);
    for (int v = 0; v < kNumViews; ++v) store.Put(v, NumberedGrid(v, 20, 20));
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
  const std::filesystem::path missing = folder.path() / "missing";
  setenv("TMPDIR", missing.c_str(), 1);
  GridStore store(kNumViews, 0);
  store.Put(0, NumberedGrid(0, 20, 20));
  try {
    store.Put(1, NumberedGrid(1, 20, 20));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kFileSystem);
    EXPECT_NE(std::string(error.what()).find("TMPDIR"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(missing.string()), std::string::npos) << error.what();
  }
  unsetenv("TMPDIR");
}

}  // namespace
}  // namespace lsmvs::quasi_dense
