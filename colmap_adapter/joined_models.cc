#include "lsmvs/colmap_adapter/joined_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <unordered_map>

#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"

namespace lsmvs {

namespace {

// Adds one model after the other under new numbers.
class Joiner {
 public:
  void Add(const SparseModel& model) {
    ++num_models_;
    std::unordered_map<uint32_t, uint32_t> new_camera, new_image;
    for (const SparseModel::Camera& camera : model.cameras) {
      joined_.cameras.push_back(camera);
      const auto id = static_cast<uint32_t>(joined_.cameras.size());
      joined_.cameras.back().camera_id = CameraId{id};
      new_camera[static_cast<uint32_t>(camera.camera_id)] = id;
    }
    for (const size_t i : RegisteredImageOrder(model)) {
      SparseModel::Image image = model.images[i];
      const auto id = static_cast<uint32_t>(joined_.images.size() + 1);
      new_image[static_cast<uint32_t>(image.image_id)] = id;
      image.image_id = ImageId{id};
      image.camera_id = CameraId{new_camera.at(static_cast<uint32_t>(image.camera_id))};
      image.name = fmt::format("{}/{}", num_models_, image.name);
      image.points2d.clear();
      image.num_points2d = 0;
      joined_.images.push_back(std::move(image));
    }
    for (SparseModel::Point3d point : model.points3d) {
      point.point3d_id = Point3dId{joined_.points3d.size() + 1};
      for (SparseModel::TrackElement& element : point.track) {
        element.image_id = ImageId{new_image.at(static_cast<uint32_t>(element.image_id))};
      }
      joined_.points3d.push_back(std::move(point));
    }
  }

  SparseModel Take() { return std::move(joined_); }

 private:
  SparseModel joined_;
  int num_models_ = 0;
};

}  // namespace

SparseModel JoinSparseModels(const std::vector<SparseModel>& models) {
  Joiner joiner;
  for (const SparseModel& model : models) joiner.Add(model);
  return joiner.Take();
}

JoinedScene LoadJoinedScene(const std::vector<DenseWorkspace>& workspaces, bool ignore_distortion) {
  JoinedScene joined;
  std::vector<SparseModel> models;
  for (const DenseWorkspace& workspace : workspaces) {
    const std::filesystem::path folder = workspace.SparseFolder();
    models.push_back(ReadSparseModel(folder, {.keep_points2d = false}));
    LogWarnings(models.back());
    joined.parts.push_back(MakeScene(models.back(), folder, ignore_distortion));
    joined.parts.back().points.clear();
    joined.parts.back().image_folder = workspace.ImageFolder().string();
  }
  joined.whole =
      MakeScene(JoinSparseModels(models), workspaces.front().SparseFolder(), ignore_distortion);
  size_t first = 0;
  for (Scene& part : joined.parts) {
    for (View& view : part.views) {
      view.cam_from_world = joined.whole.views[first++].cam_from_world;
    }
    part.world_offset = joined.whole.world_offset;
  }
  return joined;
}

}  // namespace lsmvs
