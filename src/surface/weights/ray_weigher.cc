#include "lsmvs/surface/weights/ray_weigher.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <tuple>
#include <vector>

#include "lsmvs/surface/weights/joined_paths.h"
#include "lsmvs/surface/weights/ray_walk.h"
#include "lsmvs/surface/weights/saturated_sum.h"

namespace lsmvs {

namespace {

using internal::AddSaturated;
using internal::JoinedPaths;

constexpr double kNearSigmas = 4;  // beyond, a facet's weight is that of the ray up to 3e-4
constexpr size_t kBlock = 4096;    // points; their cells fit the cache

// 1 - exp(-x^2 / 2) from a table, with linear interpolation in x^2; error below 1e-5.
class NearWeight {
 public:
  NearWeight() {
    for (size_t i = 0; i < values_.size(); ++i) {
      values_[i] = static_cast<float>(-std::expm1(-0.5 * static_cast<double>(i) / kPerUnit));
    }
  }
  // For squared < kNearSigmas^2.
  float operator()(float squared) const {
    const float position = squared * kPerUnit;
    const auto i = static_cast<size_t>(position);
    return values_[i] + (position - static_cast<float>(i)) * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr int kPerUnit = 64;
  std::array<float, static_cast<size_t>(kNearSigmas* kNearSigmas) * kPerUnit + 2> values_;
};

template <bool kShared>
class RayWeigher {
 public:
  RayWeigher(const MergedCloud& cloud, const RayWeights& weights, const RayWalker& walker,
             Tetrahedralization* complex)
      : cloud_(cloud),
        weights_(weights),
        complex_(*complex),
        walker_(walker),
        paths_(complex->cells.size()) {}

  // All rays of points [begin, end), view by view.
  RayCounters Weigh(size_t begin, size_t end) {
    counters_ = {};
    ListSights(begin, end);
    for (size_t i = 0; i < sights_.size();) {
      const size_t first = i;
      while (i < sights_.size() && sights_[i].view_idx == sights_[first].view_idx) ++i;
      WeighView(std::span(sights_).subspan(first, i - first));
    }
    return counters_;
  }

 private:
  struct PointSight {
    uint32_t view_idx, point;
    float support;
  };

  void ListSights(size_t begin, size_t end) {
    sights_.clear();
    for (size_t p = begin; p < end; ++p) {
      for (const Sight& sight : cloud_.SightsOf(p)) {
        sights_.push_back({sight.view_idx, static_cast<uint32_t>(p), sight.support});
      }
    }
    std::sort(sights_.begin(), sights_.end(), [](const PointSight& a, const PointSight& b) {
      return std::tie(a.view_idx, a.point) < std::tie(b.view_idx, b.point);
    });
  }

  void WeighView(std::span<const PointSight> sights) {
    center_ = weights_.centers[sights.front().view_idx];
    constexpr size_t kAhead = 6;
    for (size_t i = 0; i < sights.size(); ++i) {
      if (i + kAhead < sights.size()) {
        walker_.Prefetch(static_cast<int32_t>(sights[i + kAhead].point));
      }
      StartRays(sights[i]);
    }
    while (num_lanes_ > 0) StepLanes();
    paths_.Carry(
        [&](int32_t cell, int facet, int32_t weight) {
          const Cell& entered = complex_.cells[cell];
          Cell& left = complex_.cells[entered.neighbor[facet]];
          AddSaturated<kShared>(&left.capacity[entered.Reverse(facet)], weight);
        },
        [&](int32_t cell) { EndFront(cell, 0); });
  }

  // Several rays, stepped in turn, hide each other's memory latency.
  static constexpr size_t kNumLanes = 8;
  struct Lane {
    RayWalker::Ray ray;
    float inverse_squared_sigma;
    int32_t full;  // capacity of the support
    int32_t last;  // capacity of the facet crossed last
    int32_t vertex;
  };

  int32_t VertexOf(size_t point) const {
    if (complex_.incident_cell[point] >= 0) return static_cast<int32_t>(point);
    const std::array<int32_t, 2> key = {static_cast<int32_t>(point), -1};
    return (*std::lower_bound(complex_.duplicates.begin(), complex_.duplicates.end(), key))[1];
  }

  // To the view and from it.
  void StartRays(const PointSight& sight) {
    const int32_t vertex = VertexOf(sight.point);
    const Eigen::Vector3d to_center = center_ - complex_.points[vertex].cast<double>();
    const double distance = to_center.norm();
    if (!(distance > 0)) return;
    ++counters_.num_rays;
    StartFront(vertex, to_center / distance, distance, sight.support);
    WeighBack(vertex, -to_center / distance, sight.support);
  }

  void StartFront(int32_t vertex, const Eigen::Vector3d& direction, double distance,
                  double support) {
    while (num_lanes_ == kNumLanes) StepLanes();
    Lane& lane = lanes_[num_lanes_];
    const float sigma = weights_.sigmas[vertex];
    lane.inverse_squared_sigma = 1 / (sigma * sigma);
    lane.full = ToCapacity(support);
    lane.last = 0;
    lane.vertex = vertex;
    if (walker_.Start(vertex, direction, distance, kNearSigmas * sigma, &lane.ray)) {
      ++num_lanes_;
    } else {
      EndLane(lane);
    }
  }

  // One step of each.
  void StepLanes() {
    for (size_t i = 0; i < num_lanes_;) {
      if (StepNear(&lanes_[i])) {
        ++i;
      } else if (i != --num_lanes_) {
        lanes_[i] = lanes_[num_lanes_];
      }
    }
  }

