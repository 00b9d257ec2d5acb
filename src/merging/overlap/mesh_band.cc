#include "lsmvs/merging/overlap/mesh_band.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <queue>
#include <utility>

#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr int kNumSmoothingSteps = 3;

template <class Value>
void SmoothOverNeighbors(const SurfaceTopology& topology, std::vector<Value>* values) {
  std::vector<Value> smoothed = *values;
  for (size_t v = 0; v < smoothed.size(); ++v) {
    int count = 1;
    topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
      smoothed[v] += (*values)[static_cast<size_t>(w)];
      ++count;
    });
    smoothed[v] /= static_cast<double>(count);
  }
  values->swap(smoothed);
}

}  // namespace

MeshBand ExtractBand(const SourcedMesh& whole, const std::vector<uint8_t>& in_band) {
  MeshBand band;
  std::vector<int32_t> new_index(whole.mesh.vertices.size(), -1);
  for (size_t f = 0; f < in_band.size(); ++f) {
    if (!in_band[f]) continue;
    for (const int v : whole.mesh.faces[f]) new_index[static_cast<size_t>(v)] = 0;
  }
  for (size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] < 0) continue;
    new_index[v] = static_cast<int32_t>(band.whole_vertex.size());
    band.whole_vertex.push_back(static_cast<int32_t>(v));
    band.mesh.vertices.push_back(whole.mesh.vertices[v]);
    band.sources.push_back(whole.sources[v]);
    band.is_changed.push_back(whole.is_changed[v]);
    band.is_preferred.push_back(!whole.is_preferred.empty() && whole.is_preferred[v]);
  }
  band.is_fixed.assign(band.whole_vertex.size(), 0);
  for (size_t f = 0; f < in_band.size(); ++f) {
    Eigen::Vector3i face;
    for (int k = 0; k < 3; ++k) face[k] = new_index[static_cast<size_t>(whole.mesh.faces[f][k])];
    if (in_band[f]) {
      band.mesh.faces.push_back(face);
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const int a = face[k], b = face[(k + 1) % 3];
      if (a >= 0) band.is_fixed[static_cast<size_t>(a)] = 1;
      if (a >= 0 && b >= 0) band.cut_edges.push_back(EdgeKey(a, b));
    }
  }
  std::sort(band.cut_edges.begin(), band.cut_edges.end());
  // Of those, the ones that the band's faces have.
  std::vector<uint64_t> own;
  for (const Eigen::Vector3i& face : band.mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const int a = face[k], b = face[(k + 1) % 3];
      if (!band.is_fixed[static_cast<size_t>(a)] || !band.is_fixed[static_cast<size_t>(b)])
        continue;
      const uint64_t key = EdgeKey(a, b);
      if (std::binary_search(band.cut_edges.begin(), band.cut_edges.end(), key)) own.push_back(key);
    }
  }
  std::sort(own.begin(), own.end());
  own.erase(std::unique(own.begin(), own.end()), own.end());
  band.cut_edges = std::move(own);
  return band;
}

SurfaceTopology::SurfaceTopology(const TriangleMesh& mesh, const std::vector<uint64_t>& cut_edges)
    : begin_(mesh.vertices.size() + 1, 0),
      on_border_(mesh.vertices.size(), 0),
      border_sides_(mesh.faces.size(), 0) {
  const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    ++begin_[static_cast<size_t>(begin->low) + 1];
    ++begin_[static_cast<size_t>(begin->high) + 1];
    const bool is_cut =
        std::binary_search(cut_edges.begin(), cut_edges.end(), EdgeKey(begin->low, begin->high));
    if (end - begin != 1 || is_cut) return;
    on_border_[static_cast<size_t>(begin->low)] = on_border_[static_cast<size_t>(begin->high)] = 1;
    border_sides_[static_cast<size_t>(begin->face)] |= static_cast<uint8_t>(1 << begin->corner);
  });
  for (size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
  neighbors_.resize(begin_.back());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge*) {
    neighbors_[next[static_cast<size_t>(begin->low)]++] = begin->high;
    neighbors_[next[static_cast<size_t>(begin->high)]++] = begin->low;
  });
}

std::vector<double> DistanceAlongEdges(const TriangleMesh& mesh, const SurfaceTopology& topology,
                                       std::vector<double> start, double max_distance,
                                       std::vector<int32_t>* nearest) {
  std::vector<double>& distance = start;
  using Entry = std::pair<double, int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  if (nearest != nullptr) nearest->assign(distance.size(), -1);
  for (size_t v = 0; v < distance.size(); ++v) {
    if (!(distance[v] <= max_distance)) continue;
    queue.emplace(distance[v], static_cast<int32_t>(v));
    if (nearest != nullptr) (*nearest)[v] = static_cast<int32_t>(v);
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[static_cast<size_t>(v)]) continue;
    topology.ForNeighbors(v, [&, d = d, v = v](int32_t w) {
      const auto from = static_cast<size_t>(v), to = static_cast<size_t>(w);
      const double reached = d + (mesh.vertices[from] - mesh.vertices[to]).norm();
      if (reached > max_distance || reached >= distance[to]) return;
      distance[to] = reached;
      if (nearest != nullptr) (*nearest)[to] = (*nearest)[from];
      queue.emplace(reached, w);
    });
  }
  return start;
}

VertexFrames ComputeVertexFrames(const TriangleMesh& mesh, const SurfaceTopology& topology) {
  VertexFrames frames;
  const size_t num_vertices = mesh.vertices.size();
  frames.edge_length.assign(num_vertices, 0);
  double sum = 0;
  for (size_t v = 0; v < num_vertices; ++v) {
    int count = 0;
    topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
      frames.edge_length[v] += (mesh.vertices[static_cast<size_t>(w)] - mesh.vertices[v]).norm();
      ++count;
    });
    frames.edge_length[v] /= std::max(count, 1);
    sum += frames.edge_length[v];
  }
  const double mean = num_vertices > 0 ? sum / static_cast<double>(num_vertices) : 1.0;
  for (double& length : frames.edge_length) length = std::max(length, 1e-3 * mean);
  frames.normal.assign(num_vertices, Eigen::Vector3d::Zero());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, f);
    for (const int v : mesh.faces[f]) frames.normal[static_cast<size_t>(v)] += normal;
  }
  for (int step = 0; step < kNumSmoothingSteps; ++step) {
    SmoothOverNeighbors(topology, &frames.edge_length);
    SmoothOverNeighbors(topology, &frames.normal);
  }
  for (Eigen::Vector3d& normal : frames.normal) normal.normalize();
  return frames;
}

}  // namespace lsmvs
