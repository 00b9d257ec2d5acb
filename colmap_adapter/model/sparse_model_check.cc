// What must hold between the lists of a sparse model.
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

using internal::kMaxImageSide;
using internal::kSparseRemedy;

template <class Id>
uint64_t Number(Id id) {
  return static_cast<uint64_t>(id);
}

class Checker {
 public:
  Checker(const SparseModel& model, const std::filesystem::path& path)
      : model_(model), path_(path.string()) {}

  void Run() {
    CheckCameras();
    CheckImages();
    CheckPoints();
    CheckRigs();
    if (!model_.frames.empty()) CheckFrames();
  }

 private:
  [[noreturn]] void Fail(const std::string& what, const char* remedy = kSparseRemedy) const {
    throw InputError(path_, what, remedy);
  }

  void CheckPose(const SparseModel::Pose& pose, const std::string& of) const {
    const double norm = pose.rotation.norm();
    if (!pose.rotation.coeffs().allFinite() || !pose.translation.allFinite()) {
      Fail(of + " has a pose that is not finite",
           "remove it from the model or run the mapper again");
    }
    if (!(norm > 0.5 && norm < 2.0)) {
      Fail(fmt::format("{} has a rotation of length {}", of, norm),
           "write unit quaternions: qw qx qy qz");
    }
  }

  void CheckCameras() {
    for (const SparseModel::Camera& camera : model_.cameras) {
      const uint64_t id = Number(camera.camera_id);
      if (!cameras_.insert(id).second) Fail(fmt::format("has two cameras {}", id));
      if (camera.width - 1 >= kMaxImageSide || camera.height - 1 >= kMaxImageSide) {
        Fail(fmt::format("camera {} has the impossible size {} x {}", id, camera.width,
                         camera.height));
      }
      for (const double value : camera.params) {
        if (!std::isfinite(value))
          Fail(fmt::format("camera {} has a parameter that is not finite", id));
      }
    }
  }

  void CheckImages() {
    std::unordered_set<std::string_view> names;
    for (const SparseModel::Image& image : model_.images) {
      const std::string of = fmt::format("image {} ({})", Number(image.image_id), image.name);
      if (image.name.empty()) Fail(of + " has no name");
      if (!names.insert(image.name).second) Fail("has two images named " + image.name);
      const auto [place, is_new] = images_.try_emplace(Number(image.image_id), &image);
      if (!is_new) Fail(fmt::format("has two images {}", Number(image.image_id)));
      if (!cameras_.contains(Number(image.camera_id))) {
        Fail(fmt::format("{} refers to the missing camera {}", of, Number(image.camera_id)));
      }
      CheckPose(image.cam_from_world, of);
    }
  }

  void CheckPoints() {
    std::vector<uint64_t> ids;
    ids.reserve(model_.points3d.size());
    for (const SparseModel::Point3d& point : model_.points3d) {
      ids.push_back(Number(point.point3d_id));
      internal::CheckPointIsFinite(path_, point);
    }
    internal::CheckPointIds(path_, &ids);
  }

  void CheckRigs() {
    for (const SparseModel::Rig& rig : model_.rigs) {
      const uint64_t id = Number(rig.rig_id);
      if (!rigs_.insert(id).second) Fail(fmt::format("has two rigs {}", id));
      for (const SparseModel::Rig::Mount& mount : rig.sensors) {
        if (mount.sensor.type == SparseModel::SensorType::kCamera &&
            !cameras_.contains(mount.sensor.id)) {
          Fail(fmt::format("rig {} refers to the missing camera {}", id, mount.sensor.id));
        }
        if (mount.sensor_from_rig) CheckPose(*mount.sensor_from_rig, fmt::format("rig {}", id));
      }
    }
  }