  // False if the ray is done.
  bool StepNear(Lane* lane) {
    RayWalker::Ray& ray = lane->ray;
    int32_t far_cell = -1;
    int far_facet = 0;
    const bool going = walker_.Step(&ray, [&](int32_t cell, int facet, double distance) {
      const auto d = static_cast<float>(distance);
      Cell& left = complex_.cells[ray.current];
      int32_t weight = lane->full;
      if (d < ray.near) {
        const float share = near_weight_(d * d * lane->inverse_squared_sigma);
        const float rounded = share * static_cast<float>(lane->full) + 0.5f;
        weight = std::max(lane->last, static_cast<int32_t>(rounded));
        AddSaturated<kShared>(&left.capacity[ray.exit], weight);
      } else {
        far_cell = cell;
        far_facet = facet;
      }
      if (weight > lane->last) AddSaturated<kShared>(&left.distance, weight - lane->last);
      lane->last = weight;
    });
    if (far_cell >= 0) {
      WalkFar(lane, far_cell, far_facet, going);
      return false;
    }
    if (!going) EndLane(*lane);
    return going;
  }

  // The rest of the way of a ray that just entered `cell` through its facet `facet`.
  void WalkFar(Lane* lane, int32_t cell, int facet, bool going) {
    if (lane->full <= 0) return;
    paths_.Begin(lane->full);
    bool alone = paths_.Enter(cell, facet);
    while (alone && going) {
      going = walker_.Step(&lane->ray, [&](int32_t next_cell, int next_facet, double) {
        alone = paths_.Enter(next_cell, next_facet);
      });
    }
    counters_.num_crossings += walker_.EndOf(lane->ray).num_crossings;
  }

  // Of a ray that did not get far.
  void EndLane(const Lane& lane) {
    const RayWalker::End end = walker_.EndOf(lane.ray);
    counters_.num_crossings += end.num_crossings;
    counters_.num_lost_rays += (end.cell < 0);
    if (end.cell < 0) return;
    if (complex_.IsInfinite(end.cell) && end.num_crossings == 0) {
      TieHullAround(end.cell, lane.vertex, center_, lane.full, &Cell::distance);
    } else {
      EndFront(end.cell, lane.full - lane.last);
    }
  }

  // Ties the cell that holds the view, or with `weight` that where a ray leaves the hull.
  void EndFront(int32_t cell, int32_t weight) {
    AddSaturated<kShared>(&complex_.cells[cell].distance,
                          complex_.IsInfinite(cell) ? weight : CutNode::kMaxCapacity);
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

  void WeighBack(int32_t vertex, const Eigen::Vector3d& direction, double support) {
    const double distance = weights_.sink_distance_factor * weights_.sigmas[vertex];
    const RayWalker::End end =
        walker_.Walk(vertex, direction, distance, 0, [](int32_t, int, double) {});
    if (end.cell < 0) return;
    const int32_t weight = ToCapacity(weights_.sink_weight * support);
    if (end.num_crossings == 0 && complex_.IsInfinite(end.cell)) {
      const Eigen::Vector3d target = complex_.points[vertex].cast<double>() + direction;
      TieHullAround(end.cell, vertex, target, weight, &Cell::excess);
    } else {
      AddSaturated<kShared>(&complex_.cells[end.cell].excess, weight);
    }
  }

  const MergedCloud& cloud_;
  const RayWeights& weights_;
  Tetrahedralization& complex_;
  const RayWalker& walker_;
  const NearWeight near_weight_;
  std::vector<PointSight> sights_;  // of the block
  Eigen::Vector3d center_;
  std::array<Lane, kNumLanes> lanes_;
  size_t num_lanes_ = 0;
  JoinedPaths paths_;
  RayCounters counters_;
};

// Workers that wait for a block: no more than there are threads.
template <class Worker>
class WorkerPool {
 public:
  template <class Make>
  std::unique_ptr<Worker> Take(const Make& make) {
    {
      const std::scoped_lock lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<Worker> worker = std::move(idle_.back());
        idle_.pop_back();
        return worker;
      }
    }
    return make();
  }
  void Return(std::unique_ptr<Worker> worker, const RayCounters& counters) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(worker));
    total_.Add(counters);
  }
  const RayCounters& total() const { return total_; }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Worker>> idle_;
  RayCounters total_;
};

template <bool kShared>
RayCounters WeighBlocks(const MergedCloud& cloud, const RayWeights& weights,
                        const RunContext& context, Tetrahedralization* complex) {
  using Worker = RayWeigher<kShared>;
  const RayWalker walker(*complex);
  const size_t num_points = complex->points.size();
  WorkerPool<Worker> pool;
  std::atomic<size_t> num_done = 0;
  ParallelBlocks(context, num_points, kBlock, [&](size_t begin, size_t end) {
    auto worker =
        pool.Take([&] { return std::make_unique<Worker>(cloud, weights, walker, complex); });
    const RayCounters counters = worker->Weigh(begin, end);
    pool.Return(std::move(worker), counters);
    num_done += end - begin;
    context.Report(static_cast<double>(num_done) / static_cast<double>(num_points));
  });
  return pool.total();
}

}  // namespace

RayCounters WeighRays(const MergedCloud& cloud, const RayWeights& weights,
                      const RunContext& context, Tetrahedralization* complex) {
  return context.num_threads() == 1 ? WeighBlocks<false>(cloud, weights, context, complex)
                                    : WeighBlocks<true>(cloud, weights, context, complex);
}

}  // namespace lsmvs
