#include "lsmvs/surface/visibility_weights.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "lsmvs/surface/ray_walk.h"

namespace lsmvs {

namespace {

constexpr size_t kBlock = 512;
constexpr double kNearSigmas = 4;  // beyond, a facet's weight is that of the ray up to 3e-4

// Sum that saturates: as all addends are positive, the result does not depend on their order.
// Threads may overshoot: what they leave above the limit is cut off at the end.
template <bool kShared>
void AddSaturated(int32_t* sum, int32_t amount) {
  if constexpr (!kShared) {
    *sum = std::min(CutNode::kMaxCapacity, *sum + amount);
  } else {
    std::atomic_ref<int32_t> shared(*sum);
    if (shared.load(std::memory_order_relaxed) < CutNode::kMaxCapacity) {
      shared.fetch_add(amount, std::memory_order_relaxed);
    }
  }
}

int32_t ToCapacity(double weight) {
  const double capacity = weight * kCapacityPerWeight + 0.5;
  return static_cast<int32_t>(std::min<double>(capacity, CutNode::kMaxCapacity));
}

// Adds the weights of rays. While it runs, a cell's `distance` holds what is tied to the source and
// `excess` what is tied to the sink, both >= 0.
template <bool kShared>
class RayWeigher {
 public:
  RayWeigher(const MergedCloud& cloud, const std::vector<Eigen::Vector3d>& centers,
             const std::vector<float>& sigmas, const VisibilityWeightOptions& options,
             const RayWalker& walker, CellComplex* complex)
      : cloud_(cloud),
        centers_(centers),
        sigmas_(sigmas),
        options_(options),
        complex_(*complex),
        walker_(walker) {}

  // All rays of one vertex. They may still be on their way afterwards.
  void Weigh(size_t point) {
    const int32_t vertex = VertexOf(point);
    const double sigma = sigmas_[vertex];
    for (const Sight& sight : cloud_.SightsOf(point)) {
      const Eigen::Vector3d to_center =
          centers_[sight.view_idx] - complex_.points[vertex].cast<double>();
      const double distance = to_center.norm();
      if (!(distance > 0)) continue;
      ++counters_.num_rays;
      const Eigen::Vector3d direction = to_center / distance;
      StartFront(vertex, sight, direction, distance, sigma);
      WeighBack(vertex, -direction, options_.sink_distance_factor * sigma, sight.support);
    }
  }

  // Walks the rays on their way to their ends.
  void Finish() {
    while (num_lanes_ > 0) StepLanes();
  }

  const VisibilityWeightCounters& counters() const { return counters_; }

 private:
  int32_t VertexOf(size_t point) const {
    if (complex_.incident_cell[point] >= 0) return static_cast<int32_t>(point);
    const std::array<int32_t, 2> key = {static_cast<int32_t>(point), -1};
    return (*std::lower_bound(complex_.duplicates.begin(), complex_.duplicates.end(), key))[1];
  }

  static constexpr size_t kNumLanes = 8;
  struct Lane {
    RayWalker::Ray ray;
    double support, falloff;  // -1 / (2 sigma^2)
    int32_t full;             // capacity of the support
    int32_t vertex;
    Eigen::Vector3d center;  // of the view
  };

  void StartFront(int32_t vertex, const Sight& sight, const Eigen::Vector3d& direction,
                  double distance, double sigma) {
    while (num_lanes_ == kNumLanes) StepLanes();
    Lane& lane = lanes_[num_lanes_];
    lane.support = sight.support;
    lane.falloff = -0.5 / (sigma * sigma);
    lane.full = ToCapacity(sight.support);
    lane.vertex = vertex;
    lane.center = centers_[sight.view_idx];
    if (walker_.Start(vertex, direction, distance, kNearSigmas * sigma, &lane.ray)) {
      ++num_lanes_;
    } else {
      EndFront(lane);
    }
  }

  // One step of each.
  void StepLanes() {
    for (size_t i = 0; i < num_lanes_;) {
      Lane& lane = lanes_[i];
      const auto cross = [&](int32_t cell, int facet, double d) {
        const int32_t weight = d < lane.ray.near
                                   ? ToCapacity(-lane.support * std::expm1(lane.falloff * d * d))
                                   : lane.full;
        AddSaturated<kShared>(&complex_.cells[cell].capacity[facet], weight);
      };
      if (walker_.Step(&lane.ray, cross)) {
        ++i;
      } else {
        EndFront(lane);
        if (i != --num_lanes_) lanes_[i] = lanes_[num_lanes_];
      }
    }
  }

  void EndFront(const Lane& lane) {
    const RayWalker::End end = walker_.EndOf(lane.ray);
    counters_.num_crossings += end.num_crossings;
    counters_.num_lost_rays += (end.cell < 0);
    if (end.cell < 0) return;
    if (!complex_.IsInfinite(end.cell)) {
      AddSaturated<kShared>(&complex_.cells[end.cell].distance, CutNode::kMaxCapacity);
    } else if (end.num_crossings > 0) {
      AddSaturated<kShared>(&complex_.cells[end.cell].distance, lane.full);
    } else {
      TieHullAround(end.cell, lane.vertex, lane.center, lane.full, &Cell::distance);
    }
  }

