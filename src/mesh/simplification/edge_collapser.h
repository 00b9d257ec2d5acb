#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "lsmvs/mesh/simplification/deviation_bound.h"
#include "lsmvs/mesh/simplification/quadric.h"
#include "lsmvs/mesh/simplification/vertex_stars.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs::internal {

// What the faces that a collapse makes must be like.
struct CollapseRules {
  double border_weight = 20;       // of planes across the border, relative to those of the faces
  double min_flatness = 1e-3;      // twice the area over the longest edge squared
  double min_normal_cosine = 0.2;  // between the normals of a face before and after
  size_t max_faces_of_vertex = std::numeric_limits<size_t>::max();
};

// A collapse that was done.
struct CollapseStep {
  Eigen::Vector3d place;
  int32_t keep, drop;
  uint64_t state;  // of the bound after it (DeviationBound::StateHash)
  bool operator==(const CollapseStep&) const = default;
};

// Collapses edges in the order of their quadric error (Garland and Heckbert, "Surface
// simplification using quadric error metrics", SIGGRAPH 1997). A collapse never turns a face over,
// makes an edge non-manifold that was not, or pinches the surface. With a bound each keeps the
// surface within its tolerance, vertices on the border stay where they are, and errors are counted
// in tolerances; without one any topology will do and only faces and quadrics judge.
class EdgeCollapser {
 public:
  // `stars` and `bound` outlive this; `tolerance` (#V) is empty without a bound.
  EdgeCollapser(const CollapseRules& rules, const std::vector<double>& tolerance,
                VertexStars* stars, DeviationBound* bound);

  // Vertices that no collapse touches.
  void Lock(const std::vector<uint8_t>& vertices);
  // Collapses until `min_faces` are left or nothing more can be. Without such a limit, with a
  // bound, in blocks of vertices that follow each other, and then what is left of edges between
  // blocks: vertices that are near each other should come one after the other.
  void Run(size_t min_faces, const RunContext& context);

  // Does the steps that another collapser did on the same mesh, but none with a locked vertex.
  // Where the surface differs because of that they are judged anew; nothing else is. Only with a
  // bound, after Lock().
  void Repeat(const std::vector<CollapseStep>& steps, const RunContext& context);
  // What was done; only with a bound.
  const std::vector<CollapseStep>& steps() const { return steps_; }

  // #V: of each vertex that is left the nearest one that it replaces.
  const std::vector<int32_t>& sources() const { return sources_; }

 private:
  struct Edge {
    float cost;
    uint32_t stamps;  // sum of those of a and b when the cost was computed
    int32_t a, b;
    // The cheapest is first; ties by position.
    bool operator<(const Edge& other) const {
      if (cost != other.cost) return cost > other.cost;
      return a != other.a ? a > other.a : b > other.b;
    }
  };
  struct Placement {
    Eigen::Vector3d place;
    int32_t keep;
    double cost;
  };

  bool IsPinned(int32_t v) const { return bound_ != nullptr && bound_->IsOnBorder(v); }
  void AddFace(int32_t f);
  void HoldBorders(int32_t v);
  void HoldBorder(int32_t f, int32_t v, int32_t w);
  void FindAround(int32_t v, std::vector<int32_t>* around) const;
  bool IsCurrent(const Edge& edge) const;
  Placement PlacementOf(int32_t a, int32_t b) const;
  Eigen::Vector3d BestPlace(const Quadric& sum, int32_t a, int32_t b) const;
  enum class EdgesTo { kAll, kLower };
  void PushEdges(int32_t v, EdgesTo to);
  template <class Poll>
  void CollapseQueue(size_t min_faces, const Poll& poll);
  int CountNeighbors(int32_t v, uint32_t mark, int* num_marked);
  int CountShared(int32_t a, int32_t b) const;
  bool KeepsTopology(int32_t a, int32_t b);
  bool Prepare(const Placement& placement, int32_t drop);
  bool AddNewFaces(int32_t v, int32_t other);
  bool IsProper(const Collapse::NewFace& face, int k) const;
  bool TryCollapse(int32_t a, int32_t b);
  void Apply();
  const Eigen::Vector3d& At(int32_t v) const { return stars_.position(v); }

  const CollapseRules rules_;
  VertexStars& stars_;
  DeviationBound* const bound_;
  std::vector<Quadric> quadrics_;
  std::vector<double> finest_;      // #V: least tolerance of what a vertex replaces; or empty
  std::vector<uint32_t> stamps_;    // #V
  std::vector<int32_t> sources_;    // #V
  std::vector<uint8_t> is_locked_;  // #V or empty
  std::vector<uint32_t> marks_;     // #V
  uint32_t mark_ = 0;
  static constexpr int32_t kAllBlocks = std::numeric_limits<int32_t>::max();
  int32_t block_size_ = 1, block_ = kAllBlocks;  // vertices; the one in work
  std::vector<Edge> queue_, later_;              // a heap; edges of blocks that are done
  std::vector<CollapseStep> steps_;
  Collapse collapse_;  // scratch
};

}  // namespace lsmvs::internal
