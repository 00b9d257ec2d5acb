#include "lsmvs/evaluation/measure_mesh.h"

#include <limits>

#include "lsmvs/evaluation/seam_photos.h"

namespace lsmvs {

void MeasureAgainstTruth(const SurfaceEvaluator& truth, const TriangleMesh& mesh,
                         const MeshTracer* tracer, const std::vector<View>& views,
                         const DepthErrorOptions& options, const RunContext& context,
                         MeshFigures* figures) {
  const bool with_depth = tracer != nullptr && truth.truth_tracer() != nullptr && !views.empty();
  figures->surface = truth.Evaluate(mesh, context.Part(0, with_depth ? 0.6 : 1), tracer);
  if (!with_depth) return;
  figures->depth_errors =
      MeasureDepthErrors(*tracer, *truth.truth_tracer(), views, options, context.Part(0.6, 1));
}

void MeasureColors(const MeshTracer& tracer, const TriangleMesh& mesh, const TexturePages* pages,
                   const Scene& scene, const ImageStore& images, const std::vector<int>& view_idxs,
                   const TextureScoreOptions& options, const RunContext& context,
                   MeshFigures* figures) {
  if (pages != nullptr) {
    const SeamPhotos photos = {tracer, scene, images};
    figures->atlas = MeasureAtlas(*pages, &photos, context);
  }
  figures->texture =
      MeasureTextureScore(tracer, mesh, pages, scene, images, view_idxs, options, context);
}

std::vector<double> DistancesToTruth(const SurfaceEvaluator& truth,
                                     const std::vector<Eigen::Vector3d>& x_in_world,
                                     const RunContext& context) {
  std::vector<double> distances(x_in_world.size());
  ParallelFor(context, distances.size(), 1024, [&](size_t i) {
    const Eigen::Vector3d& x = x_in_world[i];
    distances[i] =
        x.allFinite() ? truth.DistanceToTruth(x) : std::numeric_limits<double>::quiet_NaN();
  });
  return distances;
}

}  // namespace lsmvs
