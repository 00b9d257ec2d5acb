#include "lsmvs/refinement/step/smoothness.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace lsmvs {

namespace {

constexpr size_t kVerticesPerBlock = 8192;
// On a regular mesh the Laplacian is 4 r / h^2 and the area of a vertex sqrt(3)/2 h^2: the factor
// of r^2 / h^2.
constexpr double kLaplacianFactor = 4.0;
constexpr double kPlateFactor = kLaplacianFactor * kLaplacianFactor * 0.8660254037844386;
// Weight of an edge of a regular mesh in its cotangent Laplacian.
constexpr float kRegularEdgeWeight = 0.57735027f;
constexpr float kMinEdgeWeight = 0.05f, kMaxEdgeWeight = 3.0f;
// Shorter edges (pixels) do not stiffen the plate further.
constexpr double kMinEdgePx = 0.5;

double Cotangent(const Eigen::Vector3d& at, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = a - at, v = b - at;
  return u.dot(v) / std::max(u.cross(v).norm(), 1e-300);
}

}  // namespace

Smoothness::Smoothness(const TriangleMesh& mesh, const SmoothnessOptions& options)
    : options_(options), rings_(BuildVertexRings(mesh)) {
  if (options.laplacian == LaplacianWeights::kCotangent) faces_ = mesh.faces;
  edge_weights_.assign(rings_.neighbors.size(), kRegularEdgeWeight);
}

void Smoothness::SetWeights(const std::vector<Eigen::Vector3d>& positions) {
  if (options_.laplacian == LaplacianWeights::kUniform) return;
  std::fill(edge_weights_.begin(), edge_weights_.end(), 0.0f);
  const auto add = [&](int32_t from, int32_t to, double cotangent) {
    const auto first = rings_.neighbors.begin() + rings_.begin[static_cast<size_t>(from)];
    const auto last = rings_.neighbors.begin() + rings_.begin[static_cast<size_t>(from) + 1];
    const auto at = std::lower_bound(first, last, to) - rings_.neighbors.begin();
    edge_weights_[static_cast<size_t>(at)] += static_cast<float>(0.5 * cotangent);
  };
  for (const Eigen::Vector3i& face : faces_) {
    for (int k = 0; k < 3; ++k) {
      const int a = face[(k + 1) % 3], b = face[(k + 2) % 3];
      const double cotangent =
          Cotangent(positions[static_cast<size_t>(face[k])], positions[static_cast<size_t>(a)],
                    positions[static_cast<size_t>(b)]);
      add(a, b, cotangent);
      add(b, a, cotangent);
    }
  }
  for (float& weight : edge_weights_) weight = std::clamp(weight, kMinEdgeWeight, kMaxEdgeWeight);
}

void Smoothness::SetGeometry(const std::vector<Eigen::Vector3d>& positions,
                             const std::vector<Eigen::Vector3d>& directions,
                             const std::vector<double>& pixel_size, const RunContext& context) {
  SetWeights(positions);
  const size_t count = positions.size();
  std::vector<float> totals(count, 0.0f);
  for (size_t v = 0; v < count; ++v) {
    for (size_t k = First(v); k < First(v + 1); ++k) totals[v] += edge_weights_[k];
  }
  couplings_.resize(rings_.neighbors.size());
  transposed_.resize(rings_.neighbors.size());
  if (options_.membrane > 0) membrane_.resize(rings_.neighbors.size());
  residuals_.assign(count, 0.0);
  stiffness_.assign(count, 0.0);
  length_px_.assign(count, 0.0f);
  membrane_gradient_.assign(count, 0.0);
  membrane_diagonal_.assign(count, 0.0);
  const double membrane = 2.0 * options_.weight * options_.membrane;
  ParallelFor(context, count, kVerticesPerBlock, [&](size_t v) {
    if (First(v) == First(v + 1)) return;
    double length = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (size_t k = First(v); k < First(v + 1); ++k) {
      const size_t j = static_cast<size_t>(rings_.neighbors[k]);
      const Eigen::Vector3d step = positions[j] - positions[v];
      const double cosine = directions[v].dot(directions[j]);
      const double ratio = pixel_size[j] / pixel_size[v];
      mean += edge_weights_[k] * step;
      length += step.norm();
      couplings_[k] = static_cast<float>(edge_weights_[k] / totals[v] * cosine * ratio);
      transposed_[k] = static_cast<float>(edge_weights_[k] / totals[j] * cosine / ratio);
      if (membrane > 0) membrane_[k] = static_cast<float>(membrane * edge_weights_[k] * cosine);
    }
    residuals_[v] = directions[v].dot(mean) / (totals[v] * pixel_size[v]);
    const double valence = static_cast<double>(First(v + 1) - First(v));
    const double h = std::max(length / valence / pixel_size[v], kMinEdgePx);
    if (!rings_.on_border[v]) {
      const double factor = factors_.empty() ? 1.0 : static_cast<double>(factors_[v]);
      stiffness_[v] = options_.weight * factor * kPlateFactor / (h * h);
      length_px_[v] = static_cast<float>(h);
    }
    membrane_diagonal_[v] = membrane * totals[v];
    membrane_gradient_[v] = -membrane_diagonal_[v] * residuals_[v];
  });
}

