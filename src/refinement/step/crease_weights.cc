#include "lsmvs/refinement/step/crease_weights.h"

#include <algorithm>

#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

constexpr size_t kVerticesPerBlock = 8192, kRegionsPerBlock = 64;
// Part of the usual squared curvature at which the stiffness has fallen to half. From 0.3 to 1.5
// results hardly differ; smaller keeps more of the noise, larger rounds creases.
constexpr double kCreaseRatio = 0.7;
// Squared Laplacians (1 / px^2) above this are no noise of a refined surface, even if they are
// usual around: thin poles and fine relief bend with such radii (7 px) everywhere.
constexpr double kMostNoise = 0.02;

// Of a vertex and its ring.
std::vector<double> RingMeans(const std::vector<double>& values, const VertexRings& rings,
                              const RunContext& context) {
  std::vector<double> means(values.size());
  ParallelFor(context, values.size(), kVerticesPerBlock, [&](size_t v) {
    double sum = values[v];
    for (auto k = rings.begin[v]; k < rings.begin[v + 1]; ++k) {
      sum += values[static_cast<size_t>(rings.neighbors[static_cast<size_t>(k)])];
    }
    means[v] = sum / (1 + rings.begin[v + 1] - rings.begin[v]);
  });
  return means;
}

}  // namespace

CreaseWeights::CreaseWeights(const TriangleMesh& mesh, const FaceRegions& regions,
                             double flat_stiffness)
    : flat_stiffness_(flat_stiffness),
      region_of_vertex_(RegionsOfVertices(mesh, regions)),
      neighborhood_(static_cast<size_t>(regions.count)) {
  for (size_t r = 0; r < neighborhood_.size(); ++r) {
    neighborhood_[r].push_back(static_cast<int32_t>(r));
  }
  const auto add = [&](int32_t region, int32_t other) {
    std::vector<int32_t>& list = neighborhood_[static_cast<size_t>(region)];
    if (std::find(list.begin(), list.end(), other) == list.end()) list.push_back(other);
  };
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      const int32_t region = regions.of_face[f], other = region_of_vertex_[static_cast<size_t>(v)];
      if (region == other) continue;
      add(region, other);
      add(other, region);
    }
  }
}

std::vector<float> CreaseWeights::Factors(const std::vector<double>& squared_laplacians,
                                          const VertexRings& rings,
                                          const RunContext& context) const {
  const std::vector<double> curvature = RingMeans(squared_laplacians, rings, context);
  std::vector<std::vector<float>> of_region(neighborhood_.size());
  for (size_t v = 0; v < curvature.size(); ++v) {
    if (region_of_vertex_[v] < 0) continue;
    of_region[static_cast<size_t>(region_of_vertex_[v])].push_back(
        static_cast<float>(curvature[v]));
  }
  std::vector<double> usual(neighborhood_.size(), 0.0);
  ParallelFor(context, usual.size(), kRegionsPerBlock, [&](size_t r) {
    std::vector<float> around;
    for (const int32_t n : neighborhood_[r]) {
      const std::vector<float>& part = of_region[static_cast<size_t>(n)];
      around.insert(around.end(), part.begin(), part.end());
    }
    if (!around.empty()) usual[r] = static_cast<double>(Median(&around));
  });
  std::vector<float> factors(curvature.size(), 1.0f);
  ParallelFor(context, factors.size(), kVerticesPerBlock, [&](size_t v) {
    if (region_of_vertex_[v] < 0) return;
    const double scale =
        kCreaseRatio * std::min(usual[static_cast<size_t>(region_of_vertex_[v])], kMostNoise);
    // Where most of the surface does not bend at all, any bend is a crease.
    const double ratio = curvature[v] / std::max(scale, 1e-12);
    factors[v] = static_cast<float>(1 + (flat_stiffness_ - 1) / (1 + ratio * ratio));
  });
  return factors;
}

}  // namespace lsmvs
