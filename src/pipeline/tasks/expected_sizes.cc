#include "lsmvs/pipeline/tasks/expected_sizes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/scene/surface_share.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// Points that fusion makes of a pixel that shows surface; measured on scenes of 8 to 24 photos:
// 0.24 to 0.30.
constexpr double kPointsPerPixel = 0.27;
// A depth map confirms more views of a point than features that match: measured 1.06 to 1.19 times
// the views of a track.
constexpr double kViewsPerTrackView = 1.13;
constexpr size_t kFacesPerVertex = 2;
// Of the Delaunay vertices a part lies on the surface: points that few views see are off it more
// often. 1 - exp(-k views^2); measured 0.55 at 4.2 views, 0.87 at 5.3, 0.92 at 6.4.
constexpr double kSurfaceShareOfViews = 0.06;

// Nothing if there is no such file or it is not a PLY file: whoever reads it will say so.
std::optional<size_t> ElementCount(const std::filesystem::path& path, const std::string& element) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const PlyReader reader(path);
    const PlyElement* found = reader.FindElement(element);
    return found == nullptr ? 0 : found->count;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// Views that a depth map is compared with when it is fused, in the mean.
double MeanNumCompared(const Reconstruction& reconstruction) {
  double sum = 0;
  for (const std::vector<int>& views : FusionNeighbors(
           reconstruction.scene, reconstruction.neighbors, reconstruction.options.fusion)) {
    sum += static_cast<double>(views.size());
  }
  return sum / std::max(1, reconstruction.scene.num_views());
}

size_t ExpectedVertices(const Reconstruction& reconstruction, size_t num_points,
                        PointSpacing spacing) {
  return EstimateVisibilityMesherVertices(reconstruction.scene, num_points, spacing,
                                          reconstruction.options.surface);
}

}  // namespace

size_t ExpectedPoints(const Reconstruction& reconstruction, const std::filesystem::path& cloud) {
  if (const auto count = ElementCount(cloud, "vertex")) return *count;
  const double points = kPointsPerPixel * EstimateSurfaceShare(reconstruction.scene).covered *
                        NumPixels(reconstruction);
  if (reconstruction.options.point_source == PointSource::kPatchMatch) {
    return static_cast<size_t>(points);
  }
  constexpr double kQuasiDenseShare = 1.0 / 8;  // see PointSource
  return static_cast<size_t>(kQuasiDenseShare * points);
}

PointSpacing ExpectedSpacing(const std::filesystem::path& cloud) {
  return std::filesystem::exists(cloud) ? PointSpacing::kRandom : PointSpacing::kRegular;
}

double ExpectedViewsPerPoint(const Reconstruction& reconstruction) {
  const double by_tracks = kViewsPerTrackView * MeanTrackLength(reconstruction.scene);
  return std::min(by_tracks, 1 + MeanNumCompared(reconstruction));
}

size_t ExpectedFaces(const Reconstruction& reconstruction, const std::filesystem::path& mesh) {
  if (const auto count = ElementCount(mesh, "face")) return *count;
  const std::filesystem::path cloud = reconstruction.files->CloudFile();
  const size_t num_vertices = ExpectedVertices(
      reconstruction, ExpectedPoints(reconstruction, cloud), ExpectedSpacing(cloud));
  const double views = ExpectedViewsPerPoint(reconstruction);
  const double share = -std::expm1(-kSurfaceShareOfViews * views * views);
  return static_cast<size_t>(share * static_cast<double>(kFacesPerVertex * num_vertices));
}

size_t ExpectedRefinedFaces(const Reconstruction& reconstruction,
                            const std::filesystem::path& mesh) {
  if (const auto count = ElementCount(mesh, "face")) return *count;
  const size_t num_faces = ExpectedFaces(reconstruction, mesh);
  if (reconstruction.options.refinement.simplify_tolerance <= 0) return num_faces;
  // Measured: 0.07 of the surface stage's on smooth things, 0.2 to 0.35 on buildings, 0.5 on a
  // park.
  constexpr double kPartThatStays = 0.4;
  return static_cast<size_t>(kPartThatStays * static_cast<double>(num_faces));
}

size_t LeastBytes(size_t needed_bytes) {
  constexpr size_t kLeast = 64 << 20, kLeastShare = 32;
  return std::max(kLeast, needed_bytes / kLeastShare);
}

uint64_t ExpectedCloudBytes(const Reconstruction& reconstruction, size_t num_points) {
  // Position and normal as floats, colour; number of views and views.
  const double bytes_per_point = 6 * 4 + 3 + 4 + 4 * ExpectedViewsPerPoint(reconstruction);
  return static_cast<uint64_t>(bytes_per_point * static_cast<double>(num_points));
}

uint64_t ExpectedSurfaceBytes(const Reconstruction& reconstruction, size_t num_vertices) {
  // As a point of a cloud, with its quality; a vertex has the views of all points that it was
  // merged from. A face has its number of corners and three indices.
  constexpr uint64_t kFaceBytes = 1 + 3 * 4, kQualityBytes = 4;
  return ExpectedCloudBytes(reconstruction, num_vertices) +
         (kFacesPerVertex * kFaceBytes + kQualityBytes) * num_vertices;
}

uint64_t ExpectedRefinedBytes(size_t num_input_faces) {
  constexpr uint64_t kVertexBytes = 6 * 4 + 3 + 4, kFaceBytes = 1 + 3 * 4;
  return (kVertexBytes / kFacesPerVertex + kFaceBytes) * num_input_faces;
}

uint64_t ExpectedTexturedBytes(const Reconstruction& reconstruction, size_t num_faces) {
  // A face has its corners and their texture coordinates.
  constexpr uint64_t kVertexBytes = 3 * 4, kFaceBytes = 1 + 3 * 4 + 1 + 6 * 4 + 4;
  constexpr double kBytesPerTexel = 2.2;  // of a PNG
  const double texels =
      ExpectedTexels(*reconstruction.images, ExpectedViewsPerPoint(reconstruction),
                     reconstruction.options.texturing);
  return (kVertexBytes / kFacesPerVertex + kFaceBytes) * num_faces +
         static_cast<uint64_t>(kBytesPerTexel * texels);
}

}  // namespace lsmvs
