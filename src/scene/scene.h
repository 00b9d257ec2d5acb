#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/geometry/rigid3.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// COLMAP's sparse identifier of an image. A distinct type, so that it cannot be mistaken for a
// view's position.
enum class ImageId : uint32_t {};

// One registered photo. Views are addressed by their position in Scene::views: an int named
// `view_idx`.
struct View {
  ImageId image_id{};
  std::string name;      // COLMAP's image name: relative to images/, with sub-folders and extension
  PinholeCamera camera;  // of the full-size image
  Rigid3 cam_from_world;
  // False: the photo is missing and the user goes on without it. It counts as wholly masked and is
  // nobody's neighbour; the view stays, so that views keep their positions.
  bool has_photo = true;

  Eigen::Vector3d CenterInWorld() const { return cam_from_world.OriginInSource(); }
  double Depth(const Eigen::Vector3d& x_in_world) const {
    return cam_from_world.rotation.row(2).dot(x_in_world) + cam_from_world.translation.z();
  }
};

// A triangulated feature of the sparse model.
struct SparsePoint {
  Eigen::Vector3d x_in_world = Eigen::Vector3d::Zero();
  Color color = Color::Zero();
  float error_px = 0;          // mean reprojection error
  std::vector<int> view_idxs;  // ascending, without duplicates
};

// Photos with known cameras. The "world" in memory is the world of the files minus `world_offset`:
// zero for ordinary scenes, near the scene's middle where coordinates are so large (UTM) that a
// float would lose surface detail. Readers subtract it, writers add it back; nothing in between
// needs to know.
struct Scene {
  std::vector<View> views;
  std::vector<SparsePoint> points;
  Eigen::Vector3d world_offset = Eigen::Vector3d::Zero();
  std::string image_folder;
  std::string mask_folder;    // empty: no masks; see MaskPath()
  bool alpha_is_mask = true;  // pixels with an alpha of 0 count as masked

  int num_views() const { return static_cast<int>(views.size()); }
};

// Depth range in each view.
struct DepthRange {
  double min = 0, max = 0;
};

// Fewer sparse points than this say little about where the surface lies in a view.
inline constexpr size_t kMinPointsOfView = 10;

// Positions in scene.points of the points that lie before the view and within its image, whether
// its track has the view or not; what hides them is not known.
std::vector<uint32_t> PointsInImage(const Scene& scene, int view_idx);

// Per view the range that its sparse points span between the 1 % and 99 % quantile, widened by
// `margin` (0.25 = a quarter of the near and far value). Views that see fewer than kMinPointsOfView
// points take those in their image; where these are too few as well, all points before the camera.
// {0, 0} where nothing is known.
std::vector<DepthRange> EstimateDepthRanges(const Scene& scene, double margin = 0.25);

// In how many photos a part of the scene is seen, about: the mean number of views of the points
// that two or more see. 4 without such points.
double MeanTrackLength(const Scene& scene);

// The scene's own unit: the median over the sparse points and their views of depth / focal length
// at full resolution: how much surface one pixel covers. 0 without points.
double GroundSamplingDistance(const Scene& scene);

// The mask of image <name>: <mask_folder>/<name>.png, as COLMAP's, else <name> with .png in place
// of its extension. Empty if neither exists.
std::string MaskPath(const std::string& mask_folder, const std::string& image_name);

// Image store over the scene's photos and masks (a mask file that does not exist masks nothing).
// Looks at the photos' headers for alpha channels.
std::unique_ptr<ImageStore> MakeImageStore(const Scene& scene, const ImageStoreOptions& options);

}  // namespace lsmvs
