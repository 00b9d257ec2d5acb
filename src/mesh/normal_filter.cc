#include "lsmvs/mesh/normal_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "lsmvs/mesh/by_vertex.h"
#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr size_t kFacesPerBlock = 4096, kVerticesPerBlock = 8192;
// Steps of the vertices towards the filtered normals. More change little.
constexpr int kVertexSteps = 10;

std::vector<uint8_t> VerticesThatStay(const TriangleMesh& mesh) {
  std::vector<uint8_t> stays(mesh.vertices.size(), 0);
  ForEdges(SortedHalfEdges(mesh.faces, mesh.vertices.size()),
           [&](const HalfEdge* first, const HalfEdge* last) {
             if (last - first == 2) return;
             stays[static_cast<size_t>(first->low)] = 1;
             stays[static_cast<size_t>(first->high)] = 1;
           });
  return stays;
}

Eigen::Vector3f Unit(const Eigen::Vector3f& sum, const Eigen::Vector3f& otherwise) {
  const float length = sum.norm();
  return length > 0 ? Eigen::Vector3f(sum / length) : otherwise;
}

class NormalFilter {
 public:
  NormalFilter(const NormalFilterOptions& options, const std::vector<double>& limits,
               const RunContext& context, TriangleMesh* mesh)
      : options_(options),
        limits_(limits),
        context_(context),
        mesh_(*mesh),
        start_(mesh->vertices),
        moved_(mesh->vertices),
        stays_(VerticesThatStay(*mesh)),
        corners_(CornersByVertex(mesh->vertices.size(), mesh->faces)),
        faces_(mesh->faces.size()),
        guides_(mesh->faces.size()),
        filtered_(mesh->faces.size()) {}

  void Pass() {
    ParallelFor(context_, faces_.size(), kFacesPerBlock, [&](size_t f) { MeasureFace(f); });
    ForPatches([&](size_t f, const Patch& patch) { MeasurePatch(f, patch); });
    ForPatches([&](size_t f, const Patch& patch) { guides_[f] = MostEvenPatch(f, patch); });
    ForPatches([&](size_t f, const Patch& patch) { filtered_[f] = FilteredNormal(f, patch); });
    for (int step = 0; step < kVertexSteps; ++step) MoveVertices();
  }

 private:
  struct Face {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    float area = 0;
    // Of the faces that share a vertex with this one, and it.
    Eigen::Vector3f patch_normal = Eigen::Vector3f::Zero();
    float unevenness = 0;
  };
  using Patch = std::vector<size_t>;

  // Calls visit(f, patch of f) for all faces.
  template <class Visit>
  void ForPatches(const Visit& visit) {
    ParallelBlocks(context_, faces_.size(), kFacesPerBlock, [&](size_t begin, size_t end) {
      Patch patch;
      for (size_t f = begin; f < end; ++f) {
        patch.clear();
        for (const int v : mesh_.faces[f]) {
          for (const uint32_t corner : corners_.Of(static_cast<size_t>(v))) {
            patch.push_back(corner / 3);
          }
        }
        std::sort(patch.begin(), patch.end());
        patch.erase(std::unique(patch.begin(), patch.end()), patch.end());
        visit(f, patch);
      }
    });
  }

