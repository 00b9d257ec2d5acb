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
  // Cells are twice the mean edge long. O(#F); 24 bytes a face, and 8 bytes a face and cell that it
  // touches. Where neighbouring faces have neighbouring numbers, they lie together in memory, too.
  // Where there is a `before`, vertices may later return to their places there.
  FaceGrid(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3i> faces,
           std::span<const Eigen::Vector3d> before = {});

  // Pairs of faces (lower index first, ascending) that cross each other and of which at least one
  // has `moved[f]`. Faces that share an edge are not looked at: they meet there. Of faces that
  // share a vertex, the edge opposite of it may cross the other face.
  std::vector<std::pair<int32_t, int32_t>> CrossingPairs(const std::vector<uint8_t>& moved,
                                                         const RunContext& context) const;

 private:
  using Cell = Eigen::Array3i;
  using Pairs = std::vector<std::pair<int32_t, int32_t>>;
  struct Box {
    Eigen::Array3f min, max;
    bool Meets(const Box& other) const {
      bool meets = true;
      for (int k = 0; k < 3; ++k) meets &= (min[k] <= other.max[k]) & (other.min[k] <= max[k]);
      return meets;
    }
  };
  struct Cells {
    Cell low, high;  // inclusive
  };

  Box BoxOf(const Eigen::Vector3i& face) const;
  Cells CellsOf(const Box& box) const;
  // Calls visit(bucket) for each cell that a box touches.
  template <class Visit>
  void ForBuckets(const Box& box, const Visit& visit) const;
  size_t BucketOf(const Cell& cell) const;

  // Numbers blocks of cells in the order in which they are first asked for.
  class BlockNumbers {
   public:
    // Of the block; a new one if it has none yet.
    uint32_t Add(const Cell& block);
    // Of a block that has one.
    uint32_t Find(const Cell& block) const;
    uint32_t size() const { return size_; }

   private:
    static constexpr uint32_t kNone = 0xffffffff;
    struct Entry {
      Cell block;
      uint32_t number = kNone;
    };
    // The entry of the block, or the empty one where it belongs.
    size_t Place(const Cell& block) const;
    void Grow();

    std::vector<Entry> entries_;  // open addressing; a power of two
    uint32_t size_ = 0;
  };

  // Of the cells that both faces touch, if there are any: so that a pair is looked at once.
  size_t FirstCommonBucket(int32_t a, int32_t b) const;
  bool MayCross(int32_t a, int32_t b) const;
  bool Cross(int32_t a, int32_t b) const;
  // By looking into every cell, or at the cells of every moved face.
  struct BucketBoxes;
  void FindInBucket(size_t bucket, const std::vector<uint8_t>& moved, BucketBoxes* boxes,
                    Pairs* found) const;
  Pairs PairsOfBuckets(const std::vector<uint8_t>& moved, const RunContext& context) const;
  Pairs PairsOfFaces(const std::vector<uint8_t>& moved, const RunContext& context) const;
  static Pairs Joined(const std::vector<Pairs>& blocks);

  std::span<const Eigen::Vector3d> vertices_, before_;
  std::span<const Eigen::Vector3i> faces_;
  Eigen::Vector3d origin_;
  float cells_per_length_ = 0;
  BlockNumbers blocks_;
  std::vector<Box> boxes_;  // #F, relative to the origin
  // A bucket for each cell of each block: the faces of bucket k are members_[begins_[k] ..
  // begins_[k + 1]), ascending.
  std::vector<uint32_t> begins_;
  std::vector<int32_t> members_;
};

// Whether two faces cross: an edge of one passes through the inside of the other. Faces that only
// touch, or lie in one plane, do not cross.
bool FacesCross(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& a,
                const Eigen::Vector3i& b);

}  // namespace lsmvs
