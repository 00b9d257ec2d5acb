#include "lsmvs/surface/weights/ray_weigher.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/surface/weights/ray_walk.h"

namespace lsmvs {
namespace {

// Where rays of one view go one way together behind 4 sigmas, they are taken to go on together:
// then the weights are not exact. Either sigmas are large, or no two rays are of the same view.
enum class Rays { kLargeSigmas, kViewsOfTheirOwn };

// Random points, the inner ones of which are seen: rays that begin on the hull are another matter.
struct SeenPoints {
  SeenPoints(int count, unsigned seed, Rays rays) : random(seed) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < count; ++i) points.push_back({Uniform(), Uniform(), Uniform()});
    for (const uint32_t i : HilbertOrder(points)) cloud.positions.push_back(points[i]);
    complex = BuildDelaunay(cloud.positions);
    const bool share_views = rays == Rays::kLargeSigmas;
    weights.centers = {{0.9, 0.1, 0.2}, {0.3, -0.5, 3}, {-4, 1, 0.5}};  // the first inside the hull
    weights.sink_distance_factor = share_views ? 0.1 : 2;
    weights.sink_weight = 0.75;
    cloud.sight_begin = {0};
    for (const Eigen::Vector3f& x : cloud.positions) {
      weights.sigmas.push_back(share_views ? 1.3f + 0.2f * Uniform() : 0.05f + 0.03f * Uniform());
      if (x.norm() < 0.6f) share_views ? SeeFromEach() : SeeFromItsOwn();
      cloud.sight_begin.push_back(cloud.sights.size());
    }
  }

  float Uniform() { return std::uniform_real_distribution<float>(-1, 1)(random); }
  void SeeFromEach() {
    for (uint32_t view = 0; view < 3; ++view) {
      if (random() % 2 == 0) cloud.sights.push_back({view, 0.2f + std::abs(Uniform())});
    }
  }
  void SeeFromItsOwn() {
    cloud.sights.push_back({static_cast<uint32_t>(weights.centers.size()), 1});
    weights.centers.push_back(Eigen::Vector3d(3 * Uniform(), 3 * Uniform(), 4));
  }

  std::mt19937 random;
  MergedCloud cloud;
  RayWeights weights;
  Tetrahedralization complex;
};

using Sides = std::vector<bool>;  // by cell: whether it is on the source's side, empty

// Random, but views and what lies beyond the hull are empty, as any finite cut has them.
Sides RandomSides(const SeenPoints& seen, unsigned seed) {
  std::mt19937 random(seed);
  Sides empty(seen.complex.cells.size(), true);
  for (size_t c = 0; c < seen.complex.num_finite_cells; ++c) empty[c] = random() % 2 == 0;
  for (const Eigen::Vector3d& center : seen.weights.centers) {
    empty[static_cast<size_t>(LocateCell(seen.complex, center.cast<float>(), 0))] = true;
  }
  return empty;
}

// What the graph says that a cut costs.
double CutValue(const Tetrahedralization& complex, const Sides& empty) {
  double value = 0;
  for (size_t c = 0; c < complex.cells.size(); ++c) {
    const Cell& cell = complex.cells[c];
    value += empty[c] ? cell.excess : cell.distance;
    for (int i = 0; i < 4 && empty[c]; ++i) {
      if (!empty[static_cast<size_t>(cell.neighbor[i])]) value += cell.capacity[i];
    }
  }
  return value;
}

// What the rays say, by the definition: a facet that is crossed from the view's side into the full
// costs the ray's weight there, an empty cell behind the point costs what speaks for its being
// full.
struct Expected {
  double value = 0;
  size_t num_terms = 0;
};
Expected CutValueOfRays(const SeenPoints& seen, const Sides& empty) {
  const RayWalker walker(seen.complex);
  Expected expected;
  const auto add = [&](double weight) {
    expected.value += weight * kCapacityPerWeight;
    ++expected.num_terms;
  };
  for (size_t p = 0; p < seen.cloud.positions.size(); ++p) {
    for (const Sight& sight : seen.cloud.SightsOf(p)) {
      const Eigen::Vector3d x = seen.cloud.positions[p].cast<double>();
      const Eigen::Vector3d way = seen.weights.centers[sight.view_idx] - x;
      const double sigma = seen.weights.sigmas[p];
      walker.Walk(static_cast<int32_t>(p), way.normalized(), way.norm(), 1e9,
                  [&](int32_t entered, int facet, double d) {
                    const int32_t left =
                        seen.complex.cells[static_cast<size_t>(entered)].neighbor[facet];
                    if (!empty[static_cast<size_t>(entered)] || empty[static_cast<size_t>(left)]) {
                      return;
                    }
                    add(sight.support * -std::expm1(-0.5 * d * d / (sigma * sigma)));
                  });
      const Eigen::Vector3d behind =
          x - seen.weights.sink_distance_factor * sigma * way.normalized();
      const int32_t cell = LocateCell(seen.complex, behind.cast<float>(), 0);
      if (empty[static_cast<size_t>(cell)]) add(seen.weights.sink_weight * sight.support);
    }
  }
  return expected;
}

TEST(RayWeigher, EveryCutCostsWhatTheRaysSay) {
  for (const Rays rays : {Rays::kLargeSigmas, Rays::kViewsOfTheirOwn}) {
    SeenPoints seen(400, 1, rays);
    const RayCounters counters = WeighRays(seen.cloud, seen.weights, RunContext(1), &seen.complex);
    EXPECT_EQ(counters.num_rays, seen.cloud.sights.size());
    EXPECT_EQ(counters.num_lost_rays, 0u);
    for (unsigned cut = 0; cut < 20; ++cut) {
      const Sides empty = RandomSides(seen, cut);
      const Expected expected = CutValueOfRays(seen, empty);
      ASSERT_GT(expected.num_terms, 50u);
      // Each term is rounded to a whole number, and weights beyond 4 sigmas are 1.
      EXPECT_NEAR(CutValue(seen.complex, empty), expected.value,
                  0.6 * static_cast<double>(expected.num_terms));
    }
  }
}

TEST(RayWeigher, ThreadsDoNotChangeTheWeights) {
  SeenPoints one(3000, 5, Rays::kLargeSigmas), many(3000, 5, Rays::kLargeSigmas);
  WeighRays(one.cloud, one.weights, RunContext(1), &one.complex);
  WeighRays(many.cloud, many.weights, RunContext(4), &many.complex);
  for (size_t c = 0; c < one.complex.cells.size(); ++c) {
    ASSERT_EQ(one.complex.cells[c].capacity, many.complex.cells[c].capacity);
    ASSERT_EQ(one.complex.cells[c].distance, many.complex.cells[c].distance);
    ASSERT_EQ(one.complex.cells[c].excess, many.complex.cells[c].excess);
  }
}

}  // namespace
}  // namespace lsmvs
