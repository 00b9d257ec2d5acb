#include "lsmvs/refinement/finishing/finishing.h"

#include <algorithm>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/mesh/surface_trimming.h"
#include "lsmvs/refinement/step/vertex_frames.h"

namespace lsmvs {

namespace {

// What speaks for a face about which the photos say nothing: as much as a match.
constexpr double kSilentGain = 1.0;
// How fast the error tells, against kUnlikePhotoError: at three quarters of it a face is believed
// in full.
constexpr double kSteepness = 4;

// Per square pixel, between -1 and 1.
double GainOf(double error, double mass, double pixels) {
  if (!(mass > 0) || !(pixels > 0)) return kSilentGain;
  const double told = std::min(1.0, mass / (kFullMassShare * pixels));
  const double gain =
      std::clamp(kSteepness * (kUnlikePhotoError - error / mass) / kUnlikePhotoError, -1.0, 1.0);
  return told * gain + (1 - told) * kSilentGain;
}

size_t DropContradictedEnds(const FacePairs& pairs, const PhotoTerms& terms, double border_cost,
                            TriangleMesh* mesh, const RunContext& context) {
  TrimmingProblem problem;
  problem.border_cost = border_cost;
  problem.pixel_size = MeanPixelSizes(*mesh, pairs);
  problem.keep_gain.assign(mesh->faces.size(), 0.0);
  for (size_t f = 0; f < mesh->faces.size(); ++f) {
    const double pixel = problem.pixel_size[static_cast<size_t>(mesh->faces[f][0])];
    if (!(pixel > 0)) return 0;  // no pair sees any face: nothing is contradicted
    const double area = 0.5 * FaceNormalTimesTwiceArea(*mesh, f).norm() / (pixel * pixel);
    problem.keep_gain[f] = area * GainOf(terms.error[f], terms.mass[f], terms.pixels[f]);
  }
  std::vector<uint8_t> kept = TrimSurface(*mesh, problem, context);
  KeepEnclosedFaces(*mesh, {}, &kept);
  return FilterFaces(mesh, [&](size_t f) { return kept[f] != 0; });
}

size_t DropSmallComponents(int min_faces, TriangleMesh* mesh) {
  const MeshComponents components = FindComponents(*mesh);
  return FilterFaces(mesh, [&](size_t f) {
    return components.num_faces[static_cast<size_t>(components.of_face[f])] >=
           static_cast<size_t>(min_faces);
  });
}

}  // namespace

FinishingSummary FinishSurface(const FacePairs& pairs, const PhotoTerms& terms,
                               const FinishingOptions& options, TriangleMesh* mesh,
                               const RunContext& context) {
  FinishingSummary summary;
  if (const MeshInspection inspection = Inspect(*mesh);
      !inspection.IsManifold() || !inspection.IsOriented()) {
    return summary;
  }
  if (options.border_cost > 0) {
    summary.num_dropped_faces =
        DropContradictedEnds(pairs, terms, options.border_cost, mesh, context);
    SplitNonManifoldVertices(mesh);
    if (summary.num_dropped_faces > 0) {
      summary.num_dropped_faces += DropSmallComponents(options.min_component_faces, mesh);
    }
  }
  if (options.max_hole_edges > 0) {
    HoleClosingOptions closing;
    closing.max_num_edges = options.max_hole_edges;
    summary.num_closed_holes = CloseHoles(closing, context, mesh);
  }
  RemoveUnusedVertices(mesh);
  return summary;
}

}  // namespace lsmvs
