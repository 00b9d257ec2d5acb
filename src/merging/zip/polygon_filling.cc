#include "lsmvs/merging/zip/polygon_filling.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace lsmvs {

namespace {

// How much a triangle costs that is turned over, in its squared sides.
constexpr double kTurnedCost = 20;
// Triangles may be turned from the normals by this cosine at no cost.
constexpr double kFreeCosine = 0.6;

class PolygonFiller {
 public:
  PolygonFiller(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3d> normals,
                const std::vector<int32_t>& polygon,
                const std::function<bool(int32_t, int32_t)>& may_join)
      : vertices_(vertices),
        normals_(normals),
        polygon_(polygon),
        n_(polygon.size()),
        cost_(n_ * n_, std::numeric_limits<double>::infinity()),
        apex_(n_ * n_, -1),
        may_join_(may_join) {}

  std::vector<Eigen::Vector3i> Run() {
    for (size_t i = 0; i + 1 < n_; ++i) cost_[i * n_ + i + 1] = 0;
    for (size_t gap = 2; gap < n_; ++gap) {
      for (size_t i = 0; i + gap < n_; ++i) Solve(i, i + gap);
    }
    std::vector<Eigen::Vector3i> faces;
    if (cost_[n_ - 1] < std::numeric_limits<double>::infinity()) Collect(0, n_ - 1, &faces);
    return faces;
  }

 private:
  const Eigen::Vector3d& At(size_t i) const { return vertices_[static_cast<size_t>(polygon_[i])]; }
  const Eigen::Vector3d& NormalAt(size_t i) const {
    return normals_[static_cast<size_t>(polygon_[i])];
  }

  double Cost(size_t i, size_t k, size_t j) const {
    const Eigen::Vector3d ab = At(k) - At(i), ac = At(j) - At(i);
    const double sides = ab.squaredNorm() + ac.squaredNorm() + (ac - ab).squaredNorm();
    const Eigen::Vector3d normal = ab.cross(ac);
    const double twice_area = normal.norm();
    if (!(twice_area > 1e-9 * sides)) return (1 + 2 * kTurnedCost) * sides;
    const Eigen::Vector3d expected = NormalAt(i) + NormalAt(k) + NormalAt(j);
    const double cosine = normal.dot(expected) / (twice_area * std::max(expected.norm(), 1e-9));
    return sides * (1 + kTurnedCost * std::max(0.0, kFreeCosine - cosine));
  }

  void Solve(size_t i, size_t j) {
    const bool is_side = i == 0 && j + 1 == n_;
    if (!is_side && !may_join_(polygon_[i], polygon_[j])) return;
    double& best = cost_[i * n_ + j];
    for (size_t k = i + 1; k < j; ++k) {
      const double parts = cost_[i * n_ + k] + cost_[k * n_ + j];
      if (parts >= best) continue;
      const double cost = parts + Cost(i, k, j);
      if (cost >= best) continue;
      best = cost;
      apex_[i * n_ + j] = static_cast<int32_t>(k);
    }
  }

  void Collect(size_t i, size_t j, std::vector<Eigen::Vector3i>* faces) const {
    if (j == i + 1) return;
    const auto k = static_cast<size_t>(apex_[i * n_ + j]);
    faces->emplace_back(polygon_[i], polygon_[k], polygon_[j]);
    Collect(i, k, faces);
    Collect(k, j, faces);
  }

  std::span<const Eigen::Vector3d> vertices_, normals_;
  const std::vector<int32_t>& polygon_;
  size_t n_;
  std::vector<double> cost_;  // of the best triangulation between positions i < j
  std::vector<int32_t> apex_;
  const std::function<bool(int32_t, int32_t)>& may_join_;
};

}  // namespace

std::vector<Eigen::Vector3i> FillPolygon(std::span<const Eigen::Vector3d> vertices,
                                         std::span<const Eigen::Vector3d> normals,
                                         const std::vector<int32_t>& polygon,
                                         const std::function<bool(int32_t, int32_t)>& may_join) {
  if (polygon.size() < 3) return {};
  return PolygonFiller(vertices, normals, polygon, may_join).Run();
}

}  // namespace lsmvs
