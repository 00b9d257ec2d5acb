#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of lists
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
  // Position of a property, or -1.
  int Find(const std::string& property_name) const;
};

// Reads any PLY: ascii, binary little or big endian, properties of any type and in any order,
// elements that nobody asked for. Everything that does not fit (truncated, wrong counts, unknown
// types) throws InputError with the path and the byte.
class PlyReader {
 public:
  // One row of an element. A scalar property p is values[first[p]]; a list's items are
  // values[first[p] .. first[p+1]).
  struct Row {
    uint64_t index = 0;
    std::vector<double> values;
    std::vector<size_t> first;  // #properties + 1
  };
  using Visitor = std::function<void(const Row&)>;

  // Reads the header.
  explicit PlyReader(const std::filesystem::path& path);
  ~PlyReader();
  PlyReader(const PlyReader&) = delete;
  PlyReader& operator=(const PlyReader&) = delete;

  const std::vector<PlyElement>& elements() const { return elements_; }
  // What follows "comment " in each comment line of the header, in file order.
  const std::vector<std::string>& comments() const { return comments_; }
  // Null if there is none of that name.
  const PlyElement* FindElement(const std::string& name) const;

  // Reads all elements in file order and hands the rows of those that have a visitor to it. Call
  // once.
  void Read(const std::map<std::string, Visitor>& visitors);

 private:
  struct Input;
  void ParseHeader();
  void ReadAnyRows(const PlyElement& element, const Visitor& visit);
  // Binary, little endian, without lists.
  void ReadFixedRows(const PlyElement& element, const Visitor& visit);

  std::string path_;
  std::vector<PlyElement> elements_;
  std::vector<std::string> comments_;
  std::unique_ptr<Input> input_;
};

// What to do with vertices whose coordinates are NaN or infinite.
enum class NotFinite { kRefuse, kKeep };

// Reads a triangle mesh; polygons become fans; colours, normals and quality of vertices are taken
// if there. A
// file without faces gives a mesh without faces. `world_offset` is subtracted from every vertex.
// Throws InputError (also for indices out of range and, with kRefuse, for NaN coordinates).
TriangleMesh ReadMeshPly(const std::filesystem::path& path,
                         const Eigen::Vector3d& world_offset = Eigen::Vector3d::Zero(),
                         NotFinite not_finite = NotFinite::kRefuse);

// Writes binary little-endian PLY: float x y z [nx ny nz] [uchar red green blue] [float
// quality] (as MeshLab and CloudCompare show it), `list uchar int vertex_indices` (the name that
// OpenMVS insists on; COLMAP takes any, and MeshLab, CloudCompare, Open3D, Blender and trimesh know
// it too). With a `world_offset` other than zero it is added and coordinates are written as double.
// Atomic.
void WriteMeshPly(const std::filesystem::path& path, const TriangleMesh& mesh,
                  const Eigen::Vector3d& world_offset = Eigen::Vector3d::Zero());

// The colour that a file's red, green and blue mean: cut to 0 .. 255; what is no number is 0.
Eigen::Matrix<uint8_t, 3, 1> PlyColor(const Eigen::Vector3d& values);

}  // namespace lsmvs
