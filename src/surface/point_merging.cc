#include "lsmvs/surface/point_merging.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/surface/points/point_grid.h"
#include "lsmvs/surface/points/point_order.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

constexpr size_t kBlock = 1 << 14;
constexpr int kMaxLevel = 20;
constexpr int kMaxRank = 31;
constexpr float kDepthStretch = 2.0f;  // joining distance along the ray over that across

// How near another point must be to join.
struct Reach {
  float across = 0, along = 0;  // canonical
  Eigen::Vector3f ray;          // unit, from the view that sees the point finest
};

// Coordinates of the finite points whose position has a hash of at most max_hash.
std::array<std::vector<float>, 3> AxesUpTo(uint64_t max_hash, const VisibilityCloud& cloud) {
  std::array<std::vector<float>, 3> axes;
  for (const Eigen::Vector3f& x : cloud.positions) {
    if (!x.allFinite() || HashOfPosition(x) > max_hash) continue;
    for (int k = 0; k < 3; ++k) axes[k].push_back(x[k]);
  }
  return axes;
}

// Coordinates of all points of small clouds; of about 100,000 of large ones, which do not depend on
// the order of the cloud.
std::array<std::vector<float>, 3> SampleAxes(const VisibilityCloud& cloud) {
  constexpr size_t kMaxSample = 100000;
  constexpr uint64_t kAll = ~uint64_t{0};
  auto axes = AxesUpTo(kAll / (cloud.size() / kMaxSample + 1), cloud);
  return axes[0].empty() ? AxesUpTo(kAll, cloud) : axes;  // few positions, of many points each
}

CanonicalFrame FindFrame(const VisibilityCloud& cloud) {
  std::array<std::vector<float>, 3> axes = SampleAxes(cloud);
  CanonicalFrame frame;
  if (axes[0].empty()) return frame;
  for (int k = 0; k < 3; ++k) {
    frame.origin[k] = Median(&axes[k]);
  }
  std::vector<double> distances;
  for (size_t i = 0; i < axes[0].size(); ++i) {
    // The axes were permuted: take the distances along each.
    for (int k = 0; k < 3; ++k) distances.push_back(std::abs(axes[k][i] - frame.origin[k]));
  }
  const double high = ValueOfRank(&distances, distances.size() * 9 / 10);
  if (high > 0) frame.world_per_unit = std::exp2(std::ceil(std::log2(high)) + 1);
  return frame;
}

// Joins points one after the other.
class Merger {
 public:
  static constexpr uint32_t kIgnored = MergedCloud::kIgnoredPoint;

  Merger(const Scene& scene, const VisibilityCloud& cloud, const PointMergingOptions& options,
         const RunContext& context)
      : scene_(scene),
        cloud_(cloud),
        options_(options),
        context_(context),
        point_order_(scene, cloud) {
    result_.frame = FindFrame(cloud);
    for (size_t n = 0; n < support_of_.size(); ++n) {
      support_of_[n] = static_cast<float>(ViewConfidence(n, options_.visibility_sigma));
    }
  }

  MergedCloud Run() {
    MeasureAll();
    AssignAll();
    SortVertices();
    GatherSights();
    return std::move(result_);
  }

 private:
  Eigen::Vector3f Canonical(size_t p) const {
    return result_.frame.FromWorld(cloud_.positions[p].cast<double>()).cast<float>();
  }

  void MeasureAll() {
    across_.resize(cloud_.size());
    ParallelFor(context_, cloud_.size(), kBlock, [&](size_t p) {
      const FinestView finest = FindFinestView(scene_, cloud_, p);
      across_[p] = finest.view_idx == FinestView::kNone ? -1.0f : Across(finest);
    });
  }

  float Across(const FinestView& finest) const {
    return static_cast<float>(options_.max_proj_dist * finest.pixel_size /
                              result_.frame.world_per_unit);
  }

