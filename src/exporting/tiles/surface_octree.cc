#include "lsmvs/exporting/tiles/surface_octree.h"

#include <Eigen/Geometry>
#include <array>
#include <numeric>

namespace lsmvs {

namespace {

constexpr int kMaxHalvings = 40;  // then centroids differ by rounding at most

class OctreeBuilder {
 public:
  OctreeBuilder(const TriangleMesh& mesh, const std::vector<double>& weights, size_t max_faces,
                double max_weight)
      : weights_(weights), max_faces_(max_faces), max_weight_(max_weight) {
    for (const Eigen::Vector3i& f : mesh.faces) {
      centroids_.push_back((mesh.vertices[f[0]] + mesh.vertices[f[1]] + mesh.vertices[f[2]]) / 3);
    }
  }

  std::vector<SurfaceOctreeNode> Build() {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : centroids_) box.extend(x);
    std::vector<int> faces(centroids_.size());
    std::iota(faces.begin(), faces.end(), 0);
    const double half = box.isEmpty() ? 0 : 0.5 * box.sizes().maxCoeff();
    const Eigen::Vector3d center =
        box.isEmpty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : box.center();
    Add(-1, "r", std::move(faces), center, half);
    return std::move(nodes_);
  }

 private:
  bool Fits(const std::vector<int>& faces) const {
    if (faces.size() > max_faces_) return false;
    double sum = 0;
    for (const int f : faces) sum += weights_.empty() ? 0 : weights_[static_cast<size_t>(f)];
    return sum <= max_weight_ || faces.size() <= 1;
  }

  // Halves the cell until at least two octants have faces; false if that never happens.
  bool Divide(std::array<std::vector<int>, 8>* octants, std::vector<int>* faces,
              Eigen::Vector3d* center, double* half, std::string* name) const {
    for (int halving = 0; halving < kMaxHalvings; ++halving) {
      for (const int f : *faces) {
        const Eigen::Vector3d& x = centroids_[static_cast<size_t>(f)];
        const int octant =
            (x[0] >= (*center)[0]) + 2 * (x[1] >= (*center)[1]) + 4 * (x[2] >= (*center)[2]);
        (*octants)[static_cast<size_t>(octant)].push_back(f);
      }
      size_t only = 0, num_used = 0;
      for (size_t o = 0; o < 8; ++o) {
        if ((*octants)[o].empty()) continue;
        only = o;
        ++num_used;
      }
      if (num_used > 1) return true;
      (*octants)[only].clear();
      *name += static_cast<char>('0' + only);
      *half /= 2;
      *center += *half * OctantDirection(only);
    }
    return false;
  }

  static Eigen::Vector3d OctantDirection(size_t octant) {
    return {octant & 1 ? 1.0 : -1.0, octant & 2 ? 1.0 : -1.0, octant & 4 ? 1.0 : -1.0};
  }

  void Add(int parent, std::string name, std::vector<int> faces, Eigen::Vector3d center,
           double half) {
    const size_t node = nodes_.size();
    nodes_.emplace_back();
    nodes_[node].parent = parent;
    if (parent >= 0) {
      nodes_[static_cast<size_t>(parent)].children.push_back(static_cast<int>(node));
      nodes_[node].depth = nodes_[static_cast<size_t>(parent)].depth + 1;
    }
    nodes_[node].name = name;
    std::array<std::vector<int>, 8> octants;
    if (Fits(faces) || !Divide(&octants, &faces, &center, &half, &name)) {
      nodes_[node].faces = std::move(faces);
      return;
    }
    faces = {};
    for (size_t o = 0; o < 8; ++o) {
      if (octants[o].empty()) continue;
      Add(static_cast<int>(node), name + static_cast<char>('0' + o), std::move(octants[o]),
          center + 0.5 * half * OctantDirection(o), 0.5 * half);
    }
  }

  const std::vector<double>& weights_;
  const size_t max_faces_;
  const double max_weight_;
  std::vector<Eigen::Vector3d> centroids_;
  std::vector<SurfaceOctreeNode> nodes_;
};

int CommonAncestor(const std::vector<SurfaceOctreeNode>& nodes, int a, int b) {
  while (a != b) {
    int& deeper = nodes[a].depth >= nodes[b].depth ? a : b;
    deeper = nodes[deeper].parent;
  }
  return a;
}

}  // namespace

std::vector<SurfaceOctreeNode> BuildSurfaceOctree(const TriangleMesh& mesh,
                                                  const std::vector<double>& weights,
                                                  size_t max_faces, double max_weight) {
  return OctreeBuilder(mesh, weights, max_faces, max_weight).Build();
}

std::vector<int> NodesOfVertices(const TriangleMesh& mesh,
                                 const std::vector<SurfaceOctreeNode>& nodes) {
  std::vector<int> node_of(mesh.vertices.size(), -1);
  for (size_t n = 0; n < nodes.size(); ++n) {
    for (const int f : nodes[n].faces) {
      for (const int v : mesh.faces[f]) {
        const int node = static_cast<int>(n);
        node_of[v] = node_of[v] < 0 ? node : CommonAncestor(nodes, node_of[v], node);
      }
    }
  }
  return node_of;
}

}  // namespace lsmvs
