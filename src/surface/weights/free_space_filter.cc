#include "lsmvs/surface/weights/free_space_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/surface/tetrahedralization.h"

namespace lsmvs {

namespace {

constexpr double kCoarsening = 4;  // of the reach, from one level to the next
// In units of the reach. A point joins a vertex up to twice the reach along its ray, and is as far
// from the mean of what joined.
constexpr double kMargin = 2;
constexpr uint32_t kNoVertex = 0xFFFFFFFFu;

// The vertices as points of a cloud.
VisibilityCloud AsCloud(const MergedCloud& merged) {
  VisibilityCloud cloud;
  cloud.Reserve(merged.positions.size(), merged.sights.size());
  for (size_t v = 0; v < merged.positions.size(); ++v) {
    cloud.positions.push_back(
        merged.frame.ToWorld(merged.positions[v].cast<double>()).cast<float>());
    cloud.normals.push_back(merged.normals[v]);
    cloud.colors.push_back(merged.colors[v]);
    for (const Sight& sight : merged.SightsOf(v)) cloud.view_idxs.push_back(sight.view_idx);
    cloud.view_begin.push_back(cloud.view_idxs.size());
  }
  return cloud;
}

// One coarse level.
class Level {
 public:
  Level(const Scene& scene, const FreeSpaceFilterOptions& options, int level)
      : scene_(scene),
        options_(options),
        merging_(options.merging),
        weights_(options.weights),
        coarsening_(std::pow(kCoarsening, level)) {
    merging_.max_proj_dist *= coarsening_;
    merging_.max_depth_dist *= coarsening_;
    merging_.keep_assignment = false;
    // Thin parts are thinner than the reach, twice as soon on each further level: without more
    // weight behind them they would count as outliers.
    weights_.sink_weight *= coarsening_ * std::exp2(level - 1);
  }

  // By vertex of the cloud: whether it is to be dropped. Empty if the level has no surface.
  std::vector<uint8_t> FindOutliers(const MergedCloud& cloud, const RunContext& context) {
    coarse_ = MergePoints(scene_, AsCloud(cloud), merging_, context.Part(0, 0.4));
    complex_ = BuildDelaunay(coarse_.positions, context.Part(0.4, 0.6));
    if (complex_.cells.empty()) return {};
    WeighCells(scene_, coarse_, weights_, context.Part(0.6, 0.9), &complex_);
    MaximizeFlow(&complex_.cells, context.Part(0.9, 1), options_.cells_at_once);
    if (!FindNearestOnSurface()) return {};
    std::vector<uint8_t> is_outlier(cloud.positions.size(), 0);
    constexpr size_t kBlock = 1 << 14;
    ParallelBlocks(context, is_outlier.size(), kBlock, [&](size_t begin, size_t end) {
      int32_t cell = 0;  // neighbours in the cloud are close
      std::vector<int32_t> scratch;
      for (size_t v = begin; v < end; ++v) {
        const Eigen::Vector3d x = cloud.frame.ToWorld(cloud.positions[v].cast<double>());
        const Eigen::Vector3f in_level = coarse_.frame.FromWorld(x).cast<float>();
        cell = LocateCell(complex_, in_level, cell);
        is_outlier[v] = IsDeepInFreeSpace(complex_.cells[cell], in_level,
                                          MarginAt(x, cloud.SightsOf(v)), &scratch);
      }
    });
    return is_outlier;
  }

 private:
  // Of each coarse vertex, the vertex of a full tetrahedron that is nearest, found through
  // neighbours: all vertices nearest to the points of the line between two of them are as near.
  // False if no tetrahedron is full.
  bool FindNearestOnSurface() {
    nearest_.assign(complex_.points.size(), kNoVertex);
    bool any = false;
    for (size_t c = 0; c < complex_.num_finite_cells; ++c) {
      if (complex_.cells[c].OnSourceSide()) continue;
      any = true;
      for (const int32_t v : complex_.cells[c].vertex) {
        nearest_[static_cast<size_t>(v)] = static_cast<uint32_t>(v);
      }
    }
    while (any && SpreadNearest()) {
    }
    for (const auto& [duplicate, original] : complex_.duplicates) {
      nearest_[static_cast<size_t>(duplicate)] = nearest_[static_cast<size_t>(original)];
    }
    return any;
  }

  // Once along all edges, forth and back. Whether anything changed.
  bool SpreadNearest() {
    bool changed = false;
    for (size_t c = 0; c < complex_.num_finite_cells; ++c) changed |= SpreadIn(complex_.cells[c]);
    for (size_t c = complex_.num_finite_cells; c-- > 0;) changed |= SpreadIn(complex_.cells[c]);
    return changed;
  }

  bool SpreadIn(const Cell& cell) {
    bool changed = false;
    for (const int32_t to : cell.vertex) {
      for (const int32_t from : cell.vertex) {
        const uint32_t candidate = nearest_[static_cast<size_t>(from)];
        uint32_t& nearest = nearest_[static_cast<size_t>(to)];
        if (candidate == nearest || candidate == kNoVertex) continue;
        const Eigen::Vector3f& x = complex_.points[static_cast<size_t>(to)];
        if (!(SquaredDistance(x, candidate) < SquaredDistance(x, nearest))) continue;
        nearest = candidate;
        changed = true;
      }
    }
    return changed;
  }

