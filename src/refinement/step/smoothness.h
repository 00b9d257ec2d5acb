#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/mesh/vertex_rings.h"
#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct SmoothnessOptions {
  double weight = 1.0;    // of the thin plate, lengths in pixels
  double membrane = 0.0;  // relative to it
  LaplacianWeights laplacian = LaplacianWeights::kUniform;
};

// Thin-plate energy of a surface whose vertices are displaced by x_v pixels along their directions
// n_v, linearised:
//   E(x) = weight * sum over inner vertices of A_v (4 r_v / h_v^2)^2 (+ membrane), with
//   r_v = n_v . (mean of the neighbours - vertex) in pixels after displacement,
// h_v the mean edge length and A_v = sqrt(3)/2 h_v^2 the area at v, in pixels: on a regular mesh 4
// r / h^2 is the Laplacian, so that E is the integral of its square, whatever the size of the
// triangles. "Pixels" are those of `pixel_size`. Vertices on the border have no term of their own
// (free edges of the plate).
class Smoothness {
 public:
  // `mesh` gives the topology; it is not kept.
  Smoothness(const TriangleMesh& mesh, const SmoothnessOptions& options);

  // Multiples of the weight by vertex (#V); 1 until they are set. They count from the next
  // SetGeometry on.
  void SetFactors(std::vector<float> factors) { factors_ = std::move(factors); }

  // Takes the geometry: #V positions, unit directions and pixel sizes (> 0). Before all that
  // follows.
  void SetGeometry(const std::vector<Eigen::Vector3d>& positions,
                   const std::vector<Eigen::Vector3d>& directions,
                   const std::vector<double>& pixel_size, const RunContext& context);

  // Energy at x = 0 of each vertex' own term (#V).
  std::vector<double> Energies() const;
  // (4 r_v / h_v^2)^2 at x = 0 (#V), in 1 / pixel^2, whatever the weights; 0 on the border.
  std::vector<double> SquaredLaplacians() const;
  // dE/dx at x = 0 (#V).
  std::vector<double> Gradient(const RunContext& context) const;
  // (d2E/dx2) x. `scratch` keeps memory between calls.
  void ApplyHessian(const std::vector<double>& x, const RunContext& context,
                    std::vector<double>* scratch, std::vector<double>* result) const;
  std::vector<double> HessianDiagonal() const;

  const VertexRings& rings() const { return rings_; }

 private:
  void SetWeights(const std::vector<Eigen::Vector3d>& positions);
  // Entry v of the transposed Jacobian of the r times `forces`.
  double Transposed(const std::vector<double>& forces, size_t v) const;
  size_t First(size_t v) const { return static_cast<size_t>(rings_.begin[v]); }

  SmoothnessOptions options_;
  VertexRings rings_;
  std::vector<Eigen::Vector3i> faces_;  // only for cotangent weights
  std::vector<float> factors_;          // of the weight; empty: 1
  std::vector<float> edge_weights_;     // as rings_.neighbors; symmetric
  std::vector<float> couplings_;        // as rings_.neighbors: d r_v / d x_j
  std::vector<float> transposed_;       // as rings_.neighbors: d r_j / d x_v
  std::vector<float> membrane_;    // as rings_.neighbors: -d2E/dx_v dx_j of the membrane; or empty
  std::vector<double> residuals_;  // r_v at x = 0
  std::vector<double> stiffness_;  // factor of r_v^2
  std::vector<float> length_px_;   // h_v; 0 on the border
  std::vector<double> membrane_gradient_, membrane_diagonal_;
};

}  // namespace lsmvs