  void CheckFrames() {
    std::unordered_set<uint64_t> frames, images_in_frames;
    for (const SparseModel::Frame& frame : model_.frames) {
      const std::string of = fmt::format("frame {}", Number(frame.frame_id));
      if (!frames.insert(Number(frame.frame_id)).second) Fail("has two of " + of);
      if (!rigs_.contains(Number(frame.rig_id))) {
        Fail(fmt::format("{} refers to the missing rig {}", of, Number(frame.rig_id)));
      }
      CheckPose(frame.rig_from_world, of);
      for (const SparseModel::Frame::Data& data : frame.data) {
        if (data.sensor.type != SparseModel::SensorType::kCamera) continue;
        if (!images_.contains(data.data_id)) {
          Fail(fmt::format("{} refers to the missing image {}", of, data.data_id));
        }
        if (!images_in_frames.insert(data.data_id).second) {
          Fail(fmt::format("image {} is in two frames", data.data_id));
        }
      }
    }
    for (const SparseModel::Image& image : model_.images) {
      if (!images_in_frames.contains(Number(image.image_id))) {
        Fail(fmt::format("image {} ({}) is in no frame", Number(image.image_id), image.name));
      }
    }
  }

  const SparseModel& model_;
  const std::string path_;
  std::unordered_set<uint64_t> cameras_, rigs_;
  std::unordered_map<uint64_t, const SparseModel::Image*> images_;
};

}  // namespace

namespace {

void DropReferencesToMissingPoints(SparseModel* model) {
  const auto has_features = [](const auto& image) { return !image.points2d.empty(); };
  if (std::none_of(model->images.begin(), model->images.end(), has_features)) return;
  std::unordered_set<uint64_t> ids;
  for (const SparseModel::Point3d& point : model->points3d) ids.insert(Number(point.point3d_id));
  for (SparseModel::Image& image : model->images) {
    for (SparseModel::Point2d& point : image.points2d) {
      if (!ids.contains(Number(point.point3d_id))) point.point3d_id = SparseModel::kNoPoint3d;
    }
  }
}

}  // namespace

internal::PointCheck::PointCheck(const std::filesystem::path& path, const SparseModel& model)
    : path_(path.string()) {
  for (const SparseModel::Image& image : model.images) {
    num_features_[static_cast<uint32_t>(image.image_id)] = image.num_points2d;
  }
}

void internal::PointCheck::Check(SparseModel::Point3d* point) {
  CheckPointIsFinite(path_, *point);
  ids_.push_back(Number(point->point3d_id));
  DropDangling(point);
}

void internal::PointCheck::DropDangling(SparseModel::Point3d* point) {
  num_elements_ += point->track.size();
  num_dropped_ += std::erase_if(point->track, [&](const SparseModel::TrackElement& element) {
    const auto image = num_features_.find(static_cast<uint32_t>(element.image_id));
    return image == num_features_.end() || element.point2d_idx >= image->second;
  });
}

void internal::PointCheck::Finish() { CheckPointIds(path_, &ids_); }

std::string internal::PointCheck::Warning() const {
  if (num_dropped_ == 0) return "";
  return fmt::format(
      "{}: {} of the {} observations of its points name an image or a feature that is not there; "
      "they are left out",
      path_, num_dropped_, num_elements_);
}

void internal::CheckPointIds(const std::string& path, std::vector<uint64_t>* ids) {
  if (!std::is_sorted(ids->begin(), ids->end())) std::sort(ids->begin(), ids->end());
  const auto twice = std::adjacent_find(ids->begin(), ids->end());
  if (twice == ids->end()) return;
  throw InputError(path, fmt::format("has two points {}", *twice), kSparseRemedy);
}

void internal::CheckPointIsFinite(const std::string& path, const SparseModel::Point3d& point) {
  if (point.x_in_world.allFinite()) return;
  throw InputError(path, fmt::format("point {} is not finite", Number(point.point3d_id)),
                   kSparseRemedy);
}

void internal::DropDanglingTracks(const std::filesystem::path& path, SparseModel* model) {
  PointCheck check(path, *model);
  for (SparseModel::Point3d& point : model->points3d) check.DropDangling(&point);
  DropReferencesToMissingPoints(model);
  if (!check.Warning().empty()) model->warnings.push_back(check.Warning());
}

void CheckSparseModel(const SparseModel& model, const std::filesystem::path& path) {
  Checker(model, path).Run();
}

}  // namespace lsmvs
