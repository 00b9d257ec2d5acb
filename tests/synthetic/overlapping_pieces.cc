#include "lsmvs/synthetic/overlapping_pieces.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "lsmvs/mesh/repair.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs {

namespace {

constexpr double kWidth = 10, kHeight = 6;
constexpr int kNumWaves = 60;

// A sum of many plane waves: nearly Gaussian, smooth over a quarter of their length.
class SmoothNoise {
 public:
  SmoothNoise(double sigma, double correlation_length, uint64_t seed)
      : amplitude_(sigma * std::sqrt(2.0 / kNumWaves)) {
    Random random(seed);
    for (int i = 0; i < kNumWaves; ++i) {
      const double length = 4 * correlation_length * random.Uniform(0.8, 1.25);
      waves_.push_back(random.Gaussian3().normalized() * 2 * std::numbers::pi / length);
      phases_.push_back(random.Uniform(0, 2 * std::numbers::pi));
    }
  }
  double At(const Eigen::Vector3d& x) const {
    double sum = 0;
    for (size_t i = 0; i < waves_.size(); ++i) sum += std::sin(waves_[i].dot(x) + phases_[i]);
    return amplitude_ * sum;
  }

 private:
  double amplitude_;
  std::vector<Eigen::Vector3d> waves_;
  std::vector<double> phases_;
};

}  // namespace

TriangleMesh CutPiece(const TriangleMesh& whole,
                      const std::function<bool(const Eigen::Vector3d& middle)>& is_in) {
  TriangleMesh piece = whole;
  FilterFaces(&piece, [&](size_t f) {
    const Eigen::Vector3i& face = piece.faces[f];
    return is_in((piece.vertices[face[0]] + piece.vertices[face[1]] + piece.vertices[face[2]]) / 3);
  });
  RemoveUnusedVertices(&piece);
  return piece;
}

void AddNormalNoise(double sigma, double correlation_length, uint64_t seed, TriangleMesh* mesh) {
  const std::vector<Eigen::Vector3f> normals = ComputeVertexNormals(*mesh);
  Random random(seed);
  const SmoothNoise smooth(sigma, correlation_length > 0 ? correlation_length : 1, seed);
  for (size_t v = 0; v < normals.size(); ++v) {
    const double height =
        correlation_length > 0 ? smooth.At(mesh->vertices[v]) : sigma * random.Gaussian();
    mesh->vertices[v] += height * normals[v].cast<double>();
  }
}

double ReliefHeight(double x, double y) {
  return 0.5 * std::sin(1.1 * x + 0.3) * std::cos(0.9 * y) + 0.25 * std::sin(2.3 * x - 1.7 * y);
}

TriangleMesh ReliefMesh(double edge_length, uint64_t seed) {
  const int num_x = std::max(2, static_cast<int>(std::lround(kWidth / edge_length)));
  const int num_y = std::max(2, static_cast<int>(std::lround(kHeight / edge_length)));
  Random random(seed);
  TriangleMesh mesh;
  for (int j = 0; j <= num_y; ++j) {
    for (int i = 0; i <= num_x; ++i) {
      const bool inner_x = i > 0 && i<num_x, inner_y = j> 0 && j < num_y;
      const double x = kWidth / num_x * (i + (inner_x ? random.Uniform(-0.25, 0.25) : 0));
      const double y = kHeight / num_y * (j + (inner_y ? random.Uniform(-0.25, 0.25) : 0));
      mesh.vertices.emplace_back(x, y, ReliefHeight(x, y));
    }
  }
  for (int j = 0; j < num_y; ++j) {
    for (int i = 0; i < num_x; ++i) {
      const int a = j * (num_x + 1) + i, b = a + 1, c = a + num_x + 1, d = c + 1;
      if (random.Below(2) == 0) {
        mesh.faces.emplace_back(a, b, d);
        mesh.faces.emplace_back(a, d, c);
      } else {
        mesh.faces.emplace_back(a, b, c);
        mesh.faces.emplace_back(b, d, c);
      }
    }
  }
  return mesh;
}

}  // namespace lsmvs
