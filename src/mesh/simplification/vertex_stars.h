#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace lsmvs::internal {

// Triangles of any topology with the faces of each vertex, for collapsing edges. A corner is 3 *
// face + its place in the face; the corners of a vertex are a linked list: 4 bytes a corner and 4 a
// vertex beside the mesh.
class VertexStars {
 public:
  static constexpr int32_t kNone = -1;

  VertexStars(std::vector<Eigen::Vector3d> positions, std::vector<Eigen::Vector3i> faces);

  size_t num_vertices() const { return positions_.size(); }
  size_t num_faces() const { return num_faces_; }  // that are left
  size_t num_all_faces() const { return faces_.size(); }
  const Eigen::Vector3d& position(int32_t v) const { return positions_[static_cast<size_t>(v)]; }
  const std::vector<Eigen::Vector3d>& positions() const { return positions_; }
  const Eigen::Vector3i& face(int32_t f) const { return faces_[static_cast<size_t>(f)]; }
  bool IsLeft(int32_t f) const { return face(f)[0] != kNone; }

  // Calls visit(face, place of v in the face) for the faces at a vertex.
  template <class Visit>
  void ForFaces(int32_t v, const Visit& visit) const {
    for (int32_t c = head_[static_cast<size_t>(v)]; c != kNone; c = next_[static_cast<size_t>(c)]) {
      visit(c / 3, c % 3);
    }
  }
  // Whether visit(face, place) holds for a face at a vertex; stops at the first.
  template <class Visit>
  bool AnyFace(int32_t v, const Visit& visit) const {
    for (int32_t c = head_[static_cast<size_t>(v)]; c != kNone; c = next_[static_cast<size_t>(c)]) {
      if (visit(c / 3, c % 3)) return true;
    }
    return false;
  }
  bool Has(int32_t f, int32_t v) const {
    const Eigen::Vector3i& corners = face(f);
    return corners[0] == v || corners[1] == v || corners[2] == v;
  }

  // Joins `drop` to `keep`, which moves to `place`: faces at both vanish, those at `drop` get the
  // corner `keep`.
  void Merge(int32_t keep, int32_t drop, const Eigen::Vector3d& place);

  // Faces that are left.
  std::vector<Eigen::Vector3i> Faces() const;

 private:
  void Unlink(int32_t v, int32_t face);

  std::vector<Eigen::Vector3d> positions_;
  std::vector<Eigen::Vector3i> faces_;  // kNone in those that vanished
  std::vector<int32_t> head_, next_;
  size_t num_faces_;
};

}  // namespace lsmvs::internal
