#include "lsmvs/surface/surface_cleaning.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lsmvs {

namespace {

double LongestEdge(const TriangleMesh& mesh, size_t face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    squared =
        std::max(squared, (mesh.vertices[f[k]] - mesh.vertices[f[(k + 1) % 3]]).squaredNorm());
  }
  return std::sqrt(squared);
}

// Per vertex the shortest of its faces' longest edges: what the surface around it is sampled with.
std::vector<double> LocalLengths(const TriangleMesh& mesh, const std::vector<double>& longest) {
  std::vector<double> lengths(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) lengths[v] = std::min(lengths[v], longest[f]);
  }
  return lengths;
}

size_t DropLongFaces(const SurfaceCleaningOptions& options, TriangleMesh* mesh) {
  if (options.max_side_length_factor <= 0) return 0;
  std::vector<double> longest(mesh->faces.size());
  for (size_t f = 0; f < longest.size(); ++f) longest[f] = LongestEdge(*mesh, f);
  std::vector<double> sorted = longest;
  const auto usual =
      sorted.begin() + static_cast<std::ptrdiff_t>(options.max_side_length_percentile / 100 *
                                                   static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), usual, sorted.end());
  const std::vector<double> local = LocalLengths(*mesh, longest);
  size_t count = 0;
  for (size_t f = 0; f < longest.size(); ++f) {
    double length = *usual;
    for (const int v : mesh->faces[f]) length = std::max(length, local[v]);
    if (longest[f] <= options.max_side_length_factor * length)
      mesh->faces[count++] = mesh->faces[f];
  }
  const size_t num_dropped = mesh->faces.size() - count;
  mesh->faces.resize(count);
  return num_dropped;
}

}  // namespace

SurfaceCleaningCounters CleanSurface(const MergedCloud& cloud,
                                     const SurfaceCleaningOptions& options,
                                     const RunContext& context, ExtractedSurface* surface) {
  (void)cloud;
  (void)context;
  SurfaceCleaningCounters counters;
  counters.num_dropped_facets = DropLongFaces(options, &surface->mesh);
  return counters;
}

}  // namespace lsmvs
