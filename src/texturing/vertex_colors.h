#pragma once

#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/depth_tolerance.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct VertexColorOptions {
  // Pyramid level of the photos and depth maps: 1 is half the resolution, fast and good enough
  // where facets are larger than two pixels.
  int level = 0;
  // A vertex is hidden in a view if the surface there is nearer by more than this part of its
  // depth.
  double depth_tolerance = kDefaultDepthTolerance;
  // Best views (by resolution and angle) that vote for the colour of a vertex.
  int max_views_per_vertex = 6;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Colour of each vertex (#V) from the photos that see it: the mean of the samples that lie near
// their component-wise median, weighted by resolution and angle of sight. Vertices that no photo
// sees take the mean colour of their coloured neighbours, ring by ring, and mid grey where there
// are none. One view's photo and depth map in memory a thread. Deterministic.
std::vector<Color> ColorVertices(const Scene& scene, const ImageStore& images,
                                 const TriangleMesh& mesh, const VertexColorOptions& options,
                                 const RunContext& context);

}  // namespace lsmvs
