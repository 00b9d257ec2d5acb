#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct FusionOptions {
  // Views (the reference included) that must agree on a point; views from one place count once.
  int min_num_pixels = 3;
  // Views that are averaged into one point at most.
  int max_num_pixels = 10000;
  // Maximum forward-backward error [px] for a pixel to join a point.
  double max_reproj_error = 2.0;
  // Relative difference of depth within which a pixel joins a point.
  double max_depth_error = 0.01;
  // Degrees between normals within which a pixel joins a point. Much looser than COLMAP's 10: it
  // keeps the two sides of a thin part apart, but where a surface is rough or seen at an angle the
  // normals of good depths scatter far more than their positions.
  double max_normal_error = 90.0;
  // One view less than min_num_pixels is enough (but never one alone) where views agree within so
  // many pixels and no view sees through the point, so that borders of the scene, which few views
  // see, are not lost. Such pixels must hang together over the area of 11 x 11 pixels. 0: never.
  // Lower is cleaner.
  double weak_max_reproj_error = 2.0;
  // Views checked a reference view, nearest first.
  int check_num_images = 50;
  // Points outside are dropped. In the world of the files (Scene::world_offset is handled). Empty:
  // no limit.
  Eigen::AlignedBox3d bounding_box;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Depth maps -> points with the views that see them.
//
// Each pixel of each view is projected into the neighbouring views. A view agrees when the depth
// and normal of its map there fit (errors above). A pixel with enough agreeing views gives a point,
// unless it is covered: a view of lower index agrees, and the point of that view's pixel lies in
// this one. So of pixels that see the same place equally finely one gives the point; where the
// lower view is coarser, the finer pixels between its points give theirs, too. Each agreeing map
// gives its own depth along the reference's ray (the intersection with its plane); the point lies
// at the weighted median-centred mean of those depths: no lateral shift. Normals and colours are
// averaged. The agreeing views are the point's views. Masked pixels neither give nor join a point.
//   neighbors  as for the depth maps, one list per view; lists are made symmetric inside
// The points of a view depend on the maps and photos of that view and its neighbours only, not on
// other points. The cloud goes to `sink` in parts, by view and row. Deterministic for any number of
// threads. Memory: the points and evidence of one reference view, the maps and colour images of it
// and one neighbour plus what the caches hold (of colour images: a dozen); not the cloud.
// O(pixels x neighbours).
void FuseDepthMaps(const Scene& scene, const ImageStore& images,
                   const std::vector<std::vector<Neighbor>>& neighbors, const DepthMapSource& maps,
                   const FusionOptions& options, const CloudSink& sink, const RunContext& context);

// The same for some reference views, in ascending order: the clouds of any division of the views
// into runs of consecutive ones, one behind the other, are that of all.
void FuseViews(const Scene& scene, const ImageStore& images,
               const std::vector<std::vector<Neighbor>>& neighbors, const DepthMapSource& maps,
               std::span<const int> view_idxs, const FusionOptions& options, const CloudSink& sink,
               const RunContext& context);

// For each view, the views whose maps and photos are read to fuse it, beside its own. At most
// options.check_num_images.
std::vector<std::vector<int>> FusionNeighbors(const Scene& scene,
                                              const std::vector<std::vector<Neighbor>>& neighbors,
                                              const FusionOptions& options);

// Memory: of the largest view; depths of packed maps, see PackedDepthMap.
CostEstimate EstimateFusionCost(const Scene& scene, const ImageStore& images,
                                const FusionOptions& options);

}  // namespace lsmvs
