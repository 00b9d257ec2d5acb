#pragma once

#include <cstddef>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct VisibilityWeightOptions {
  // Uncertainty of a vertex along its rays, in units of the lengths of the edges around it. Raising
  // it smooths and closes over noise, but rounds detail and thin parts off.
  double distance_sigma_factor = 0.8;
  // How far behind a vertex, in units of its sigma, the inside is supported. Raising it thickens
  // thin parts.
  double sink_distance_factor = 0.5;
  // Weight of the shape of facets against one seen point. Raising it gives smoother surfaces and
  // less detail.
  double quality_regularization = 0.7;
  // Of what a sight says of the space behind it, against that before it.
  double sink_weight = 1;
};

struct RayCounters {
  size_t num_rays = 0;
  size_t num_crossings = 0;  // facets crossed; where rays go one way together, once
  size_t num_lost_rays = 0;

  void Add(const RayCounters& other) {
    num_rays += other.num_rays;
    num_crossings += other.num_crossings;
    num_lost_rays += other.num_lost_rays;
  }
};

// Fills the capacities of the complex' cells from what the views saw (method of
// visibility_mesher.h). For a sight with weight w of the vertex p by a view:
//  - each facet that the segment from p to the view's centre crosses at distance d from p gets
//    w (1 - exp(-d^2 / (2 sigma^2))) in the direction from the view to p;
//  - the cell that holds the centre is tied to the source; if the ray leaves the hull, the cell at
//  infinity gets w from it;
//  - the cell at sink_distance_factor * sigma behind p gets sink_weight * w to the sink.
// Every facet between tetrahedra gets quality_regularization * (1 - min(cos phi, cos psi)) in both
// directions, phi and psi the angles that its plane makes with the circumspheres of its two cells.
// Weights are added as integers and saturate at CutNode::kMaxCapacity, so that the sums do not
// depend on their order.
RayCounters WeighCells(const Scene& scene, const MergedCloud& cloud,
                       const VisibilityWeightOptions& options, const RunContext& context,
                       Tetrahedralization* complex);

// Per vertex distance_sigma_factor times the distance of the fourth nearest of its neighbours in
// the complex (of the farthest if it has fewer); canonical units. O(cells).
std::vector<float> VertexSigmas(const Tetrahedralization& complex, double distance_sigma_factor,
                                const RunContext& context);

}  // namespace lsmvs
