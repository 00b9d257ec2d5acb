#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Faces by the cells of a grid that their bounding boxes touch: which faces may meet.
class FaceGrid {
 public:
  // Cells are twice the mean edge long. O(#F log #F); 16 bytes a face and cell it touches.
  FaceGrid(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3i> faces);

  // Pairs of faces (lower index first, ascending) that cross each other and of which at least one
  // has `moved[f]`. Faces that share an edge are not looked at: they meet there. Of faces that
  // share a vertex, the edge opposite of it may cross the other face.
  std::vector<std::pair<int32_t, int32_t>> CrossingPairs(const std::vector<uint8_t>& moved,
                                                         const RunContext& context) const;

 private:
  struct Item {
    uint64_t cell;
    int32_t face;
  };

  void AddFace(int32_t face, double cell_size, const Eigen::Vector3d& origin);

  std::span<const Eigen::Vector3d> vertices_;
  std::span<const Eigen::Vector3i> faces_;
  std::vector<Item> items_;  // sorted
};

// Whether two faces cross: an edge of one passes through the inside of the other. Faces that only
// touch, or lie in one plane, do not cross.
bool FacesCross(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& a,
                const Eigen::Vector3i& b);

// Takes a step back where it makes the surface pass through itself: vertices of faces that cross
// after the step and did not before return to their position `before`, then those of faces that
// cross because of that, until none is left (every vertex at its old place at the latest, which is
// no worse than before). Returns the number of vertices that returned.
size_t UndoCollisions(std::span<const Eigen::Vector3i> faces,
                      const std::vector<Eigen::Vector3d>& before,
                      std::vector<Eigen::Vector3d>* after, const RunContext& context);

}  // namespace lsmvs
