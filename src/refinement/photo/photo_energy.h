#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/refinement/photo/surface_warp.h"
#include "lsmvs/refinement/photo/window_correlation.h"
#include "lsmvs/scene/depth_tolerance.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct PhotoEnergyOptions {
  CorrelationOptions correlation;
  double depth_tolerance = kDefaultDepthTolerance;
  int level = 0;                              // of the image store
  size_t map_budget_bytes = size_t{1} << 30;  // for depth and face maps
};

// Photo-consistency of a mesh and how it changes when vertices move along given directions.
struct PhotoTerms {
  // #V: derivative of the total error by the displacement of the vertex along its direction, in 1 /
  // world unit.
  std::vector<double> gradient;
  // #V: row sums of the Gauss-Newton matrix of the total error, in 1 / world unit^2; >= 0.
  std::vector<double> curvature;
  // #F: sum of 1 - ZNCC over the pixels of the face in all its pairs, and the number of those
  // pixels, each weighted by the texture around it (0..1); pixels that the other view does not see
  // count 0.
  std::vector<float> error, mass;
  // #F: the number of pixels of the face in all its pairs, whether seen by the other view or not.
  std::vector<float> pixels;

  double TotalError() const;
  double TotalMass() const;
};

// Robust error over mass of photos that have nothing in common, ZNCC about -0.2.
inline constexpr double kUnlikePhotoError = 0.35;
// Mass over pixels from which on texture tells all that there is to tell.
inline constexpr double kFullMassShare = 0.5;

// Sum over the faces' pairs (i, j), over the pixels of i that show the face, of 1 - ZNCC(i, j
// through the surface), for faces with `active[f]` != 0 (empty: all). `directions` (#V, unit
// length) say which displacements to differentiate by; if empty, gradient and curvature are left
// out. The gradient is exact up to the change of what is visible. Deterministic: views are worked
// on in parallel and added up in their order.
PhotoTerms EvaluatePhotoTerms(const ImageStore& images, const std::vector<PosedCamera>& views,
                              const TriangleMesh& mesh,
                              const std::vector<Eigen::Vector3d>& directions,
                              const FacePairs& pairs, const std::vector<uint8_t>& active,
                              const PhotoEnergyOptions& options, const RunContext& context);

}  // namespace lsmvs