std::vector<double> Smoothness::Energies() const {
  std::vector<double> energies(residuals_.size());
  for (size_t v = 0; v < energies.size(); ++v) {
    energies[v] = stiffness_[v] * residuals_[v] * residuals_[v];
  }
  return energies;
}

std::vector<double> Smoothness::SquaredLaplacians() const {
  std::vector<double> result(residuals_.size(), 0.0);
  for (size_t v = 0; v < result.size(); ++v) {
    if (length_px_[v] == 0) continue;
    const double h = static_cast<double>(length_px_[v]);
    const double laplacian = kLaplacianFactor * residuals_[v] / (h * h);
    result[v] = laplacian * laplacian;
  }
  return result;
}

std::vector<double> Smoothness::Gradient(const RunContext& context) const {
  std::vector<double> forces(residuals_.size()), result(residuals_.size());
  for (size_t v = 0; v < forces.size(); ++v) forces[v] = 2.0 * stiffness_[v] * residuals_[v];
  ParallelFor(context, result.size(), kVerticesPerBlock,
              [&](size_t v) { result[v] = Transposed(forces, v) + membrane_gradient_[v]; });
  return result;
}

void Smoothness::ApplyHessian(const std::vector<double>& x, const RunContext& context,
                              std::vector<double>* scratch, std::vector<double>* result) const {
  std::vector<double>& forces = *scratch;
  forces.resize(x.size());
  result->resize(x.size());
  ParallelFor(context, x.size(), kVerticesPerBlock, [&](size_t v) {
    if (stiffness_[v] == 0) {
      forces[v] = 0;
      return;
    }
    double change = -x[v];
    for (size_t k = First(v); k < First(v + 1); ++k) {
      change += couplings_[k] * x[static_cast<size_t>(rings_.neighbors[k])];
    }
    forces[v] = 2.0 * stiffness_[v] * change;
  });
  ParallelFor(context, x.size(), kVerticesPerBlock, [&](size_t v) {
    double sum = Transposed(forces, v) + membrane_diagonal_[v] * x[v];
    if (!membrane_.empty()) {
      for (size_t k = First(v); k < First(v + 1); ++k) {
        sum -= membrane_[k] * x[static_cast<size_t>(rings_.neighbors[k])];
      }
    }
    (*result)[v] = sum;
  });
}

double Smoothness::Transposed(const std::vector<double>& forces, size_t v) const {
  double sum = -forces[v];
  for (size_t k = First(v); k < First(v + 1); ++k) {
    sum += transposed_[k] * forces[static_cast<size_t>(rings_.neighbors[k])];
  }
  return sum;
}

std::vector<double> Smoothness::HessianDiagonal() const {
  std::vector<double> diagonal(residuals_.size());
  for (size_t v = 0; v < diagonal.size(); ++v) {
    double sum = stiffness_[v];
    for (size_t k = First(v); k < First(v + 1); ++k) {
      sum += stiffness_[static_cast<size_t>(rings_.neighbors[k])] * transposed_[k] * transposed_[k];
    }
    diagonal[v] = 2.0 * sum + membrane_diagonal_[v];
  }
  return diagonal;
}

}  // namespace lsmvs
