#include "lsmvs/colmap_adapter/scene_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <unordered_map>
#include <vector>

#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/model/missing_images.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr int kEquirectangularModel = 17;
// See the header: when a scene is so far from the origin that it is shifted.
constexpr double kMaxCenterToExtent = 100.0;
constexpr double kMaxFloatSpacingToGsd = 0.01;
constexpr double kFloatSpacing = 0x1p-23;
constexpr double kExtentQuantile = 0.9;

[[noreturn]] void FailModel(const SparseModel::Camera& camera, const std::string& path) {
  const std::string what =
      fmt::format("camera {} is of the model {}; dense reconstruction needs PINHOLE",
                  static_cast<uint32_t>(camera.camera_id), FindCameraModel(camera.model_id)->name);
  throw InputError(path, what,
                   camera.model_id == kEquirectangularModel
                       ? "cut perspective photos out of the panoramas and reconstruct from those"
                       : "undistort with `colmap image_undistorter`, or name the project folder");
}

// The first parameters of every perspective model are its focal lengths, one or two, and the
// principal point; the models with one are these.
bool HasOneFocalLength(const SparseModel::Camera& camera) {
  const std::string_view name = FindCameraModel(camera.model_id)->name;
  return name.starts_with("SIMPLE_") || name == "RADIAL" || name == "RADIAL_FISHEYE";
}

SparseModel::Camera WithoutDistortion(SparseModel::Camera camera) {
  if (camera.model_id == kEquirectangularModel) return camera;
  const bool one = HasOneFocalLength(camera);
  camera.model_id = one ? kSimplePinholeModel : kPinholeModel;
  camera.params.resize(one ? 3 : 4);
  return camera;
}

PinholeCamera ToPinhole(const SparseModel::Camera& camera, const std::string& path) {
  PinholeCamera pinhole;
  pinhole.width = static_cast<int>(camera.width);
  pinhole.height = static_cast<int>(camera.height);
  const std::vector<double>& params = camera.params;
  if (camera.model_id == kSimplePinholeModel) {
    pinhole.fx = pinhole.fy = params[0];
    pinhole.cx = params[1];
    pinhole.cy = params[2];
  } else if (camera.model_id == kPinholeModel) {
    pinhole.fx = params[0];
    pinhole.fy = params[1];
    pinhole.cx = params[2];
    pinhole.cy = params[3];
  } else {
    FailModel(camera, path);
  }
  if (!(pinhole.fx > 0 && pinhole.fy > 0)) {
    throw InputError(path,
                     fmt::format("camera {} has a focal length that is not positive",
                                 static_cast<uint32_t>(camera.camera_id)),
                     "undistort again with `colmap image_undistorter`");
  }
  return pinhole;
}

// Reorders `values`.
double Quantile(std::vector<double>* values, double q) {
  const auto index = static_cast<std::ptrdiff_t>(q * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + index, values->end());
  return (*values)[static_cast<size_t>(index)];
}

// Calls `visit` with the position of each view and point.
template <class Visit>
void ForAllPositions(const Scene& scene, const Visit& visit) {
  for (const View& view : scene.views) visit(view.CenterInWorld());
  for (const SparsePoint& point : scene.points) visit(point.x_in_world);
}

std::vector<double> ValuesOf(const Scene& scene,
                             const std::function<double(const Eigen::Vector3d&)>& value_at) {
  std::vector<double> values;
  values.reserve(scene.views.size() + scene.points.size());
  ForAllPositions(scene, [&](const Eigen::Vector3d& x) { values.push_back(value_at(x)); });
  return values;
}

Eigen::Vector3d MedianPosition(const Scene& scene) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values = ValuesOf(scene, [&](const auto& x) { return x[axis]; });
    median[axis] = Quantile(&values, 0.5);
  }
  return median;
}

Eigen::Vector3d ChooseWorldOffset(const Scene& scene) {
  const Eigen::Vector3d center = MedianPosition(scene);
  std::vector<double> distances =
      ValuesOf(scene, [&](const auto& x) { return (x - center).norm(); });
  const double extent = Quantile(&distances, kExtentQuantile);
  if (!(extent > 0)) return Eigen::Vector3d::Zero();
  std::vector<double>().swap(distances);
  const double distance = center.norm();
  const bool is_far = distance > kMaxCenterToExtent * extent;
  const auto loses_detail = [&] {
    const double gsd = GroundSamplingDistance(scene);
    return gsd > 0 && distance * kFloatSpacing > kMaxFloatSpacingToGsd * gsd;
  };
  if (!is_far && !(distance > extent && loses_detail())) return Eigen::Vector3d::Zero();
  // A multiple of a power of two: adding it to shifted coordinates loses nothing that a double can
  // hold.
  const double unit = std::exp2(std::ceil(std::log2(extent)));
  return (center / unit).array().round() * unit;
}

void ShiftWorld(const Eigen::Vector3d& offset, Scene* scene) {
  for (View& view : scene->views) {
    view.cam_from_world.translation += view.cam_from_world.rotation * offset;
  }
  for (SparsePoint& point : scene->points) point.x_in_world -= offset;
  scene->world_offset = offset;
}

void AddViews(const SparseModel& model, const std::string& path, bool ignore_distortion,
              Scene* scene) {
  std::unordered_map<uint32_t, const SparseModel::Camera*> cameras;
  for (const SparseModel::Camera& camera : model.cameras) {
    cameras[static_cast<uint32_t>(camera.camera_id)] = &camera;
  }
  for (const size_t i : RegisteredImageOrder(model)) {
    const SparseModel::Image& image = model.images[i];
    const SparseModel::Camera& camera = *cameras.at(static_cast<uint32_t>(image.camera_id));
    const PinholeCamera pinhole =
        ToPinhole(ignore_distortion ? WithoutDistortion(camera) : camera, path);
    scene->views.push_back({image.image_id, image.name, pinhole, image.cam_from_world.ToRigid3()});
  }
}

