#include "lsmvs/mesh/simplification/proper_surface.h"

namespace lsmvs::internal {

namespace {

bool IsProper(const TriangleMesh& mesh, const Eigen::Vector3i& face) {
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return false;
  for (const int v : face) {
    if (!mesh.vertices[static_cast<size_t>(v)].allFinite()) return false;
  }
  return true;
}

// Numbers vertices in the order in which they are first used.
class UsedVertices {
 public:
  explicit UsedVertices(size_t num_vertices) : new_index_(num_vertices, -1) {}

  Eigen::Vector3i Renamed(const Eigen::Vector3i& face) {
    Eigen::Vector3i renamed;
    for (int k = 0; k < 3; ++k) {
      int& index = new_index_[static_cast<size_t>(face[k])];
      if (index < 0) {
        index = static_cast<int>(used_.size());
        used_.push_back(face[k]);
      }
      renamed[k] = index;
    }
    return renamed;
  }
  const std::vector<int>& used() const { return used_; }

 private:
  std::vector<int> new_index_, used_;
};

}  // namespace

ProperSurface ProperPart(const TriangleMesh& mesh) {
  ProperSurface surface;
  UsedVertices vertices(mesh.vertices.size());
  surface.faces.reserve(mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    if (IsProper(mesh, face)) surface.faces.push_back(vertices.Renamed(face));
  }
  surface.source = vertices.used();
  if (surface.source.empty()) return surface;
  surface.origin = mesh.vertices[static_cast<size_t>(surface.source[0])];
  surface.vertices.reserve(surface.source.size());
  for (const int v : surface.source) {
    surface.vertices.emplace_back(mesh.vertices[static_cast<size_t>(v)] - surface.origin);
  }
  return surface;
}

SimplifiedMesh CompactMesh(const std::vector<Eigen::Vector3d>& positions,
                           const std::vector<Eigen::Vector3i>& faces,
                           const std::vector<int>& source) {
  SimplifiedMesh result;
  UsedVertices vertices(positions.size());
  result.mesh.faces.reserve(faces.size());
  for (const Eigen::Vector3i& face : faces) result.mesh.faces.push_back(vertices.Renamed(face));
  for (const int v : vertices.used()) {
    result.mesh.vertices.push_back(positions[static_cast<size_t>(v)]);
    result.source_vertex.push_back(source[static_cast<size_t>(v)]);
  }
  return result;
}

}  // namespace lsmvs::internal
