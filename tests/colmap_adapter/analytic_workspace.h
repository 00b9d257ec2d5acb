#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/sparse_model.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// A surface in closed form.
class AnalyticSurface {
 public:
  virtual ~AnalyticSurface() = default;
  // Smallest t > 0 with origin + t * direction on the surface.
  virtual std::optional<double> Intersect(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction) const = 0;
  // Outwards, unit length, for a point on the surface.
  virtual Eigen::Vector3d Normal(const Eigen::Vector3d& x) const = 0;
  // Positive outside.
  virtual double SignedDistance(const Eigen::Vector3d& x) const = 0;
};

// The plane z = 0 seen from z > 0, and the unit sphere.
std::unique_ptr<AnalyticSurface> MakePlane();
std::unique_ptr<AnalyticSurface> MakeSphere();

// A small dense workspace on disk: six views, textured photos (PNG, 320 x 240), sparse points with
// tracks, fusion.cfg.
struct AnalyticWorkspace {
  DenseWorkspace workspace;
  SparseModel model;  // images in an order that is neither that of ids nor of names
  Scene scene;

  // The true map at the pixel centres of a level: (320, 240) or smaller.
  DepthMap TrueDepthMap(const AnalyticSurface& surface, int view_idx, int width, int height) const;
};

// Cameras stand on one side (a slant of about 35 degrees in all of them, so that errors along the
// image axes do not cancel).
AnalyticWorkspace MakeAnalyticWorkspace(const std::filesystem::path& folder,
                                        const AnalyticSurface& surface, bool with_rigs = false);

}  // namespace lsmvs
