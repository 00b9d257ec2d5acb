#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace lsmvs {

// The triangulation of a closed polygon of `n` corners of least total cost, as positions i < k < j
// of corners. cost(i, k, j) of a triangle is infinite if it must not be; may_join(i, j) says which
// diagonals may be. Of triangulations of equal cost the first found stays. Empty if there is none.
// O(n^3), 12 n^2 bytes.
//   G. Klincsek: Minimal triangulations of polygonal domains, 1980.
template <class Cost, class MayJoin>
std::vector<Eigen::Vector3i> TriangulatePolygon(size_t n, const Cost& cost,
                                                const MayJoin& may_join) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector3i> triangles;
  if (n < 3) return triangles;
  // Of the best triangulation between corners i < j: its cost, and the third corner at i and j.
  std::vector<double> best(n * n, kInfinity);
  std::vector<int32_t> apex(n * n, -1);
  for (size_t i = 0; i + 1 < n; ++i) best[i * n + i + 1] = 0;
  for (size_t gap = 2; gap < n; ++gap) {
    for (size_t i = 0; i + gap < n; ++i) {
      const size_t j = i + gap;
      const bool is_side = i == 0 && j + 1 == n;
      if (!is_side && !may_join(i, j)) continue;
      double& least = best[i * n + j];
      for (size_t k = i + 1; k < j; ++k) {
        const double parts = best[i * n + k] + best[k * n + j];
        if (!(parts < least)) continue;
        const double whole = parts + cost(i, k, j);
        if (!(whole < least)) continue;
        least = whole;
        apex[i * n + j] = static_cast<int32_t>(k);
      }
    }
  }
  if (!(best[n - 1] < kInfinity)) return triangles;
  std::vector<std::pair<size_t, size_t>> waiting = {{0, n - 1}};
  while (!waiting.empty()) {
    const auto [i, j] = waiting.back();
    waiting.pop_back();
    if (j == i + 1) continue;
    const auto k = static_cast<size_t>(apex[i * n + j]);
    triangles.emplace_back(static_cast<int>(i), static_cast<int>(k), static_cast<int>(j));
    waiting.emplace_back(k, j);
    waiting.emplace_back(i, k);
  }
  return triangles;
}

}  // namespace lsmvs
