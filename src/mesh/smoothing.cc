#include "lsmvs/mesh/smoothing.h"

#include <algorithm>
#include <numeric>

namespace lsmvs {

namespace {

// Neighbours of each vertex in one array; none for vertices that stay.
struct Neighborhoods {
  std::vector<uint32_t> begin, neighbors;
};

// In an oriented manifold an inner vertex has each neighbour once as the next corner of a face.
Neighborhoods FindNeighbors(const TriangleMesh& mesh) {
  Neighborhoods result;
  result.begin.assign(mesh.vertices.size() + 2, 0);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (const int v : face) ++result.begin[v + 2];
  }
  std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
  result.neighbors.resize(result.begin.back());
  // Next minus last corners: around an inner vertex they are the same; at a border one of each is
  // left over.
  std::vector<int64_t> balance(mesh.vertices.size(), 0);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const int next = face[(k + 1) % 3], last = face[(k + 2) % 3];
      result.neighbors[result.begin[face[k] + 1]++] = static_cast<uint32_t>(next);
      balance[face[k]] += next - last;
    }
  }
  result.begin.pop_back();
  std::vector<uint32_t> begin = {0}, kept;
  kept.reserve(result.neighbors.size());
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (balance[v] == 0) {
      kept.insert(kept.end(), result.neighbors.begin() + result.begin[v],
                  result.neighbors.begin() + result.begin[v + 1]);
    }
    begin.push_back(static_cast<uint32_t>(kept.size()));
  }
  return {std::move(begin), std::move(kept)};
}

}  // namespace

void SmoothTaubin(const TaubinOptions& options, const RunContext& context, TriangleMesh* mesh) {
  constexpr size_t kBlock = 1 << 13;
  const Neighborhoods near = FindNeighbors(*mesh);
  std::vector<Eigen::Vector3d> moved(mesh->vertices.size());
  const auto step = [&](double share) {
    ParallelFor(context, moved.size(), kBlock, [&](size_t v) {
      moved[v] = mesh->vertices[v];
      if (near.begin[v] == near.begin[v + 1]) return;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (uint32_t i = near.begin[v]; i < near.begin[v + 1]; ++i) {
        mean += mesh->vertices[near.neighbors[i]] - moved[v];
      }
      moved[v] += share / static_cast<double>(near.begin[v + 1] - near.begin[v]) * mean;
    });
    mesh->vertices.swap(moved);
  };
  for (int i = 0; i < options.num_iterations; ++i) {
    step(options.lambda);
    step(options.mu);
  }
  if (!mesh->vertex_normals.empty()) mesh->vertex_normals = ComputeVertexNormals(*mesh);
}

}  // namespace lsmvs
