#include "lsmvs/pipeline/tasks/cloud_check.h"

#include <fmt/format.h>

#include <algorithm>

namespace lsmvs {

namespace {

constexpr size_t kSamplePoints = 10000;
// Of the places of good clouds nine tenths are on the surface; of noisy ones more than half.
constexpr double kMinShareOnSurface = 0.3;
// Pairs of a cloud and the views that it was made from reach more than that.
constexpr double kGoodFit = 0.95;

double Ratio(size_t part, size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string LikelyCause(const CloudFit& fit) {
  if (fit.inside < kGoodFit) {
    return "the views of the points are probably in another order than the model's images, or the "
           "poses are those of another model or have another scale";
  }
  if (fit.facing < 1 - kGoodFit) return "the normals are probably turned inside out";
  if (fit.facing < kGoodFit) {
    return "the views of the points are probably in another order than the model's images, or many "
           "normals are turned inside out";
  }
  return "the points lie in their images, so that their depths are probably wrong: made with poses "
         "of another model, or very noisy";
}

std::string FitText(const CloudFit& fit) {
  return fmt::format(
      "{:.0f} % of the points lie in the images of the views that are said to see them, {:.0f} % "
      "of the normals face these: {}",
      100 * fit.inside, 100 * fit.facing, LikelyCause(fit));
}

}  // namespace

CloudFit MeasureCloudFit(const Scene& scene, const VisibilityCloud& cloud) {
  size_t num_pairs = 0, num_inside = 0, num_with_normal = 0, num_facing = 0;
  const size_t stride = cloud.size() / kSamplePoints + 1;
  for (size_t p = 0; p < cloud.size(); p += stride) {
    const Eigen::Vector3d x = cloud.positions[p].cast<double>();
    const Eigen::Vector3d normal = cloud.normals[p].cast<double>();
    if (!x.allFinite()) continue;
    for (const uint32_t view_idx : cloud.ViewsOf(p)) {
      const View& view = scene.views[view_idx];
      const Eigen::Vector3d x_in_cam = view.cam_from_world * x;
      ++num_pairs;
      num_inside += x_in_cam.z() > 0 && view.camera.Contains(view.camera.Project(x_in_cam));
      if (normal.isZero(0.0)) continue;
      ++num_with_normal;
      num_facing += normal.dot(view.CenterInWorld() - x) > 0;
    }
  }
  return {Ratio(num_inside, num_pairs), Ratio(num_facing, num_with_normal)};
}

std::string ContradictionWarning(const CloudFit& fit, size_t num_places, size_t num_on_surface) {
  const double share = Ratio(num_on_surface, num_places);
  if (share < kMinShareOnSurface) {
    return fmt::format(
        "only {} of {} places of the cloud ({:.1f} %) are on the surface: what the views of the "
        "points say contradicts itself. {}",
        num_on_surface, num_places, 100 * share, FitText(fit));
  }
  if (std::min(fit.inside, fit.facing) >= kGoodFit) return "";
  return "the views of the points do not fit them, so that the surface is probably wrong. " +
         FitText(fit);
}

}  // namespace lsmvs