  // A ray that does not enter the hull speaks of the space beyond all facets of the hull at its
  // vertex that face its `target`: adds `amount` to `sum` of their cells. Goes once around the
  // vertex, from one cell at infinity to the next.
  void TieHullAround(int32_t start, int32_t vertex, const Eigen::Vector3d& target, int32_t amount,
                     int32_t Cell::*sum) {
    int32_t current = start, last = -2;  // last: the vertex that was left behind
    do {
      Cell& cell = complex_.cells[current];
      if (Faces(cell, target)) AddSaturated<kShared>(&(cell.*sum), amount);
      int side = 0;
      const auto turns = [&](int32_t v) {
        return v != Cell::kInfiniteVertex && v != vertex && (last == -2 || v == last);
      };
      while (!turns(cell.vertex[side])) ++side;
      // Crossing the facet opposite to one rim vertex keeps the other, which is left next.
      for (const int32_t v : cell.vertex) {
        if (v != Cell::kInfiniteVertex && v != vertex && v != cell.vertex[side]) {
          last = v;
          break;
        }
      }
      current = cell.neighbor[side];
    } while (current != start);
  }

  bool Faces(const Cell& cell, const Eigen::Vector3d& target) const {
    const int outside = cell.IndexOfVertex(Cell::kInfiniteVertex);
    const auto at = [&](int k) -> Eigen::Vector3d {
      return complex_.points[cell.vertex[kFacetVertices[outside][k]]].cast<double>();
    };
    const Eigen::Vector3d a = at(0);
    return (at(1) - a).cross(at(2) - a).dot(target - a) > 0;
  }

  void WeighBack(int32_t vertex, const Eigen::Vector3d& direction, double distance,
                 double support) {
    const RayWalker::End end =
        walker_.Walk(vertex, direction, distance, 0, [](int32_t, int, double) {});
    if (end.cell < 0) return;
    if (end.num_crossings == 0 && complex_.IsInfinite(end.cell)) {
      const Eigen::Vector3d target = complex_.points[vertex].cast<double>() + direction;
      TieHullAround(end.cell, vertex, target, ToCapacity(support), &Cell::excess);
    } else {
      AddSaturated<kShared>(&complex_.cells[end.cell].excess, ToCapacity(support));
    }
  }

  const MergedCloud& cloud_;
  const std::vector<Eigen::Vector3d>& centers_;
  const std::vector<float>& sigmas_;
  const VisibilityWeightOptions& options_;
  CellComplex& complex_;
  const RayWalker& walker_;
  std::array<Lane, kNumLanes> lanes_;
  size_t num_lanes_ = 0;
  VisibilityWeightCounters counters_;
};

template <bool kShared>
VisibilityWeightCounters WeighRays(const MergedCloud& cloud,
                                   const std::vector<Eigen::Vector3d>& centers,
                                   const std::vector<float>& sigmas,
                                   const VisibilityWeightOptions& options,
                                   const RunContext& context, CellComplex* complex) {
  const RayWalker walker(*complex);
  VisibilityWeightCounters total;
  std::mutex mutex;
  std::atomic<size_t> num_done = 0;
  ParallelBlocks(context, complex->points.size(), kBlock, [&](size_t begin, size_t end) {
    RayWeigher<kShared> weigher(cloud, centers, sigmas, options, walker, complex);
    for (size_t v = begin; v < end; ++v) weigher.Weigh(v);
    weigher.Finish();
    const std::scoped_lock lock(mutex);
    total.num_rays += weigher.counters().num_rays;
    total.num_crossings += weigher.counters().num_crossings;
    total.num_lost_rays += weigher.counters().num_lost_rays;
    num_done += end - begin;
    context.Report(static_cast<double>(num_done) / static_cast<double>(complex->points.size()));
  });
  return total;
}

// Cosine of the angle between facet i and the circumsphere of a tetrahedron, negative where the
// centre lies beyond the facet.
std::array<double, 4> CircumsphereCosines(const CellComplex& complex, const Cell& cell) {
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
void WeighQuality(double regularization, const RunContext& context, CellComplex* complex) {
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
void JoinTerminals(CellComplex* complex) {
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

std::vector<float> VertexSigmas(const CellComplex& complex, double distance_sigma_factor,
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

VisibilityWeightCounters WeighCells(const Scene& scene, const MergedCloud& cloud,
                                    const VisibilityWeightOptions& options,
                                    const RunContext& context, CellComplex* complex) {
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : scene.views)
    centers.push_back(cloud.frame.FromWorld(view.CenterInWorld()));
  const std::vector<float> sigmas = VertexSigmas(*complex, options.distance_sigma_factor, context);
  WeighQuality(options.quality_regularization, context, complex);
  const VisibilityWeightCounters counters =
      context.num_threads() == 1
          ? WeighRays<false>(cloud, centers, sigmas, options, context, complex)
          : WeighRays<true>(cloud, centers, sigmas, options, context, complex);
  JoinTerminals(complex);
  return counters;
}

}  // namespace lsmvs
