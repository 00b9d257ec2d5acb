#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/geometry/distances.h"
#include "lsmvs/mesh/by_vertex.h"
#include "lsmvs/mesh/simplification/vertex_stars.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs::internal {

// A collapse before it is done: `drop` joins `keep`, which moves to `place`.
struct Collapse {
  struct NewFace {
    int32_t face;
    Eigen::Vector3i corners;  // `keep` instead of `drop`
    Triangle3 triangle;
  };
  int32_t keep, drop;
  Eigen::Vector3d place;
  std::vector<NewFace> faces;    // of both vertices, those that stay
  std::vector<int32_t> removed;  // those that vanish
};

// Keeps a surface within a tolerance of the one it was made from while its edges are collapsed.
//
// Every input vertex that is gone lies by a present face. The overlay of the surfaces has three
// kinds of corners: input vertices, present vertices, and crossings of an input edge with a present
// edge; between them the distance of corresponding points is convex, so that its largest value is
// at a corner. A collapse is allowed if all input vertices of its star are within tolerance of a
// new face, if every input edge from one of them can be walked along from face to face with both
// ends of each part within tolerance of the same face (then so is the part), if the new vertex is
// within tolerance of the input, and if some points on the new edges and faces are.
//
// On the border the input's vertices between two present ones lie within tolerance of the edge
// between these; border vertices do not move.
class DeviationBound {
 public:
  // `tolerance` (#V). Arguments and `stars` outlive this; `stars` holds the input.
  DeviationBound(const std::vector<Eigen::Vector3d>& vertices,
                 const std::vector<Eigen::Vector3i>& faces, const std::vector<double>& tolerance,
                 const VertexStars& stars);

  // Whether a vertex is where it was in the input.
  bool IsInPlace(int32_t v) const { return face_of_[static_cast<size_t>(v)] == kInPlace; }
  bool IsOnBorder(int32_t v) const {
    return next_on_border_[static_cast<size_t>(v)] != kNone ||
           previous_on_border_[static_cast<size_t>(v)] != kNone;
  }

  // Whether the collapse keeps the tolerance. Border vertices must stay in place.
  bool Allows(const Collapse& collapse);
  // The same for a collapse that is known to.
  void Accept(const Collapse& collapse);
  // After Allows(): says which input vertices lie by which faces in the star; the same for the
  // same.
  uint64_t StateHash() const;
  // Takes note that the collapse last allowed is done.
  void Apply(const Collapse& collapse);
  // Input vertices that lie by a face.
  template <class Visit>
  void ForVerticesBy(int32_t face, const Visit& visit) const {
    for (int32_t v = first_by_[static_cast<size_t>(face)]; v != kNone;
         v = next_by_[static_cast<size_t>(v)]) {
      visit(v);
    }
  }
  // After Allows(): the input vertex nearest to the place of the collapse, of those that lie in its
  // star.
  int32_t nearest() const { return nearest_; }

 private:
  static constexpr int32_t kNone = -1, kInPlace = -1, kBranches = -2;
  static constexpr uint64_t kAll = ~uint64_t{0};

  // A point of an input edge, and which candidates are within tolerance of it, of those that it was
  // compared with.
  struct Point {
    Eigen::Vector3d x;
    uint64_t near, known = 0;
  };

  struct Ball {
    Eigen::Vector3d center;
    double radius;
  };

  void LinkNeighbors(const std::vector<Eigen::Vector3i>& faces);
  void LinkBorders(const std::vector<Eigen::Vector3i>& faces);
  double SquaredTolerance(int32_t v) const;
  void Begin();
  bool End(bool allowed);
  bool CollectVertices(const Collapse& collapse);
  bool AddVertex(const Collapse& collapse, int32_t v);
  bool IsPlaceNear(const Collapse& collapse);
  bool AreEdgesNear(const Collapse& collapse);
  bool IsBorderNear(const Collapse& collapse) const;
  bool IsChainNear(int32_t from, int32_t to) const;
  bool IsWayOutCovered(const Collapse& collapse, size_t star_vertex, int32_t w,
                       double squared_tolerance);
  bool IsWayInsideCovered(const Collapse& collapse, size_t i, size_t j, double squared_tolerance);
  bool IsWayCoveredAround(const Collapse& collapse, const Point& s, const Point& t,
                          double squared_tolerance);
  uint64_t NewFaces(const Collapse& collapse) const;
  bool IsOneStepCovered(const Point& s, uint64_t faces_at_t, double squared_tolerance,
                        Point* t) const;
  void AddCandidate(const Triangle3& triangle);
  uint64_t OuterCandidate(const Collapse& collapse, int32_t face);
  void ForgetCandidates(size_t num_left);
  uint64_t CandidatesAlong(const Eigen::Vector3d& s, const Eigen::Vector3d& t, uint64_t candidates,
                           double squared_tolerance) const;
  uint64_t FacesAt(const Collapse& collapse, int32_t v);
  void AddFacesAround(const Collapse& collapse);
  uint64_t NearFaces(const Eigen::Vector3d& x, uint64_t candidates, double squared_tolerance) const;
  bool IsNearOneOf(uint64_t candidates, double squared_tolerance, Point* t) const;
  bool IsCovered(Point s, Point t, uint64_t candidates, double squared_tolerance) const;
  bool AreNewFacesNear(const Collapse& collapse) const;
  bool IsNearInput(const Collapse& collapse, const Collapse::NewFace& face,
                   const Eigen::Vector3d& x) const;
  bool IsNearFacesAt(int32_t v, const Eigen::Vector3d& x, double squared_tolerance) const;

  const std::vector<Eigen::Vector3d>& vertices_;
  const std::vector<Eigen::Vector3i>& input_faces_;
  const std::vector<double>& tolerance_;
  const VertexStars& stars_;
  std::vector<uint32_t> neighbors_begin_;  // #V + 1
  std::vector<int32_t> neighbors_;         // of the input
  ByVertex corners_of_;                    // of the input
  std::vector<int32_t> face_of_;           // #V: kInPlace, or the present face it lies by
  std::vector<int32_t> first_by_;          // #F: head of the list of vertices by a face
  std::vector<int32_t> next_by_;           // #V
  // Along the border: of the input, and of what is left. kNone inside, kBranches where more than
  // one border edge leaves a vertex.
  std::vector<int32_t> input_next_, next_on_border_, previous_on_border_;

  // Of the collapse that is looked at.
  std::vector<PreparedTriangle>
      candidates_;                      // faces that edges may lie by; the new ones come first
  std::vector<Ball> balls_;             // around candidates_
  std::vector<int32_t> star_vertices_;  // input vertices whose faces change
  std::vector<int32_t> old_faces_;      // as star_vertices_
  std::vector<uint64_t> near_faces_;    // as star_vertices_: new faces within tolerance, a bit each
  std::vector<int32_t> place_in_star_;  // #V: in star_vertices_, or kNone
  std::vector<int32_t> outer_faces_;    // of candidates_ behind the new faces
  std::vector<int8_t> place_in_candidates_;  // #F: of outer_faces_, else kNone
  bool has_faces_around_ = false;            // in outer_faces_
  int32_t nearest_ = kNone;
};

}  // namespace lsmvs::internal
