#include "lsmvs/surface/visibility_weights.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lsmvs/surface/weights/ray_weigher.h"

namespace lsmvs {

namespace {

// Cosine of the angle between facet i and the circumsphere of a tetrahedron, negative where the
// centre lies beyond the facet.
std::array<double, 4> CircumsphereCosines(const Tetrahedralization& complex, const Cell& cell) {
  std::array<Eigen::Vector3d, 4> x;
  for (int k = 0; k < 4; ++k) x[k] = complex.points[cell.vertex[k]].cast<double>();
  const Eigen::Vector3d a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const double volume = a.dot(b.cross(c));
  std::array<double, 4> cosines = {};
  if (!(volume > 0)) return cosines;
  const Eigen::Vector3d center =
      (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)) /
      (2 * volume);
  const double radius = center.norm();
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d &p = x[kFacetVertices[k][0]], &q = x[kFacetVertices[k][1]],
                          &r = x[kFacetVertices[k][2]];
    const Eigen::Vector3d inward = (q - p).cross(r - p);
    const double scale = inward.norm() * radius;
    cosines[k] = scale > 0 ? std::clamp((center + x[0] - p).dot(inward) / scale, -1.0, 1.0) : 0;
  }
  return cosines;
}

// Sets the capacities of all facets to the quality term, the same in both directions.
void WeighQuality(double regularization, const RunContext& context, Tetrahedralization* complex) {
  constexpr size_t kCellBlock = 1 << 14;
  constexpr double kUnit = 1 << 20;
  // First each cell notes its own cosines in the place of the capacities.
  ParallelFor(context, complex->num_finite_cells, kCellBlock, [&](size_t c) {
    Cell& cell = complex->cells[c];
    const std::array<double, 4> cosines = CircumsphereCosines(*complex, cell);
    for (int k = 0; k < 4; ++k) cell.capacity[k] = static_cast<int32_t>(kUnit * cosines[k]);
  });
  ParallelFor(context, complex->num_finite_cells, kCellBlock, [&](size_t c) {
    Cell& cell = complex->cells[c];
    for (int k = 0; k < 4; ++k) {
      const auto n = static_cast<size_t>(cell.neighbor[k]);
      if (n < c) continue;
      int32_t& other = complex->cells[n].capacity[cell.Reverse(k)];
      const bool hull = n >= complex->num_finite_cells;
      const double cosine = (hull ? cell.capacity[k] : std::min(cell.capacity[k], other)) / kUnit;
      cell.capacity[k] = other = ToCapacity(regularization * (1 - cosine));
    }
  });
}

// What is tied to source and to sink cancels; sums end at the limit.
void JoinTerminals(Tetrahedralization* complex) {
  const auto limit = [](int32_t* sum) { *sum = std::min(*sum, CutNode::kMaxCapacity); };
  for (Cell& cell : complex->cells) {
    for (int32_t& capacity : cell.capacity) limit(&capacity);
    limit(&cell.distance);
    limit(&cell.excess);
    cell.excess = cell.distance - cell.excess;
    cell.distance = 0;
  }
}

}  // namespace

std::vector<float> VertexSigmas(const Tetrahedralization& complex, double distance_sigma_factor,
                                const RunContext& context) {
  (void)context;
  // The nearest of each vertex' Delaunay neighbours, ascending.
  constexpr int kNumNearest = 4;
  struct Nearest {
    std::array<float, kNumNearest> squared;
    std::array<int32_t, kNumNearest> vertex;
    void Insert(float value, int32_t v) {
      if (value >= squared.back()) return;
      int k = kNumNearest - 1;
      for (int i = 0; i < kNumNearest; ++i) {
        if (vertex[i] == v) return;
      }
      for (; k > 0 && squared[k - 1] > value; --k) {
        squared[k] = squared[k - 1];
        vertex[k] = vertex[k - 1];
      }
      squared[k] = value;
      vertex[k] = v;
    }
  };
  Nearest none;
  none.squared.fill(std::numeric_limits<float>::max());
  none.vertex.fill(-1);
  std::vector<Nearest> nearest(complex.points.size(), none);
  for (size_t c = 0; c < complex.num_finite_cells; ++c) {
    const Cell& cell = complex.cells[c];
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        const int32_t a = cell.vertex[i], b = cell.vertex[j];
        const float squared = (complex.points[a] - complex.points[b]).squaredNorm();
        nearest[a].Insert(squared, b);
        nearest[b].Insert(squared, a);
      }
    }
  }
  std::vector<float> sigmas(nearest.size());
  for (size_t v = 0; v < sigmas.size(); ++v) {
    float squared = 0;
    for (int k = 0; k < kNumNearest; ++k) {
      if (nearest[v].vertex[k] >= 0) squared = nearest[v].squared[k];
    }
    sigmas[v] = static_cast<float>(distance_sigma_factor * std::sqrt(squared));
  }
  return sigmas;
}

RayCounters WeighCells(const Scene& scene, const MergedCloud& cloud,
                       const VisibilityWeightOptions& options, const RunContext& context,
                       Tetrahedralization* complex) {
  RayWeights weights;
  for (const View& view : scene.views) {
    weights.centers.push_back(cloud.frame.FromWorld(view.CenterInWorld()));
  }
  weights.sigmas = VertexSigmas(*complex, options.distance_sigma_factor, context);
  weights.sink_distance_factor = options.sink_distance_factor;
  weights.sink_weight = options.sink_weight;
  WeighQuality(options.quality_regularization, context, complex);
  const RayCounters counters = WeighRays(cloud, weights, context, complex);
  JoinTerminals(complex);
  return counters;
}

}  // namespace lsmvs
