#include "lsmvs/adapter_test/analytic_workspace.h"

#include <fmt/format.h>

#include <cmath>

#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/colmap_adapter/stereo_config.h"
#include "lsmvs/image/image_codec.h"

namespace lsmvs {

namespace {

constexpr int kNumViews = 6;
constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal_px = 300;
constexpr int kPointStep_px = 14;
constexpr double kMaxReprojection_px = 1e-6;

class Plane : public AnalyticSurface {
 public:
  std::optional<double> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override {
    const double t = -origin.z() / direction.z();
    return t > 0 ? std::optional<double>(t) : std::nullopt;
  }
  Eigen::Vector3d Normal(const Eigen::Vector3d&) const override { return Eigen::Vector3d::UnitZ(); }
  double SignedDistance(const Eigen::Vector3d& x) const override { return x.z(); }
};

class Sphere : public AnalyticSurface {
 public:
  std::optional<double> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override {
    const double a = direction.squaredNorm(), b = origin.dot(direction);
    const double discriminant = b * b - a * (origin.squaredNorm() - 1);
    if (discriminant < 0) return std::nullopt;
    const double t = (-b - std::sqrt(discriminant)) / a;
    return t > 0 ? std::optional<double>(t) : std::nullopt;
  }
  Eigen::Vector3d Normal(const Eigen::Vector3d& x) const override { return x.normalized(); }
  double SignedDistance(const Eigen::Vector3d& x) const override { return x.norm() - 1; }
};

Rigid3 LookAtOrigin(const Eigen::Vector3d& center) {
  const Eigen::Vector3d z = -center.normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
  return Rigid3(rotation, Eigen::Vector3d(-(rotation * center)));
}

Eigen::Vector3d CameraCenter(int i) {
  const double azimuth = 0.12 * (i - 0.5 * (kNumViews - 1));
  return 3.0 * Eigen::Vector3d(std::sin(azimuth), -0.75 * std::cos(azimuth), 1.0);
}

Color TextureAt(const Eigen::Vector3d& x) {
  const auto wave = [](double phase) { return static_cast<uint8_t>(128 + 100 * std::sin(phase)); };
  return {wave(15 * x.x()), wave(17 * x.y() + x.x()), wave(13 * x.z() + 5 * x.x() * x.y())};
}

// Where the ray through image coordinates meets the surface.
std::optional<Eigen::Vector3d> SurfacePoint(const AnalyticSurface& surface, const View& view,
                                            const PinholeCamera& camera, const Eigen::Vector2d& x) {
  const Eigen::Vector3d direction = view.cam_from_world.rotation.transpose() * camera.Ray(x);
  const std::optional<double> t = surface.Intersect(view.CenterInWorld(), direction);
  if (!t) return std::nullopt;
  return view.CenterInWorld() + *t * direction;
}

void WritePhoto(const AnalyticSurface& surface, const DenseWorkspace& workspace, const View& view) {
  ColorImage photo(kWidth, kHeight, Color::Zero());
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto x = SurfacePoint(surface, view, view.camera, {column + 0.5, row + 0.5});
      if (x) photo(column, row) = TextureAt(*x);
    }
  }
  WritePng(workspace.ImagePath(view.name), photo);
}

bool Sees(const AnalyticSurface& surface, const View& view, const Eigen::Vector3d& x) {
  const Eigen::Vector3d x_in_cam = view.cam_from_world * x;
  if (x_in_cam.z() <= 0 || !view.camera.Contains(view.camera.Project(x_in_cam))) return false;
  const Eigen::Vector3d direction = x - view.CenterInWorld();
  const std::optional<double> t = surface.Intersect(view.CenterInWorld(), direction);
  return t && std::abs(*t - 1) < kMaxReprojection_px;
}

View MakeView(int i) {
  const PinholeCamera camera{kWidth, kHeight, kFocal_px, kFocal_px, 0.5 * kWidth, 0.5 * kHeight};
  // Ids fall where names rise, and the list is rotated: three orders that all differ.
  return {ImageId{static_cast<uint32_t>(20 - i)}, fmt::format("view{}.png", i), camera,
          LookAtOrigin(CameraCenter(i))};
}

void AddPoints(const AnalyticSurface& surface, const std::vector<View>& views, SparseModel* model) {
  for (int row = kPointStep_px / 2; row < kHeight; row += kPointStep_px) {
    for (int column = kPointStep_px / 2; column < kWidth; column += kPointStep_px) {
      const auto x = SurfacePoint(surface, views[0], views[0].camera, Eigen::Vector2d(column, row));
      if (!x) continue;
      SparseModel::Point3d point;
      point.point3d_id = Point3dId{model->points3d.size() + 1};
      point.x_in_world = *x;
      point.color = TextureAt(*x);
      for (size_t v = 0; v < views.size(); ++v) {
        if (!Sees(surface, views[v], *x)) continue;
        SparseModel::Image& image = model->images[v];
        point.track.push_back({image.image_id, static_cast<uint32_t>(image.num_points2d++)});
        const Eigen::Vector2d x_px = views[v].camera.Project(views[v].cam_from_world * *x);
        image.points2d.push_back({x_px, point.point3d_id});
      }
      model->points3d.push_back(std::move(point));
    }
  }
}

}  // namespace

std::unique_ptr<AnalyticSurface> MakePlane() { return std::make_unique<Plane>(); }
std::unique_ptr<AnalyticSurface> MakeSphere() { return std::make_unique<Sphere>(); }

DepthMap AnalyticWorkspace::TrueDepthMap(const AnalyticSurface& surface, int view_idx, int width,
                                         int height) const {
  const View& view = scene.views[static_cast<size_t>(view_idx)];
  const PinholeCamera camera = view.camera.Resized(width, height);
  DepthMap map{Raster<float>(width, height, 0.0f),
               Raster<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero())};
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto x = SurfacePoint(surface, view, camera, {column + 0.5, row + 0.5});
      if (!x) continue;
      map.depth(column, row) = static_cast<float>(view.Depth(*x));
      map.normal(column, row) =
          (view.cam_from_world.rotation * surface.Normal(*x)).cast<float>().normalized();
    }
  }
  return map;
}

AnalyticWorkspace MakeAnalyticWorkspace(const std::filesystem::path& folder,
                                        const AnalyticSurface& surface, bool with_rigs) {
  AnalyticWorkspace result;
  result.workspace.folder = folder;
  std::vector<View> views;
  std::vector<std::string> names;
  for (int i = 0; i < kNumViews; ++i) views.push_back(MakeView((i + 2) % kNumViews));
  result.model.cameras = {
      {CameraId{3}, 1, kWidth, kHeight, {kFocal_px, kFocal_px, 0.5 * kWidth, 0.5 * kHeight}}};
  for (const View& view : views) {
    WritePhoto(surface, result.workspace, view);
    names.push_back(view.name);
    result.model.images.push_back({view.image_id,
                                   SparseModel::Pose::FromRigid3(view.cam_from_world),
                                   CameraId{3},
                                   view.name,
                                   0,
                                   {}});
  }
  AddPoints(surface, views, &result.model);
  if (with_rigs) AddTrivialRigsAndFrames(&result.model);
  WriteSparseModel(folder / "sparse", result.model);
  WriteFusionConfig(result.workspace.FusionConfigPath(), names);
  std::filesystem::create_directories(result.workspace.StereoFolder() / "depth_maps");
  std::filesystem::create_directories(result.workspace.StereoFolder() / "normal_maps");
  result.scene = LoadScene(result.workspace);
  return result;
}

}  // namespace lsmvs
