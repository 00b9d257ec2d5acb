#include "lsmvs/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

namespace lsmvs {

Eigen::Vector3d FaceNormalTimesTwiceArea(const TriangleMesh& mesh, size_t face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  return (mesh.vertices[f[1]] - mesh.vertices[f[0]])
      .cross(mesh.vertices[f[2]] - mesh.vertices[f[0]]);
}

std::vector<Eigen::Vector3f> ComputeVertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, f);
    for (const int v : mesh.faces[f]) sums[v] += normal;
  }
  std::vector<Eigen::Vector3f> normals(sums.size());
  for (size_t v = 0; v < sums.size(); ++v) {
    const double length = sums[v].norm();
    normals[v] = length > 0 ? Eigen::Vector3f((sums[v] / length).cast<float>())
                            : Eigen::Vector3f(Eigen::Vector3f::Zero());
  }
  return normals;
}

Eigen::Vector3d RoundToFile(const Eigen::Vector3d& x, double max_distance) {
  const Eigen::Vector3d rounded = x.cast<float>().cast<double>();
  return (rounded - x).norm() < max_distance ? rounded : x;
}

std::vector<int> RemoveUnusedVertices(TriangleMesh* mesh) {
  std::vector<int> new_index(mesh->vertices.size(), -1);
  for (const Eigen::Vector3i& face : mesh->faces) {
    for (const int v : face) new_index[v] = 0;
  }
  int count = 0;
  const auto keep = [&](auto* attribute, size_t v) {
    if (!attribute->empty()) (*attribute)[static_cast<size_t>(count)] = (*attribute)[v];
  };
  for (size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] < 0) continue;
    keep(&mesh->vertices, v);
    keep(&mesh->vertex_colors, v);
    keep(&mesh->vertex_normals, v);
    keep(&mesh->vertex_quality, v);
    new_index[v] = count++;
  }
  const auto cut = [&](auto* attribute) {
    if (!attribute->empty()) attribute->resize(static_cast<size_t>(count));
  };
  cut(&mesh->vertices);
  cut(&mesh->vertex_colors);
  cut(&mesh->vertex_normals);
  cut(&mesh->vertex_quality);
  for (Eigen::Vector3i& face : mesh->faces) {
    for (int& v : face) v = new_index[v];
  }
  return new_index;
}

}  // namespace lsmvs
