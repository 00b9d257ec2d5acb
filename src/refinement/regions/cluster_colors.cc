#include "lsmvs/refinement/regions/cluster_colors.h"

#include <algorithm>
#include <set>

namespace lsmvs {

namespace {

// The cluster of each region: that of its first face.
std::vector<int32_t> ClustersOfRegions(const FaceRegions& regions, const FaceRegions& clusters) {
  std::vector<int32_t> cluster(static_cast<size_t>(regions.count), -1);
  for (size_t f = 0; f < regions.of_face.size(); ++f) {
    int32_t& of_region = cluster[static_cast<size_t>(regions.of_face[f])];
    if (of_region < 0) of_region = clusters.of_face[f];
  }
  return cluster;
}

// The clusters whose faces share a vertex with those of each cluster.
std::vector<std::set<int32_t>> NeighborsOfClusters(const TriangleMesh& mesh,
                                                   const std::vector<int32_t>& cluster_of_face,
                                                   int num_clusters) {
  std::vector<std::set<int32_t>> neighbors(static_cast<size_t>(num_clusters));
  // The first cluster at each vertex, and those that come to it later: two of these may meet at
  // no other vertex.
  std::vector<std::vector<int32_t>> at_border;
  std::vector<int32_t> first(mesh.vertices.size(), -1), place(mesh.vertices.size(), -1);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const int32_t cluster = cluster_of_face[f];
    for (const int v : mesh.faces[f]) {
      const auto vertex = static_cast<size_t>(v);
      if (first[vertex] < 0) first[vertex] = cluster;
      if (first[vertex] == cluster && place[vertex] < 0) continue;
      if (place[vertex] < 0) {
        place[vertex] = static_cast<int32_t>(at_border.size());
        at_border.push_back({first[vertex]});
      }
      std::vector<int32_t>& met = at_border[static_cast<size_t>(place[vertex])];
      if (std::find(met.begin(), met.end(), cluster) != met.end()) continue;
      for (const int32_t other : met) {
        neighbors[static_cast<size_t>(other)].insert(cluster);
        neighbors[static_cast<size_t>(cluster)].insert(other);
      }
      met.push_back(cluster);
    }
  }
  return neighbors;
}

}  // namespace

ClusterColors ColorClusters(const TriangleMesh& mesh, const FaceRegions& regions,
                            int faces_per_cluster) {
  const FaceRegions clusters = GrowFaceRegions(mesh, faces_per_cluster);
  const std::vector<int32_t> cluster_of_region = ClustersOfRegions(regions, clusters);
  std::vector<int32_t> cluster_of_face(mesh.faces.size());
  for (size_t f = 0; f < cluster_of_face.size(); ++f) {
    cluster_of_face[f] = cluster_of_region[static_cast<size_t>(regions.of_face[f])];
  }
  const auto neighbors = NeighborsOfClusters(mesh, cluster_of_face, clusters.count);
  std::vector<int> colors(static_cast<size_t>(clusters.count), -1);
  ClusterColors result;
  for (size_t c = 0; c < colors.size(); ++c) {
    std::set<int> taken;
    for (const int32_t n : neighbors[c]) taken.insert(colors[static_cast<size_t>(n)]);
    while (taken.contains(++colors[c])) {
    }
    result.num_colors = std::max(result.num_colors, colors[c] + 1);
  }
  for (const int32_t cluster : cluster_of_region) {
    result.of_region.push_back(static_cast<uint8_t>(colors[static_cast<size_t>(cluster)]));
  }
  return result;
}

}  // namespace lsmvs