  // Measured again for each point as it joins: kept, it would be much of the memory.
  Reach ReachOf(uint32_t p) const {
    const FinestView finest = FindFinestView(scene_, cloud_, p);
    const Eigen::Vector3d x = cloud_.positions[p].cast<double>();
    const float across = Across(finest);
    const auto deepest =
        static_cast<float>(options_.max_depth_dist * finest.depth / result_.frame.world_per_unit);
    return {across, std::min(kDepthStretch * across, deepest),
            (x - scene_.views[finest.view_idx].CenterInWorld()).normalized().cast<float>()};
  }

  double MedianReach() const {
    std::vector<float> values;
    for (const float across : across_) {
      if (across > 0) values.push_back(across);
    }
    if (values.empty()) return 0;
    return Median(&values);
  }

  // Points by level (octaves of the reach over its median), many views first, then along the views.
  std::vector<uint32_t> JoiningOrder(double median, std::vector<size_t>* level_begin) {
    constexpr int kNumKeys = (2 * kMaxLevel + 1) * (kMaxRank + 1);
    const auto key = [&](size_t p) {
      const double octave = median > 0 ? std::floor(std::log2(across_[p] / median)) : 0;
      const int level =
          static_cast<int>(std::clamp<double>(octave, -kMaxLevel, kMaxLevel)) + kMaxLevel;
      const int views = static_cast<int>(std::min<size_t>(kMaxRank, cloud_.ViewsOf(p).size()));
      return level * (kMaxRank + 1) + kMaxRank - views;
    };
    std::vector<size_t> begin(kNumKeys + 1, 0);
    for (size_t p = 0; p < cloud_.size(); ++p) {
      if (across_[p] >= 0) ++begin[key(p) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    level_begin->clear();
    for (int level = 0; level <= 2 * kMaxLevel + 1; ++level) {
      level_begin->push_back(begin[level * (kMaxRank + 1)]);
    }
    std::vector<uint32_t> order(begin.back());
    std::vector<size_t> end = begin;
    for (size_t p = 0; p < cloud_.size(); ++p) {
      if (across_[p] >= 0) order[end[key(p)]++] = static_cast<uint32_t>(p);
    }
    for (size_t i = 0; i + 1 < begin.size(); ++i) {
      point_order_.SortAlongViews(context_, std::span(order).subspan(begin[i], end[i] - begin[i]));
    }
    result_.num_ignored_points = cloud_.size() - order.size();
    return order;
  }

  void AssignAll() {
    const double median = MedianReach();
    std::vector<size_t> level_begin;
    const std::vector<uint32_t> order = JoiningOrder(median, &level_begin);
    std::vector<float>().swap(across_);
    assignment_.assign(cloud_.size(), kIgnored);
    for (int level = 0; level <= 2 * kMaxLevel; ++level) {
      if (level_begin[level] == level_begin[level + 1]) continue;
      context_.ThrowIfCancelled();
      const float upper = static_cast<float>(median * std::exp2(level - kMaxLevel + 1));
      PointGrid grid(kDepthStretch * upper, &seeds_);
      grid.InsertThinned(upper / 4);
      for (size_t i = level_begin[level]; i < level_begin[level + 1]; ++i) {
        if (i + kAhead < order.size()) Prefetch(order[i + kAhead]);
        Assign(order[i], &grid);
        if (i % kBlock == 0) ReportAssigned(i, order.size());
      }
    }
  }

  // Asks for the memory of a point that is looked at soon.
  static constexpr size_t kAhead = 8;
  void Prefetch(uint32_t p) const {
    __builtin_prefetch(&cloud_.positions[p]);
    __builtin_prefetch(&cloud_.normals[p]);
    __builtin_prefetch(&cloud_.view_begin[p]);
  }

  void ReportAssigned(size_t count, size_t all) const {
    constexpr double kBegin = 0.2, kEnd = 0.8;  // of the time
    context_.ThrowIfCancelled();
    context_.Report(kBegin +
                    (kEnd - kBegin) * static_cast<double>(count) / static_cast<double>(all));
  }

  // Squared distance in units of the reach; above 1 they do not join.
  float Separation(uint32_t p, const Reach& reach, const Eigen::Vector3f& x,
                   uint32_t vertex) const {
    const Eigen::Vector3f offset = seeds_[vertex] - x;
    const float along = offset.dot(reach.ray);
    const float across_squared = std::max(0.0f, offset.squaredNorm() - along * along);
    const float separation = across_squared / (reach.across * reach.across) +
                             along * along / (reach.along * reach.along);
    if (!(separation <= 1)) return offset.isZero(0.0f) ? 0.0f : 2.0f;
    if (cloud_.normals[p].dot(cloud_.normals[seed_points_[vertex]]) < 0) return 2.0f;
    return separation;
  }

  void Assign(uint32_t p, PointGrid* grid) {
    const Eigen::Vector3f x = Canonical(p);
    float best = 1;
    uint32_t best_vertex = kIgnored;
    const Reach reach = ReachOf(p);
    const float radius = std::max(reach.across, reach.along);
    grid->ForEachNear(x, radius, [&](uint32_t vertex) {
      const float separation = Separation(p, reach, x, vertex);
      if (separation < best || (separation == best && vertex < best_vertex)) {
        best = separation;
        best_vertex = vertex;
      }
    });
    if (best_vertex == kIgnored) {
      best_vertex = static_cast<uint32_t>(seeds_.size());
      seeds_.push_back(x);
      seed_points_.push_back(p);
      grid->Insert(best_vertex);
    }
    assignment_[p] = best_vertex;
  }

  void SortVertices() {
    std::vector<uint32_t>().swap(seed_points_);
    const std::vector<uint32_t> order = HilbertOrder(seeds_);
    std::vector<uint32_t> position(order.size());
    std::vector<Eigen::Vector3f> seeds(order.size());
    for (size_t i = 0; i < order.size(); ++i) {
      position[order[i]] = static_cast<uint32_t>(i);
      seeds[i] = seeds_[order[i]];
    }
    seeds_.swap(seeds);
    for (uint32_t& vertex : assignment_) {
      if (vertex != kIgnored) vertex = position[vertex];
    }
  }

  // Points grouped by their vertex.
  std::vector<uint32_t> GroupMembers(std::vector<uint32_t>* begin) const {
    begin->assign(seeds_.size() + 2, 0);
    for (const uint32_t vertex : assignment_) {
      if (vertex != kIgnored) ++(*begin)[vertex + 2];
    }
    std::partial_sum(begin->begin(), begin->end(), begin->begin());
    std::vector<uint32_t> members(begin->back());
    for (size_t p = 0; p < assignment_.size(); ++p) {
      if (assignment_[p] != kIgnored)
        members[(*begin)[assignment_[p] + 1]++] = static_cast<uint32_t>(p);
    }
    begin->pop_back();
    // What is summed up over a vertex has the same order whatever the order of the cloud.
    ParallelFor(context_, seeds_.size(), kBlock / 4, [&](size_t v) {
      std::sort(members.data() + (*begin)[v], members.data() + (*begin)[v + 1],
                [&](uint32_t a, uint32_t b) { return point_order_.Less(a, b); });
    });
    return members;
  }

  void GatherSights() {
    std::vector<uint32_t> begin;
    const std::vector<uint32_t> members = GroupMembers(&begin);
    if (options_.keep_assignment) result_.vertex_of_point = std::move(assignment_);
    std::vector<uint32_t>().swap(assignment_);
    result_.positions.resize(seeds_.size());
    result_.normals.resize(seeds_.size());
    result_.colors.resize(seeds_.size());
    result_.sight_begin.assign(seeds_.size() + 1, 0);
    // Calls body(v, points, sights of v) for all vertices.
    const auto for_each_vertex = [&](const auto& body) {
      ParallelBlocks(context_, seeds_.size(), kBlock / 4, [&](size_t first, size_t last) {
        std::vector<Sight> sights;
        SupportSums sums(scene_.views.size());
        for (size_t v = first; v < last; ++v) {
          for (size_t i = begin[v] + kAhead; i < begin[v + 1] + kAhead && i < members.size(); ++i) {
            Prefetch(members[i]);
          }
          const std::span<const uint32_t> points(members.data() + begin[v],
                                                 members.data() + begin[v + 1]);
          ListSights(points, &sums, &sights);
          body(v, points, sights);
        }
      });
    };
    // Counted first: an array that grows takes twice the memory.
    for_each_vertex([&](size_t v, std::span<const uint32_t> points, const auto& sights) {
      Average(v, points);
      result_.sight_begin[v + 1] = sights.size();
    });
    std::partial_sum(result_.sight_begin.begin(), result_.sight_begin.end(),
                     result_.sight_begin.begin());
    result_.sights.resize(result_.sight_begin.back());
    for_each_vertex([&](size_t v, std::span<const uint32_t>, const auto& sights) {
      std::copy(sights.begin(), sights.end(),
                result_.sights.begin() + static_cast<std::ptrdiff_t>(result_.sight_begin[v]));
    });
  }

  void Average(size_t v, std::span<const uint32_t> points) {
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    double sum = 0;
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    Eigen::Vector3i color = Eigen::Vector3i::Zero();
    for (const uint32_t p : points) {
      const auto weight = static_cast<double>(cloud_.ViewsOf(p).size());
      sum += weight;
      offset += weight * (Canonical(p) - seeds_[v]).cast<double>();
      normal += static_cast<float>(weight) * cloud_.normals[p];
      color += cloud_.colors[p].cast<int>();
    }
    const double count = static_cast<double>(points.size());
    result_.positions[v] = (seeds_[v].cast<double>() + offset / sum).cast<float>();
    if (normal.squaredNorm() > 0) normal.normalize();
    result_.normals[v] = normal.allFinite() ? normal : Eigen::Vector3f::Zero();
    const Eigen::Vector3d mean = color.cast<double>() / count + Eigen::Vector3d::Constant(0.5);
    result_.colors[v] = mean.cast<uint8_t>();
  }

  // Sums of the support that points give a vertex, by view.
  class SupportSums {
   public:
    explicit SupportSums(size_t num_views) : sums_(num_views, kNone) {}

    void Add(uint32_t view_idx, float support) {
      float& sum = sums_[view_idx];
      if (sum == kNone) {
        views_.push_back(view_idx);
        sum = 0;
      }
      sum += support;
    }
    // Ascending views; starts anew.
    void Take(std::vector<Sight>* sights) {
      sights->clear();
      std::sort(views_.begin(), views_.end());
      for (const uint32_t view_idx : views_) {
        sights->push_back({view_idx, std::exchange(sums_[view_idx], kNone)});
      }
      views_.clear();
    }

   private:
    static constexpr float kNone = -1;
    std::vector<float> sums_;
    std::vector<uint32_t> views_;
  };

  void ListSights(std::span<const uint32_t> points, SupportSums* sums,
                  std::vector<Sight>* sights) const {
    for (const uint32_t p : points) {
      const auto views = cloud_.ViewsOf(p);
      const float support = SupportOf(views.size());
      const Eigen::Vector3d x = cloud_.positions[p].cast<double>();
      for (const uint32_t view_idx : views) {
        if (scene_.views[view_idx].Depth(x) > 0) sums->Add(view_idx, support);
      }
    }
    sums->Take(sights);
  }

  float SupportOf(size_t num_views) const {
    if (num_views < support_of_.size()) return support_of_[num_views];
    return static_cast<float>(ViewConfidence(num_views, options_.visibility_sigma));
  }

  const Scene& scene_;
  const VisibilityCloud& cloud_;
  const PointMergingOptions options_;
  const RunContext& context_;
  const PointOrder point_order_;
  std::array<float, 64> support_of_;  // by number of views
  MergedCloud result_;
  std::vector<float>
      across_;  // until all are put in order: Reach::across of each point; < 0: it is ignored
  std::vector<uint32_t> assignment_;    // point -> vertex
  std::vector<Eigen::Vector3f> seeds_;  // by vertex: position of the point that the others joined
  std::vector<uint32_t> seed_points_;   // until vertices are sorted: that point
};

}  // namespace

MergedCloud MergePoints(const Scene& scene, const VisibilityCloud& cloud,
                        const PointMergingOptions& options, const RunContext& context) {
  return Merger(scene, cloud, options, context).Run();
}

}  // namespace lsmvs
