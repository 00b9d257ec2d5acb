#include "lsmvs/refinement/step/mesh_adaptation.h"

#include "lsmvs/mesh/remesher.h"
#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {

namespace {

// Edges below this length (pixels) are collapsed, and edges flipped, where the surface moves by
// less than kMaxDeviationPx.
constexpr double kMinEdgePx = 0.7, kMaxDeviationPx = 0.1;
// Each try keeps more of the mesh as it is; the last one neither flips nor collapses.
constexpr int kMaxTries = 6;

// Marks the vertices of the faces that have a marked one.
void Grow(const TriangleMesh& mesh, std::vector<uint8_t>* marks) {
  std::vector<uint8_t> grown = *marks;
  for (const Eigen::Vector3i& f : mesh.faces) {
    bool any = false;
    for (const int v : f) any |= (*marks)[static_cast<size_t>(v)] != 0;
    for (const int v : f) grown[static_cast<size_t>(v)] |= any;
  }
  marks->swap(grown);
}

class Adaptation {
 public:
  Adaptation(const MeshAdaptationOptions& options, const std::vector<float>& density,
             const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& rest,
             const RunContext& context)
      : options_(options),
        density_(density),
        mesh_(mesh),
        rest_(rest),
        context_(context),
        is_kept_(mesh.vertices.size(), 0) {}

  MeshAdaptation Run(TriangleMesh* mesh, std::vector<Eigen::Vector3d>* rest) {
    for (int k = 1;; ++k) {
      Remesher remesher(mesh_, rest_, density_);
      const MeshAdaptation result = Apply(k == kMaxTries, &remesher);
      TriangleMesh adapted = remesher.Mesh();
      const bool done = k == kMaxTries || result.num_flips + result.num_collapses == 0 ||
                        !KeepMoreWhereItCrosses(adapted, remesher.Origins());
      if (!done) continue;
      *rest = remesher.Rest();
      *mesh = std::move(adapted);
      return result;
    }
  }

 private:
  MeshAdaptation Apply(bool only_split, Remesher* remesher) const {
    MeshAdaptation result;
    std::vector<int32_t> kept;
    for (size_t v = 0; v < is_kept_.size(); ++v) {
      if (is_kept_[v]) kept.push_back(static_cast<int32_t>(v));
    }
    remesher->Lock(kept);
    if (options_.collapse && !only_split) {
      result.num_collapses = remesher->CollapseShortEdges(kMinEdgePx, kMaxDeviationPx);
    }
    if (options_.max_face_area_px > 0) {
      result.num_splits = remesher->SplitLargeFaces(options_.max_face_area_px);
    }
    if (options_.flip && !only_split) result.num_flips = remesher->FlipToDelaunay(kMaxDeviationPx);
    return result;
  }

  // Adds to what is kept the surroundings of faces that cross; false if nothing was added: nothing
  // crosses, or what does is as it came in.
  bool KeepMoreWhereItCrosses(const TriangleMesh& adapted, const std::vector<int32_t>& origins) {
    const std::vector<uint8_t> all(adapted.faces.size(), 1);
    const auto pairs = FaceGrid(adapted.vertices, adapted.faces).CrossingPairs(all, context_);
    std::vector<uint8_t> found(is_kept_.size(), 0);
    bool any = false;
    for (const auto& [a, b] : pairs) {
      for (const int32_t face : {a, b}) {
        for (const int v : adapted.faces[static_cast<size_t>(face)]) {
          const size_t origin = static_cast<size_t>(origins[static_cast<size_t>(v)]);
          any |= !is_kept_[origin];
          found[origin] = 1;
        }
      }
    }
    if (!any) return false;
    Grow(mesh_, &found);
    for (size_t v = 0; v < found.size(); ++v) is_kept_[v] |= found[v];
    return true;
  }

  const MeshAdaptationOptions& options_;
  const std::vector<float>& density_;
  const TriangleMesh& mesh_;
  const std::vector<Eigen::Vector3d>& rest_;
  const RunContext& context_;
  std::vector<uint8_t> is_kept_;  // #V of mesh_
};

}  // namespace

MeshAdaptation AdaptMesh(const MeshAdaptationOptions& options, const std::vector<float>& density,
                         TriangleMesh* mesh, std::vector<Eigen::Vector3d>* rest,
                         const RunContext& context) {
  const TriangleMesh before = std::move(*mesh);
  const std::vector<Eigen::Vector3d> rest_before = std::move(*rest);
  return Adaptation(options, density, before, rest_before, context).Run(mesh, rest);
}

}  // namespace lsmvs
