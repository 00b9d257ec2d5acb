#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"

namespace lsmvs {

// All points of a cloud in some places of a scene, to learn from how densely they lie.
struct CloudSample {
  // A cube of space with the points in it and some pixels around it.
  struct Place {
    Eigen::AlignedBox3f cube;
    VisibilityCloud points;
  };

  uint64_t num_points = 0, num_view_entries = 0;  // of the whole cloud
  std::vector<Place> places;
};

// Takes such a sample of points that come one after the other, in any order. The places are cubes
// of a grid, kCubePixels wide, chosen by a hash: those of the lowest hashes whose points are about
// kMaxPoints together. So they are a random choice of all cubes that hold points, and the same for
// any order of the points up to the width, which is measured by the sparse points or, without, by
// the first points. Memory: that of the sample. About 10 ns per point.
class CloudSampler {
 public:
  static constexpr double kCubePixels = 64, kMarginPixels = 6;
  static constexpr size_t kMaxPoints = 60000;

  // Points outside of `box`, which is in the scene's world without its offset, are not counted;
  // an empty box holds all. `scene` outlives the sampler.
  CloudSampler(const Scene& scene, const Eigen::AlignedBox3d& box);

  void Add(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
           std::span<const uint32_t> views);
  CloudSample Take();

 private:
  using Cell = std::array<int32_t, 3>;

  void SetCubeSize(double pixel_size);
  void MeasureFirst();
  void AddToPlaces(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                   std::span<const uint32_t> views);
  void AddTo(const Cell& cell, const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
             std::span<const uint32_t> views);
  void DropHalf();

  const Scene& scene_;
  const Eigen::AlignedBox3d box_;
  float cube_size_ = 0, margin_ = 0;  // 0: not known yet
  VisibilityCloud first_;             // until it is
  uint64_t max_hash_ = ~uint64_t{0};  // cubes of higher ones are not chosen
  std::map<Cell, VisibilityCloud> places_;
  size_t num_in_places_ = 0;
  CloudSample sample_;
};

}  // namespace lsmvs
