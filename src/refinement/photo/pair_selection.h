#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/photo/surface_warp.h"
#include "lsmvs/refinement/regions/face_regions.h"
#include "lsmvs/scene/depth_tolerance.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Ordered pair of views (i, j): j is compared with i in the pixels of i.
struct ViewPair {
  int i = -1, j = -1;
};

// Of pairs that are sorted by i: those of view i.
std::span<const ViewPair> PairsOfView(std::span<const ViewPair> pairs, int i);

struct PairSelectionOptions {
  int max_pairs_per_face = 6;
  double min_angle_deg = 2.0;
  double max_angle_deg = 50.0;
  // The error of a depth falls with the angle, the likeness of the photos too.
  double best_angle_deg = 25.0;
  double depth_tolerance = kDefaultDepthTolerance;
  // Views that see a face at a steeper angle than this do not judge it.
  double min_cosine = 0.2;
  size_t map_budget_bytes = size_t{1} << 30;  // for the depth maps
};

// Which pairs judge which face.
struct FacePairs {
  std::vector<ViewPair> pairs;  // candidates, sorted by i
  int per_face = 0;
  // #F * per_face: positions in `pairs`, best first, -1 where there are fewer.
  std::vector<int32_t> of_face;
  // #F: length in the world of one pixel on the face, mean over the views of its pairs; 0 where no
  // pair sees it.
  std::vector<float> pixel_size;
  // #F: square pixels of the face in the best of its pairs: of the pair's two views the smaller. 0
  // where no pair sees it.
  std::vector<float> area_px;

  bool Seen(size_t face) const { return of_face[face * static_cast<size_t>(per_face)] >= 0; }
};

// Pairs of the faces of some regions that follow each other, face by face in the order of the
// regions; as FacePairs.
struct BlockPairs {
  std::vector<int32_t> of_face;
  std::vector<float> pixel_size, area_px;
};

// The selection below, block by block: an item is a block of regions. Refers to what it is made
// with. Thread-safe, but for Store() of the same item.
class PairSelection {
 public:
  // `used`: null, or as in SelectOtherFacePairs.
  PairSelection(const std::vector<PosedCamera>& views, const std::vector<ViewPair>& candidates,
                const TriangleMesh& mesh, const FaceRegions& regions, const FacePairs* used,
                const PairSelectionOptions& options, const RunContext& context);
  ~PairSelection();
  PairSelection(const PairSelection&) = delete;
  PairSelection& operator=(const PairSelection&) = delete;

  size_t num_items() const;
  BlockPairs Select(size_t item);
  // Throws std::out_of_range for a block of another size.
  void Store(size_t item, const BlockPairs& block, FacePairs* result) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Chooses pairs region by region, so that what a pair judges is connected and can be worked on in
// tiles. The pairs of a region are those with the largest sum over its faces of parallax *
// resolution * cosine, over the faces that both views see (judged by depth maps at a quarter of the
// views' resolution). A face takes those of its region's pairs that see it, or else the best that
// does. Deterministic. O(#F * (views + pairs) that have its region in the picture + regions *
// (views
// + pairs)). Depth maps take 1/16 of the views' pixels and are drawn again where they do not fit
// the budget.
FacePairs SelectFacePairs(const std::vector<PosedCamera>& views,
                          const std::vector<ViewPair>& candidates, const TriangleMesh& mesh,
                          const FaceRegions& regions, const PairSelectionOptions& options,
                          const RunContext& context);

// The same, but pairs that judge a face of the region in `used`, in either order, come last: they
// are taken only where there are no others.
FacePairs SelectOtherFacePairs(const std::vector<PosedCamera>& views,
                               const std::vector<ViewPair>& candidates, const TriangleMesh& mesh,
                               const FaceRegions& regions, const FacePairs& used,
                               const PairSelectionOptions& options, const RunContext& context);

}  // namespace lsmvs
