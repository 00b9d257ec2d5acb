#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lsmvs/evaluation/atlas_figures.h"
#include "lsmvs/evaluation/cloud_figures.h"
#include "lsmvs/evaluation/depth_errors.h"
#include "lsmvs/evaluation/photometric_score.h"
#include "lsmvs/evaluation/silhouettes.h"
#include "lsmvs/evaluation/surface_evaluator.h"
#include "lsmvs/evaluation/texture_score.h"
#include "lsmvs/mesh/inspect.h"

namespace lsmvs {

// All that was measured on one mesh or cloud.
struct MeshFigures {
  std::string name;
  std::optional<MeshInspection> inspection;  // of meshes
  std::optional<CloudFigures> cloud;         // of clouds
  std::optional<SurfaceEvaluation> surface;  // with a truth
  std::optional<DepthErrors> depth_errors;   // with a truth and views
  std::optional<PhotometricScore> photometric;
  std::optional<SilhouetteFigures> silhouettes;  // of meshes with views
  std::optional<TextureScore> texture;           // texture or vertex colours on the photos
  std::optional<AtlasFigures> atlas;             // of textured meshes
};

// One JSON object, indented; distances in world units and, where a GSD is known, in GSD. Keys are
// stable: scripts read them.
std::string ToJson(const MeshFigures& figures);
// Tables for people.
std::string ToTable(const MeshFigures& figures);

}  // namespace lsmvs
