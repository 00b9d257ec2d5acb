#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace lsmvs {

// Indexed triangles. #V vertices, #F faces; faces are counter-clockwise seen from outside (from the
// cameras).
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  // #V, in the world (minus Scene::world_offset)
  std::vector<Eigen::Vector3i> faces;     // #F, indices into vertices
  std::vector<Eigen::Matrix<uint8_t, 3, 1>> vertex_colors;  // #V or empty
  std::vector<Eigen::Vector3f> vertex_normals;              // #V or empty; unit length
  std::vector<float> vertex_quality;                        // #V or empty; confidence, 0 to 1

  bool empty() const { return faces.empty(); }
};

// Twice the area times the unit normal of a face.
Eigen::Vector3d FaceNormalTimesTwiceArea(const TriangleMesh& mesh, size_t face);

// Area-weighted vertex normals of unit length; zero for vertices without (proper) faces.
std::vector<Eigen::Vector3f> ComputeVertexNormals(const TriangleMesh& mesh);

// A position in the single precision of mesh files, where that moves it by less than
// `max_distance`: surfaces that do not cross as computed then do not cross when they are read
// again.
Eigen::Vector3d RoundToFile(const Eigen::Vector3d& x, double max_distance);

// Drops vertices that no face uses; keeps the order of the others and of the faces. Returns for
// each old vertex its new index or -1.
std::vector<int> RemoveUnusedVertices(TriangleMesh* mesh);

}  // namespace lsmvs
