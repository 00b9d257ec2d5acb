#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Where the mesher computes: shifted to the middle of the points and scaled by a power of two to
// about unit size, so that floats resolve the surface whatever the scene's unit and origin.
struct CanonicalFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // in the world
  double world_per_unit = 1;                         // a power of two

  Eigen::Vector3d FromWorld(const Eigen::Vector3d& x) const {
    return (x - origin) / world_per_unit;
  }
  Eigen::Vector3d ToWorld(const Eigen::Vector3d& x) const { return x * world_per_unit + origin; }
};

struct PointMergingOptions {
  // Points closer than this in their views become one vertex that keeps all their views. Pixels; 0
  // merges exact duplicates only. Raising it makes a smaller, smoother mesh faster.
  double max_proj_dist = 2.2;
  // Points merge only if their depths differ by less than this fraction. Raising it merges more
  // along the viewing rays.
  double max_depth_dist = 0.01;
  // A point seen by n views counts 1 - exp(-n^2 / (2 visibility_sigma^2)): raising it trusts points
  // with few views less.
  double visibility_sigma = 3.0;
  // Also tell which vertex each point became. 4 bytes per point.
  bool keep_assignment = false;
};

// How much a point counts that so many views see, 0 to 1.
inline double ViewConfidence(size_t num_views, double visibility_sigma) {
  const double n = static_cast<double>(num_views) / visibility_sigma;
  return -std::expm1(-0.5 * n * n);
}

// One view's sight of a vertex.
struct Sight {
  uint32_t view_idx = 0;
  float support = 0;  // sum over the points behind it of ViewConfidence(views of the point)
};

// The vertices-to-be, in spatial order.
struct MergedCloud {
  CanonicalFrame frame;
  std::vector<Eigen::Vector3f>
      positions;                         // #V, canonical: mean of the merged points, by their views
  std::vector<Eigen::Vector3f> normals;  // #V, unit mean of the merged points; zero if unknown
  std::vector<Color> colors;             // #V, mean of the merged points
  std::vector<uint64_t> sight_begin;     // #V + 1
  std::vector<Sight> sights;             // ascending view_idx within a vertex
  size_t num_ignored_points = 0;         // not finite, or before none of their views
  size_t num_filtered_vertices = 0;      // that FilterFreeSpace dropped
  // With keep_assignment, by point of the cloud: the vertex that it became or joined, if that is
  // there.
  static constexpr uint32_t kIgnoredPoint = 0xFFFFFFFFu;
  std::vector<uint32_t> vertex_of_point;

  std::span<const Sight> SightsOf(size_t v) const {
    return {sights.data() + sight_begin[v], sights.data() + sight_begin[v + 1]};
  }
};

// Thins the cloud to about one point for each max_proj_dist pixels of surface. Points are taken
// finest view first, then by number of views, then by place in their finest view, which makes the
// result a function of the points, whatever their order: a point joins the vertex that is
// nearest in units of the joining distances if it lies within max_proj_dist pixels of it across the
// viewing ray and within twice that, and max_depth_dist of the depth, along it, and their normals
// (where known) do not oppose; else it becomes a vertex. Independent of the world frame. O(n).
MergedCloud MergePoints(const Scene& scene, const VisibilityCloud& cloud,
                        const PointMergingOptions& options, const RunContext& context);

}  // namespace lsmvs
