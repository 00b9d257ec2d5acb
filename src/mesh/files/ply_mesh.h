#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <filesystem>
#include <string>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/atomic_file.h"

// What the readers and writers of plain and of textured meshes share.
namespace lsmvs::internal {

inline constexpr const char* kRemedy = "save it again as PLY";

// Positions of three scalar properties in the rows of an element, or of none.
struct PlyTriple {
  std::array<int, 3> position = {-1, -1, -1};

  PlyTriple() = default;
  PlyTriple(const PlyElement& element, const std::array<const char*, 3>& names);
  explicit operator bool() const {
    return *std::min_element(position.begin(), position.end()) >= 0;
  }
  Eigen::Vector3d Of(const PlyReader::Row& row) const;
};

// Makes a triangle mesh of the rows of a PLY file's vertices and faces.
class PlyMeshCollector {
 public:
  // Throws InputError if the header lacks coordinates or indices.
  PlyMeshCollector(const PlyReader& reader, const std::filesystem::path& path,
                   const Eigen::Vector3d& world_offset, NotFinite not_finite);

  void AddVertex(const PlyReader::Row& row);
  // Adds a polygon as a fan of triangles about its first corner; returns its number of corners.
  size_t AddFace(const PlyReader::Row& row);
  // The mesh. Throws InputError if a face names a vertex that is not there.
  TriangleMesh Take();

 private:
  std::string path_;
  Eigen::Vector3d world_offset_;
  NotFinite not_finite_;
  PlyTriple position_, normal_, color_;
  int indices_ = -1, quality_ = -1;
  TriangleMesh mesh_;
};

// Writes the vertices of a mesh, with normals, colours and quality if it has them.
class PlyVertexWriter {
 public:
  // Coordinates are double if there is an offset to add.
  PlyVertexWriter(const TriangleMesh& mesh, const Eigen::Vector3d& world_offset);

  std::string Header() const;
  void WriteRows(AtomicFile* file) const;

 private:
  bool has_normals() const { return !mesh_.vertex_normals.empty(); }
  bool has_colors() const { return !mesh_.vertex_colors.empty(); }
  bool has_quality() const { return !mesh_.vertex_quality.empty(); }

  const TriangleMesh& mesh_;
  Eigen::Vector3d world_offset_;
  bool as_double_;
};

}  // namespace lsmvs::internal
