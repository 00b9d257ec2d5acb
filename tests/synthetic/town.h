#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct TownOptions {
  double num_points = 1e6;  // of the cloud, about
  double gsd = 0.13;        // metres per pixel; a point for every two pixels
  double noise_px = 0.4;    // standard deviation along each axis
  double outlier_fraction = 0.02;
  uint64_t seed = 0;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

// A town on rolling ground, seen from the air: square lots of kLot metres with a house each.
// Everything follows from a lot's number, so that a town of any size is made lot by lot. The ground
// is linear on the triangles of a grid of 1 m, houses stand on whole cells: the truth is a mesh and
// exact. Units: metres.
class Town {
 public:
  static constexpr int kLot = 20;

  explicit Town(const TownOptions& options);
  // Of so many lots, whatever `options.num_points` says.
  Town(const TownOptions& options, int lots_per_side);

  int lots_per_side() const { return lots_per_side_; }
  double side() const { return static_cast<double>(kLot) * lots_per_side_; }

  double GroundHeight(double x, double y) const;
  // The house of the lot in column i, row j.
  const Eigen::AlignedBox3d& House(int i, int j) const {
    return houses_[static_cast<size_t>(j) * static_cast<size_t>(lots_per_side_) +
                   static_cast<size_t>(i)];
  }
  // Of a point over ground and houses; 0 within half a metre of a house's walls and below its roof.
  double HeightAbove(const Eigen::Vector3d& x) const;
  // Whether a house stands between the two.
  bool Hides(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  // Nadir and oblique views from a grid of stations, without photos. 5 for each 90 m x 70 m.
  Scene MakeViews() const;
  // The points on the lot that two or more views see, with up to kMaxViews of them each. `views`:
  // as made by MakeViews.
  VisibilityCloud SampleLot(int lot, const Scene& views) const;
  static constexpr size_t kMaxViews = 6;

  // The surface of the lots [begin, end) x [begin, end).
  TriangleMesh Mesh(int begin, int end) const;

 private:
  double GroundAtCorner(int x, int y) const;
  Eigen::AlignedBox3d MakeHouse(int i, int j) const;

  TownOptions options_;
  int lots_per_side_;
  std::vector<Eigen::AlignedBox3d> houses_;
};

// Hands the cloud over lot by lot, in an order in which neighbours are far apart, as clouds that
// are fused photo by photo are. Same bytes for any number of threads; memory does not grow with the
// town.
void SampleTown(const Town& town, const Scene& views, const RunContext& context,
                const CloudSink& sink);

struct TownWorkspace {
  uint64_t num_points = 0;
  int num_views = 0;
  int truth_begin = 0, truth_end = 0;  // lots along each side that gt_mesh.ply holds
};

// Writes a dense workspace without photos: fused.ply, fused.ply.vis, the sparse model without
// points, and gt_mesh.ply, the truth of the middle `truth_lots` lots along each side.
TownWorkspace WriteTown(const std::filesystem::path& folder, const Town& town, int truth_lots,
                        const RunContext& context);

}  // namespace lsmvs
