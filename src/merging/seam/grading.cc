#include "lsmvs/merging/seam/grading.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lsmvs/merging/overlap/surface_index.h"
#include "lsmvs/mesh/remesher.h"

namespace lsmvs {

namespace {

constexpr int kMaxRounds = 14;
// A face is split when its longest edge is that much longer than it should be.
constexpr double kTolerance = 1.7;
constexpr float kSplit = 2;  // density times area of a face to be split, of which 1 is allowed

size_t Index(int32_t i) { return static_cast<size_t>(i); }

double LongestEdge(const TriangleMesh& mesh, size_t f) {
  double longest = 0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max(longest, (mesh.vertices[Index(mesh.faces[f][k])] -
                                 mesh.vertices[Index(mesh.faces[f][(k + 1) % 3])])
                                    .norm());
  }
  return longest;
}

class Refiner {
 public:
  Refiner(const SeamPoints& seam, double growth)
      : seam_(seam),
        growth_(growth),
        points_(PointFaces(seam.positions.size())),
        index_(seam.positions, points_) {}

  // Densities that make each face that is too large be split once; empty if there are none.
  std::vector<float> Densities(const TriangleMesh& mesh) const {
    std::vector<float> densities(mesh.faces.size(), 0);
    bool has_large = false;
    for (size_t f = 0; f < densities.size(); ++f) {
      const double longest = LongestEdge(mesh, f);
      const Eigen::Vector3i& face = mesh.faces[f];
      const Eigen::Vector3d middle =
          (mesh.vertices[Index(face[0])] + mesh.vertices[Index(face[1])] +
           mesh.vertices[Index(face[2])]) /
          3;
      const double reach = longest * (1 / growth_ + 1);
      const SurfaceIndex::Hit hit = index_.Closest(middle, reach);
      if (hit.face < 0) continue;
      // Of the nearest place of the face, roughly.
      const double distance = std::max(0.0, hit.distance - 0.5 * longest);
      const double wanted = std::max(seam_.edge_lengths[Index(hit.face)], growth_ * distance);
      if (longest < kTolerance * wanted) continue;
      const double area = 0.5 * FaceNormalTimesTwiceArea(mesh, f).norm();
      if (!(area > 0)) continue;
      densities[f] = static_cast<float>(kSplit / area);
      has_large = true;
    }
    if (!has_large) densities.clear();
    return densities;
  }

 private:
  const SeamPoints& seam_;
  double growth_;
  std::vector<Eigen::Vector3i> points_;
  SurfaceIndex index_;
};

bool HasAllEdges(const TriangleMesh& mesh, const std::vector<uint64_t>& edges) {
  std::vector<uint64_t> keys;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) keys.push_back(EdgeKey(face[k], face[(k + 1) % 3]));
  }
  std::sort(keys.begin(), keys.end());
  return std::includes(keys.begin(), keys.end(), edges.begin(), edges.end());
}

}  // namespace

bool RefineTowardsSeam(const SeamPoints& seam, double growth, MeshBand* band) {
  const Refiner refiner(seam, growth);
  TriangleMesh mesh = band->mesh;
  std::vector<VertexSource> sources = band->sources;
  const size_t num_old = mesh.vertices.size();
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<float> densities = refiner.Densities(mesh);
    if (densities.empty()) break;
    Remesher remesher(mesh, mesh.vertices, densities);
    // One pass: halves take the density of the whole, and are looked at anew.
    if (remesher.SplitLargeFaces(1, 1) == 0) break;
    const std::vector<int32_t> origins = remesher.Origins();
    mesh = remesher.Mesh();
    for (size_t v = sources.size(); v < origins.size(); ++v) {
      sources.push_back(VertexSource(sources[Index(origins[v])]));
    }
  }
  if (!HasAllEdges(mesh, band->cut_edges)) return false;
  const size_t num_new = mesh.vertices.size();
  if (num_new == num_old) return true;
  band->mesh = std::move(mesh);
  band->sources = std::move(sources);
  band->is_changed.resize(num_new, 1);
  band->is_preferred.resize(num_new, 0);
  band->whole_vertex.resize(num_new, -1);
  band->is_fixed.resize(num_new, 0);
  return true;
}

}  // namespace lsmvs