// Turns points of a model into a scene's.
class PointConverter {
 public:
  explicit PointConverter(Scene* scene) : scene_(*scene) {
    for (int v = 0; v < scene->num_views(); ++v) {
      view_of_image_[static_cast<uint32_t>(scene->views[v].image_id)] = v;
    }
  }
  void Add(const SparseModel::Point3d& source) {
    SparsePoint point{source.x_in_world, source.color, static_cast<float>(source.error_px), {}};
    point.view_idxs.reserve(source.track.size());
    for (const SparseModel::TrackElement& element : source.track) {
      point.view_idxs.push_back(view_of_image_.at(static_cast<uint32_t>(element.image_id)));
    }
    std::sort(point.view_idxs.begin(), point.view_idxs.end());
    point.view_idxs.erase(std::unique(point.view_idxs.begin(), point.view_idxs.end()),
                          point.view_idxs.end());
    scene_.points.push_back(std::move(point));
  }

 private:
  Scene& scene_;
  std::unordered_map<uint32_t, int> view_of_image_;
};

void MoveNearOrigin(Scene* scene) {
  const Eigen::Vector3d offset = ChooseWorldOffset(*scene);
  if (!offset.isZero(0.0)) ShiftWorld(offset, scene);
}

Scene SceneOfViews(const SparseModel& model, const std::filesystem::path& model_path,
                   bool ignore_distortion) {
  if (model.images.empty()) {
    throw InputError(model_path.string(), "has no registered image",
                     "check the output of `colmap mapper`: it could not place any photo");
  }
  Scene scene;
  AddViews(model, model_path.string(), ignore_distortion, &scene);
  return scene;
}

void CheckSize(const std::string& path, const View& view, const char* remedy) {
  const Eigen::Vector2i size = ReadImageSize(path);
  if (size.x() == view.camera.width && size.y() == view.camera.height) return;
  throw InputError(path,
                   fmt::format("is {} x {} pixels, but its camera is {} x {}", size.x(), size.y(),
                               view.camera.width, view.camera.height),
                   remedy);
}

// One message about all that are missing.
void CheckMissing(const DenseWorkspace& workspace, bool skip_missing, Scene* scene) {
  std::vector<std::string> missing;
  for (View& view : scene->views) {
    view.has_photo = std::filesystem::is_regular_file(workspace.ImagePath(view.name));
    if (!view.has_photo) missing.push_back(view.name);
  }
  if (missing.empty()) return;
  const MissingImages images(workspace.ImageFolder(), missing, scene->views.size());
  if (!skip_missing || !images.LeavesEnough()) images.Throw();
  images.Warn();
  for (SparsePoint& point : scene->points) {
    std::erase_if(point.view_idxs,
                  [&](int v) { return !scene->views[static_cast<size_t>(v)].has_photo; });
  }
}

void CheckImages(const DenseWorkspace& workspace, const LoadSceneOptions& options, Scene* scene) {
  CheckMissing(workspace, options.skip_missing_images, scene);
  for (const View& view : scene->views) {
    if (!view.has_photo) continue;
    CheckSize(workspace.ImagePath(view.name).string(), view,
              "use the images that the model was made from, or undistort again");
    const std::string mask = MaskPath(options.mask_folder, view.name);
    if (!mask.empty()) CheckSize(mask, view, "make the mask of its photo's size, or remove it");
  }
}

void CheckFolder(const std::filesystem::path& folder, const char* what, const char* remedy) {
  if (!std::filesystem::is_directory(folder)) throw InputError(folder.string(), what, remedy);
}

}  // namespace

Scene MakeScene(const SparseModel& model, const std::filesystem::path& model_path,
                bool ignore_distortion) {
  Scene scene = SceneOfViews(model, model_path, ignore_distortion);
  scene.points.reserve(model.points3d.size());
  PointConverter converter(&scene);
  for (const SparseModel::Point3d& point : model.points3d) converter.Add(point);
  MoveNearOrigin(&scene);
  return scene;
}

Scene LoadScene(const DenseWorkspace& workspace, const LoadSceneOptions& options) {
  const std::filesystem::path sparse_folder = workspace.SparseFolder();
  SparseModel model =
      ReadSparseModel(sparse_folder, {.keep_points2d = false, .keep_points3d = false});
  Scene scene = SceneOfViews(model, sparse_folder, options.ignore_distortion);
  PointConverter converter(&scene);
  ReadSparsePoints(
      sparse_folder, &model, [&](uint64_t count) { scene.points.reserve(count); },
      [&](const SparseModel::Point3d& point) { converter.Add(point); });
  LogWarnings(model);
  MoveNearOrigin(&scene);
  scene.image_folder = workspace.ImageFolder().string();
  scene.mask_folder = options.mask_folder;
  scene.alpha_is_mask = options.alpha_is_mask;
  if (!options.check_images) return scene;
  CheckFolder(workspace.ImageFolder(), "the folder of the images is missing",
              "undistort again with `colmap image_undistorter`");
  if (!options.mask_folder.empty()) {
    CheckFolder(options.mask_folder, "the folder of the masks is missing", "correct --mask_path");
  }
  CheckImages(workspace, options, &scene);
  return scene;
}

}  // namespace lsmvs