  float SquaredDistance(const Eigen::Vector3f& from, uint32_t to) const {
    if (to == kNoVertex) return std::numeric_limits<float>::infinity();
    return (from - complex_.points[to]).squaredNorm();
  }

  // `cell` holds x, or sees it from infinity.
  bool IsDeepInFreeSpace(const Cell& cell, const Eigen::Vector3f& x, double margin,
                         std::vector<int32_t>* scratch) const {
    if (!cell.OnSourceSide()) return false;
    const auto is_near = [&](int32_t v) {
      return SquaredDistance(x, nearest_[static_cast<size_t>(v)]) <= margin * margin;
    };
    int32_t corner = Cell::kInfiniteVertex;
    for (const int32_t v : cell.vertex) {
      if (v == Cell::kInfiniteVertex) continue;
      if (is_near(v)) return false;
      corner = v;
    }
    return !is_near(NearestVertex(x, corner, scratch));
  }

  // Of all vertices: from neighbour to neighbour, as long as one is nearer.
  int32_t NearestVertex(const Eigen::Vector3f& x, int32_t start,
                        std::vector<int32_t>* scratch) const {
    int32_t nearest = start;
    float squared = SquaredDistance(x, static_cast<uint32_t>(nearest));
    for (int32_t center = Cell::kInfiniteVertex; center != nearest;) {
      center = nearest;
      ListCellsAround(center, scratch);
      for (const int32_t c : *scratch) {
        for (const int32_t v : complex_.cells[c].vertex) {
          if (v == Cell::kInfiniteVertex) continue;
          const float candidate = SquaredDistance(x, static_cast<uint32_t>(v));
          if (!(candidate < squared)) continue;
          squared = candidate;
          nearest = v;
        }
      }
    }
    return nearest;
  }

  void ListCellsAround(int32_t vertex, std::vector<int32_t>* cells) const {
    cells->assign(1, complex_.incident_cell[static_cast<size_t>(vertex)]);
    for (size_t i = 0; i < cells->size(); ++i) {
      const Cell& cell = complex_.cells[(*cells)[i]];
      for (int k = 0; k < 4; ++k) {
        const int32_t next = cell.neighbor[k];
        if (cell.vertex[k] == vertex) continue;
        if (std::find(cells->begin(), cells->end(), next) == cells->end()) cells->push_back(next);
      }
    }
  }

  // Canonical: up to where the surface counts as near to x, by the view that sees x finest.
  double MarginAt(const Eigen::Vector3d& x, std::span<const Sight> sights) const {
    double finest = std::numeric_limits<double>::infinity();
    for (const Sight& sight : sights) {
      const View& view = scene_.views[sight.view_idx];
      finest = std::min(finest, view.Depth(x) / view.camera.MeanFocalLength());
    }
    return kMargin * merging_.max_proj_dist * finest / coarse_.frame.world_per_unit;
  }

  const Scene& scene_;
  const FreeSpaceFilterOptions& options_;
  PointMergingOptions merging_;
  VisibilityWeightOptions weights_;
  const double coarsening_;
  MergedCloud coarse_;
  Tetrahedralization complex_;
  std::vector<uint32_t> nearest_;
};

// Keeps the vertices that are not dropped, in their order.
void DropVertices(const std::vector<uint8_t>& dropped, MergedCloud* cloud) {
  std::vector<uint32_t> new_index(dropped.size(), MergedCloud::kIgnoredPoint);
  size_t num_kept = 0;
  uint64_t num_sights = 0;
  for (size_t v = 0; v < dropped.size(); ++v) {
    const uint64_t begin = cloud->sight_begin[v], end = cloud->sight_begin[v + 1];
    if (dropped[v]) continue;
    new_index[v] = static_cast<uint32_t>(num_kept);
    cloud->positions[num_kept] = cloud->positions[v];
    cloud->normals[num_kept] = cloud->normals[v];
    cloud->colors[num_kept] = cloud->colors[v];
    // Not read any more: v is at least as large.
    cloud->sight_begin[num_kept++] = num_sights;
    for (uint64_t s = begin; s < end; ++s) cloud->sights[num_sights++] = cloud->sights[s];
  }
  cloud->positions.resize(num_kept);
  cloud->normals.resize(num_kept);
  cloud->colors.resize(num_kept);
  cloud->sight_begin.resize(num_kept + 1);
  cloud->sight_begin.back() = num_sights;
  cloud->sights.resize(num_sights);
  for (uint32_t& vertex : cloud->vertex_of_point) {
    if (vertex != MergedCloud::kIgnoredPoint) vertex = new_index[vertex];
  }
}

}  // namespace

size_t FilterFreeSpace(const Scene& scene, const FreeSpaceFilterOptions& options,
                       const RunContext& context, MergedCloud* cloud) {
  const size_t num_before = cloud->positions.size();
  // Without a reach there are no levels.
  const int num_levels = options.merging.max_proj_dist > 0 ? options.num_levels : 0;
  for (int level = num_levels; level > 0; --level) {
    const double begin = 1 - static_cast<double>(level) / num_levels;
    const std::vector<uint8_t> is_outlier =
        Level(scene, options, level)
            .FindOutliers(*cloud, context.Part(begin, begin + 1.0 / num_levels));
    if (!is_outlier.empty()) DropVertices(is_outlier, cloud);
  }
  const size_t num_dropped = num_before - cloud->positions.size();
  cloud->num_filtered_vertices += num_dropped;
  return num_dropped;
}

}  // namespace lsmvs
