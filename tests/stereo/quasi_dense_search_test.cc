#include "lsmvs/stereo/quasi_dense/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lsmvs/stereo/quasi_dense/image_cache.h"
#include "lsmvs/test_stereo/quasi_dense_scene.h"

namespace lsmvs::quasi_dense {
namespace {

constexpr int kView = 2;

// What the matcher makes for one view on one level.
SearchView MakeSearchView(const PhotoScene& scene, int level) {
  PackedImageCache cells(*scene.images, size_t{1} << 30);
  const std::vector<int> neighbors = SymmetricNeighbors(scene.neighbors, 4)[kView];
  const DepthRange range = EstimateDepthRanges(scene.synthetic.scene)[kView];
  SearchView view;
  view.image = cells.Get(kView, level);
  view.pairings = MakePairings(scene.synthetic.scene, *scene.images, level, kView, neighbors);
  for (const int other : neighbors) view.others.push_back(cells.Get(other, level));
  view.pattern = MakeWindowPattern(3);
  view.min_inverse_depth = static_cast<float>(1 / range.max);
  view.max_inverse_depth = static_cast<float>(1 / range.min);
  return view;
}

PointGrid Detect(const PhotoScene& scene, int level, float spacing) {
  return DetectInterestPoints(*scene.images->Gray(kView, level), nullptr, {spacing, 2, 4},
                              RunContext(1));
}

// Mean ZNCC over the best neighbours, the obvious way.
float Score(const SearchView& view, const Eigen::Vector2f& position, const Plane& plane) {
  ReferenceWindow reference;
  WindowWarp here;
  here.x = position.x();
  here.y = position.y();
  ReadReferenceWindow(*view.image, view.pattern, here, &reference);
  std::vector<float> scores;
  for (size_t s = 0; s < view.pairings.size(); ++s) {
    PlaneWarp warped;
    const bool seen = WarpPlane(view.pairings[s].there, position, plane, &warped) &&
                      WindowInside(*view.others[s], view.pattern, warped.warp);
    const float ncc =
        seen ? CompareWindow(*view.others[s], view.pattern, warped.warp, reference) : 0.0f;
    scores.push_back(std::max(ncc, 0.0f));
  }
  std::sort(scores.rbegin(), scores.rend());
  scores.resize(std::min<size_t>(scores.size(), kNumBest));
  float total = 0;
  for (const float score : scores) total += score;
  return total / static_cast<float>(scores.size());
}

// The best of a very fine sweep over the whole range.
float BruteForce(const SearchView& view, const Eigen::Vector2f& position, float* inverse_depth) {
  constexpr int kSteps = 1500;
  float best = -2;
  for (int k = 0; k <= kSteps; ++k) {
    const float t = static_cast<float>(k) / kSteps;
    const float w = view.min_inverse_depth + t * (view.max_inverse_depth - view.min_inverse_depth);
    const float score = Score(view, position, {w, 0, 0});
    if (score <= best) continue;
    best = score;
    *inverse_depth = w;
  }
  return best;
}

TEST(QuasiDenseSearch, SweepFindsWhatBruteForceFinds) {
  const SearchView view = MakeSearchView(ReliefScene(), 1);
  const PointGrid grid = Detect(ReliefScene(), 1, 6);
  int count = 0, same_score = 0, same_depth = 0;
  for (const InterestPoint& point : grid.cells.pixels) {
    if (!point.exists()) continue;
    float truth = 0;
    const float best = BruteForce(view, point.position, &truth);
    if (best < 0.8f) continue;
    PointSearch search(view, point.position);
    search.UseSlots(~0u, 8);
    search.Sweep();
    search.Refine(0.7f);
    ++count;
    same_score += search.score() > best - 0.03f;
    same_depth += std::abs(search.best().q - truth) < 0.4f * search.StepAt(truth);
  }
  ASSERT_GT(count, 60);
  EXPECT_GT(same_score, 0.96 * count);
  EXPECT_GT(same_depth, 0.96 * count);
}

TEST(QuasiDenseSearch, ScoreIsTheMeanOfTheBestNeighbors) {
  const SearchView view = MakeSearchView(SphereScene(), 0);
  const PointGrid grid = Detect(SphereScene(), 0, 10);
  const float middle = 0.5f * (view.min_inverse_depth + view.max_inverse_depth);
  for (const InterestPoint& point : grid.cells.pixels) {
    if (!point.exists()) continue;
    const Plane plane{middle, 1e-4f, -1e-4f};
    PointSearch search(view, point.position);
    search.UseSlots(~0u, 8);
    search.Try(plane);
    EXPECT_NEAR(search.score(), Score(view, point.position, plane), 1e-5f);
  }
}

TEST(QuasiDenseSearch, StepIsAPixelOfParallax) {
  const SearchView view = MakeSearchView(SphereScene(), 0);
  const Eigen::Vector2f position(100, 75);
  PointSearch search(view, position);
  search.UseSlots(~0u, 8);
  const float w = 0.5f * (view.min_inverse_depth + view.max_inverse_depth);
  const float step = search.StepAt(w);
  float total = 0;
  for (const Pairing& pairing : view.pairings) {
    const Eigen::Vector2f a = pairing.there(position, w - step / 2).hnormalized();
    const Eigen::Vector2f b = pairing.there(position, w + step / 2).hnormalized();
    total += (a - b).norm();
  }
  EXPECT_NEAR(total / static_cast<float>(view.pairings.size()), 1, 0.02);
}

TEST(QuasiDenseSearch, UsesTheMaskedSlotsFirst) {
  const SearchView view = MakeSearchView(ReliefScene(), 0);
  ASSERT_GE(view.pairings.size(), 4u);
  const Plane plane{0.5f * (view.min_inverse_depth + view.max_inverse_depth), 0, 0};
  PointSearch search(view, {120, 90});
  search.UseSlots(1u << 3, 4);  // one named, another fills up
  search.Try(plane);
  EXPECT_EQ(search.num_patches(), 2u);
  search.UseSlots(0b1111, 3);
  search.Try(plane);
  EXPECT_EQ(search.num_patches(), 5u);
}

TEST(QuasiDenseSearch, OutsideOfTheRangeIsNotTried) {
  const SearchView view = MakeSearchView(SphereScene(), 0);
  PointSearch search(view, {100, 75});
  search.UseSlots(~0u, 8);
  search.Try({2 * view.max_inverse_depth, 0, 0});
  search.Try({0.5f * view.min_inverse_depth, 0, 0});
  EXPECT_FALSE(search.found());
  EXPECT_EQ(search.num_patches(), 0u);
  search.Refine(0.7f);
  EXPECT_FALSE(search.found());
}

// Shares of the points on the surface that are matched, and of those within half a pixel of
// parallax of the true depth.
struct Shares {
  double matched = 0, right = 0;
};

Shares CompareWithTruth(const PhotoScene& scene, const SearchView& view, const PointGrid& grid,
                        int level) {
  const PinholeCamera camera = scene.images->Camera(kView, level);
  const DepthMap truth = TrueDepthMap(*scene.synthetic.shape, scene.synthetic.scene.views[kView],
                                      camera.width, camera.height, RunContext(2));
  int count = 0, matched = 0, right = 0;
  for (const InterestPoint& point : grid.cells.pixels) {
    if (!point.exists()) continue;
    const float depth =
        truth.depth(static_cast<int>(point.position.x()), static_cast<int>(point.position.y()));
    if (!(depth > 0)) continue;
    ++count;
    if (!point.matched()) continue;
    ++matched;
    PointSearch search(view, point.position);
    search.UseSlots(~0u, 8);
    right += std::abs(point.plane.q - 1 / depth) < 0.5f * search.StepAt(1 / depth);
  }
  EXPECT_GT(count, 100);
  return {static_cast<double>(matched) / count, static_cast<double>(right) / matched};
}

TEST(QuasiDenseSearch, CoarseToFineFindsTheTruth) {
  const PhotoScene& scene = ReliefScene();
  const SearchView coarse = MakeSearchView(scene, 1), fine = MakeSearchView(scene, 0);
  PointGrid coarser = Detect(scene, 1, 3), grid = Detect(scene, 0, 3);
  EXPECT_GT(SearchRange(coarse, RunContext(2), &coarser), 0u);
  EXPECT_GT(Propagate(coarse, RunContext(2), &coarser), 0u);
  const Shares on_coarse = CompareWithTruth(scene, coarse, coarser, 1);
  EXPECT_GT(on_coarse.matched, 0.6);
  EXPECT_GT(on_coarse.right, 0.5);  // before the mutual check takes the false ones
  EXPECT_GT(SearchFromCoarser(fine, coarser, {2, 2}, RunContext(2), &grid), 0u);
  EXPECT_GT(Propagate(fine, RunContext(2), &grid), 0u);
  const Shares on_fine = CompareWithTruth(scene, fine, grid, 0);
  EXPECT_GT(on_fine.matched, 0.6);
  EXPECT_GT(on_fine.right, 0.55);
}

TEST(QuasiDenseSearch, SameForAnyNumberOfThreads) {
  const SearchView view = MakeSearchView(SphereScene(), 1);
  PointGrid one = Detect(SphereScene(), 1, 3), three = one;
  for (const auto& [grid, num_threads] : {std::pair(&one, 1), std::pair(&three, 3)}) {
    SearchRange(view, RunContext(num_threads), grid);
    Propagate(view, RunContext(num_threads), grid);
  }
  for (size_t i = 0; i < one.cells.size(); ++i) {
    EXPECT_EQ(one.cells.pixels[i].plane.q, three.cells.pixels[i].plane.q);
    EXPECT_EQ(one.cells.pixels[i].slots, three.cells.pixels[i].slots);
  }
}

}  // namespace
}  // namespace lsmvs::quasi_dense
