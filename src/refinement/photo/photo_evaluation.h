#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "lsmvs/refinement/photo/photo_energy.h"

namespace lsmvs {

// Sums over the pixels of one face in one view. With p(y) a quantity per pixel, d its depth and r
// its ray (z = 1), the moments sum p d^k r are what the derivatives by the face's three vertices
// need.
struct FaceSums {
  Eigen::Vector3f slope = Eigen::Vector3f::Zero();      // of dE/dd d^2 r; later gradients by vertex
  Eigen::Vector3f curvature = Eigen::Vector3f::Zero();  // of d2E/dd2 d^3 r; later by vertex
  float error = 0, mass = 0, pixels = 0;
};

// What one view adds, for the faces that it judges in ascending order.
struct ViewContribution {
  std::vector<int32_t> faces;
  std::vector<FaceSums> sums;  // as faces; derivatives by the face's vertices
};

// One evaluation of the photo energy, view by view: an item is a view that judges faces. Refers to
// what it is made with; arguments are those of EvaluatePhotoTerms. Thread-safe.
class PhotoEvaluation {
 public:
  PhotoEvaluation(const ImageStore& images, const std::vector<PosedCamera>& views,
                  const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& directions,
                  const FacePairs& pairs, const std::vector<uint8_t>& active,
                  const PhotoEnergyOptions& options, const RunContext& context);
  ~PhotoEvaluation();
  PhotoEvaluation(const PhotoEvaluation&) = delete;
  PhotoEvaluation& operator=(const PhotoEvaluation&) = delete;

  // In an order in which views that share depth maps come close to each other.
  size_t num_items() const;
  ViewContribution Evaluate(size_t item);
  // The item is done, here or elsewhere, and not evaluated again: once for each. Depth maps that no
  // other item needs are dropped.
  void End(size_t item);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lsmvs