  void MeasureFace(size_t f) {
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, f);
    const double length = normal.norm();
    faces_[f].area = static_cast<float>(0.5 * length);
    faces_[f].normal = length > 0 ? Eigen::Vector3f((normal / length).cast<float>())
                                  : Eigen::Vector3f(Eigen::Vector3f::Zero());
  }

  void MeasurePatch(size_t f, const Patch& patch) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float area = 0, deviation = 0;
    for (const size_t g : patch) sum += faces_[g].area * faces_[g].normal;
    faces_[f].patch_normal = Unit(sum, faces_[f].normal);
    for (const size_t g : patch) {
      area += faces_[g].area;
      deviation += faces_[g].area * (faces_[g].normal - faces_[f].patch_normal).norm();
    }
    // Without area it says nothing of the faces around.
    faces_[f].unevenness = area > 0 ? deviation / area : std::numeric_limits<float>::infinity();
  }

  uint32_t MostEvenPatch(size_t f, const Patch& patch) const {
    size_t best = f;
    for (const size_t g : patch) {
      if (faces_[g].unevenness < faces_[best].unevenness) best = g;
    }
    return static_cast<uint32_t>(best);
  }

  Eigen::Vector3f FilteredNormal(size_t f, const Patch& patch) const {
    const Eigen::Vector3d center = Center(f);
    const auto squared_distance = [&](size_t g) { return (Center(g) - center).squaredNorm(); };
    double spread = 0;
    for (const size_t g : patch) spread += squared_distance(g);
    spread /= static_cast<double>(std::max<size_t>(patch.size() - 1, 1));
    if (spread == 0) return faces_[f].normal;
    const Eigen::Vector3f& guide = faces_[guides_[f]].patch_normal;
    const double difference = options_.normal_difference * options_.normal_difference;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const size_t g : patch) {
      const auto turn =
          static_cast<double>((faces_[guides_[g]].patch_normal - guide).squaredNorm());
      const double alike = std::exp(-0.5 * (squared_distance(g) / spread + turn / difference));
      sum += faces_[g].area * static_cast<float>(alike) * faces_[g].normal;
    }
    return Unit(sum, faces_[f].normal);
  }

  // A step that turns the faces around each vertex towards their filtered normals.
  void MoveVertices() {
    ParallelFor(context_, moved_.size(), kVerticesPerBlock, [&](size_t v) {
      const auto corners = corners_.Of(v);
      if (stays_[v] || corners.empty()) return;
      Eigen::Vector3d step = Eigen::Vector3d::Zero();
      for (const uint32_t corner : corners) {
        const Eigen::Vector3d normal = filtered_[corner / 3].cast<double>();
        step += normal * normal.dot(Center(corner / 3) - mesh_.vertices[v]);
      }
      const Eigen::Vector3d way =
          mesh_.vertices[v] + step / static_cast<double>(corners.size()) - start_[v];
      const double length = way.norm();
      moved_[v] = start_[v] + (length > limits_[v] ? limits_[v] / length : 1.0) * way;
    });
    mesh_.vertices.swap(moved_);
  }

  Eigen::Vector3d Center(size_t f) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int v : mesh_.faces[f]) sum += mesh_.vertices[static_cast<size_t>(v)];
    return sum / 3;
  }

  const NormalFilterOptions& options_;
  const std::vector<double>& limits_;
  const RunContext& context_;
  TriangleMesh& mesh_;
  const std::vector<Eigen::Vector3d> start_;
  std::vector<Eigen::Vector3d> moved_;
  const std::vector<uint8_t> stays_;
  const ByVertex corners_;
  std::vector<Face> faces_;
  std::vector<uint32_t> guides_;  // #F: the face whose patch says the normal around a face
  std::vector<Eigen::Vector3f> filtered_;
};

}  // namespace

void FilterNormals(const NormalFilterOptions& options, const std::vector<double>& limits,
                   const RunContext& context, TriangleMesh* mesh) {
  const bool may_move = std::any_of(limits.begin(), limits.end(), [](double l) { return l > 0; });
  if (options.num_passes == 0 || mesh->faces.empty() || !may_move) return;
  NormalFilter filter(options, limits, context, mesh);
  for (int pass = 0; pass < options.num_passes; ++pass) filter.Pass();
}

std::vector<double> ShortestEdges(const TriangleMesh& mesh) {
  std::vector<double> lengths(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<size_t>(face[k]), b = static_cast<size_t>(face[(k + 1) % 3]);
      const double length = (mesh.vertices[a] - mesh.vertices[b]).norm();
      for (const size_t v : {a, b}) lengths[v] = std::min(lengths[v], length);
    }
  }
  return lengths;
}

}  // namespace lsmvs
