#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/geometry/posed_camera.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

enum class RenderStyle {
  kShaded,   // clay under soft light with ambient occlusion
  kColor,    // texture or vertex colours as they are (clay where there are none)
  kLit,      // the same under the soft light
  kNormals,  // normals in the camera frame as colours
  kDepth,    // near light, far dark
};

struct RenderOptions {
  RenderStyle style = RenderStyle::kShaded;
  // Rays a pixel are the square of this.
  int antialiasing = 3;
  // Rays for ambient occlusion a primary ray; 0 switches it off.
  int num_occlusion_rays = 6;
  // Radius of the ambient occlusion as a share of the mesh's diagonal.
  double occlusion_radius = 0.05;
  // Interpolates normals over the faces; false shows the facets.
  bool smooth = false;
  // Grey level of the background; it is a little darker at the bottom. White is 255.
  int background = 245;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// Where on its circle a turntable camera stands.
struct TurntableOptions {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // axis of the turntable; not zero
  // Azimuth 0 looks against this direction; made perpendicular to `up`. Zero: any direction.
  Eigen::Vector3d front = Eigen::Vector3d::Zero();
  double azimuth_deg = 0;
  double elevation_deg = 20;  // over the horizon
  double fit_share = 1;       // of the points that must be in the image: less ignores far outliers
  int width = 1280, height = 960;
};

// A viewpoint on a circle around the points (a mesh's vertices) from which they fill the image.
// Points that are not finite are ignored.
PosedCamera TurntableViewpoint(const std::vector<Eigen::Vector3d>& points_in_world,
                               const TurntableOptions& options);

// Renders a mesh as seen from a viewpoint; the image has the camera's size. Faces are seen from
// both sides. `tracer` is that of `mesh`; `texture`, if not null, is that of a textured mesh with
// the same faces, and counts instead of vertex colours. Deterministic for any number of threads.
// O(pixels * antialiasing^2 * (1 + occlusion rays) * log F).
ColorImage RenderMesh(const TriangleMesh& mesh, const MeshTracer& tracer,
                      const PosedCamera& viewpoint, const RenderOptions& options,
                      const RunContext& context, const TexturePages* texture = nullptr);

}  // namespace lsmvs
