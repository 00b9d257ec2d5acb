#include "lsmvs/evaluation/samples/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

namespace lsmvs {

namespace {

// Mixes a counter to 64 random bits (splitmix64): the i-th number needs no state, so that points
// can be drawn in any order.
uint64_t Mix(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// Uniform in [0, 1).
double Uniform(uint64_t seed, uint64_t index) {
  return static_cast<double>(Mix(Mix(seed) ^ index) >> 11) * 0x1.0p-53;
}

// Sum of the areas of the faces up to and including each.
std::vector<double> CumulativeAreas(const TriangleMesh& mesh) {
  std::vector<double> sums(mesh.faces.size());
  double sum = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const double area = FaceNormalTimesTwiceArea(mesh, f).norm();
    if (std::isfinite(area)) sum += area;
    sums[f] = sum;
  }
  return sums;
}

Eigen::Vector3d PointOnFace(const TriangleMesh& mesh, size_t f, double first, double second) {
  const Eigen::Vector3i& face = mesh.faces[f];
  const double root = std::sqrt(first);
  return (1 - root) * mesh.vertices[face[0]] + root * (1 - second) * mesh.vertices[face[1]] +
         root * second * mesh.vertices[face[2]];
}

std::vector<Eigen::Vector3d> SampleVertices(const std::vector<Eigen::Vector3d>& vertices,
                                            size_t count, uint64_t seed) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& x : vertices) {
    if (x.allFinite()) points.push_back(x);
  }
  if (points.size() <= count) return points;
  for (size_t i = 0; i < count; ++i) {  // the first steps of a Fisher-Yates shuffle
    const double left = static_cast<double>(points.size() - i);
    std::swap(points[i], points[i + static_cast<size_t>(Uniform(seed, i) * left)]);
  }
  points.resize(count);
  return points;
}

}  // namespace

std::vector<Eigen::Vector3d> SampleSurface(const TriangleMesh& mesh, size_t count, uint64_t seed,
                                           const RunContext& context) {
  if (mesh.faces.empty()) return SampleVertices(mesh.vertices, count, seed);
  const std::vector<double> sums = CumulativeAreas(mesh);
  if (!(sums.back() > 0)) return {};
  std::vector<Eigen::Vector3d> points(count);
  ParallelFor(context, count, 4096, [&](size_t i) {
    const double target = Uniform(seed, 3 * i) * sums.back();
    const auto face = std::upper_bound(sums.begin(), sums.end(), target);
    const size_t f = std::min<size_t>(face - sums.begin(), sums.size() - 1);
    points[i] = PointOnFace(mesh, f, Uniform(seed, 3 * i + 1), Uniform(seed, 3 * i + 2));
  });
  return points;
}

std::vector<Eigen::Vector3d> OnePointPerVoxel(const std::vector<Eigen::Vector3d>& points,
                                              double voxel_size, uint64_t seed) {
  using Voxel = std::array<int64_t, 3>;
  std::vector<std::tuple<Voxel, double, size_t>> drawn;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    Voxel voxel;
    for (int k = 0; k < 3; ++k) {
      voxel[static_cast<size_t>(k)] = static_cast<int64_t>(std::floor(points[i][k] / voxel_size));
    }
    drawn.emplace_back(voxel, Uniform(seed, i), i);
  }
  std::sort(drawn.begin(), drawn.end());
  std::vector<Eigen::Vector3d> kept;
  for (size_t i = 0; i < drawn.size(); ++i) {
    if (i > 0 && std::get<0>(drawn[i]) == std::get<0>(drawn[i - 1])) continue;
    kept.push_back(points[std::get<2>(drawn[i])]);
  }
  return kept;
}

}  // namespace lsmvs
