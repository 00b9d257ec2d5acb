#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/geometry/rigid3.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// COLMAP's sparse identifiers; distinct types, so that they mix neither with each other nor with
// positions.
enum class CameraId : uint32_t {};
enum class Point3dId : uint64_t {};
enum class RigId : uint32_t {};
enum class FrameId : uint32_t {};

// What COLMAP calls a reconstruction, as its files say it: nothing is converted, sorted or dropped
// (but for references to nothing, see `warnings`), so that reading and writing again gives the same
// model (and for binary files of the same version, the same bytes). The order of every list is that
// of the file. See scene_loader.h for the way from here to a Scene.
struct SparseModel {
  // A rotation as the unit quaternion in the file and a translation.
  struct Pose {
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();

    Rigid3 ToRigid3() const { return Rigid3(rotation, translation); }
    static Pose FromRigid3(const Rigid3& rigid) {
      return {Eigen::Quaterniond(rigid.rotation), rigid.translation};
    }
  };

  struct Camera {
    CameraId camera_id{};
    int model_id = 1;  // one of AllCameraModels(); 1 = PINHOLE
    uint64_t width = 0, height = 0;
    std::vector<double> params;  // as many as the model has; PINHOLE: fx, fy, cx, cy
  };

  // A feature of an image. `x` in COLMAP's image coordinates (centre of the top-left pixel: 0.5,
  // 0.5).
  struct Point2d {
    Eigen::Vector2d x = Eigen::Vector2d::Zero();
    Point3dId point3d_id = kNoPoint3d;
  };
  static constexpr Point3dId kNoPoint3d{~uint64_t{0}};

  struct Image {
    ImageId image_id{};
    Pose cam_from_world;
    CameraId camera_id{};
    std::string name;  // relative to images/, with sub-folders and extension
    // #points2d of the file; `points2d` holds them or, if the reader was told to skip them,
    // nothing.
    uint64_t num_points2d = 0;
    std::vector<Point2d> points2d;
  };

  struct TrackElement {
    ImageId image_id{};
    uint32_t point2d_idx = 0;  // position in the image's points2d
  };

  struct Point3d {
    Point3dId point3d_id{};
    Eigen::Vector3d x_in_world = Eigen::Vector3d::Zero();
    Color color = Color::Zero();
    double error_px = 0;  // mean reprojection error; -1 where COLMAP did not compute it
    std::vector<TrackElement> track;
  };

  enum class SensorType : int32_t { kCamera = 0, kImu = 1 };
  struct Sensor {
    SensorType type = SensorType::kCamera;
    uint32_t id = 0;  // of a camera: its CameraId
  };

  // Sensors that are mounted together (COLMAP 3.12 and later). The first of `sensors` is the rig's
  // origin.
  struct Rig {
    struct Mount {
      Sensor sensor;
      std::optional<Pose> sensor_from_rig;  // never set for the first
    };
    RigId rig_id{};
    std::vector<Mount> sensors;
  };

  // One moment at which the sensors of a rig took their data (COLMAP 3.12 and later).
  struct Frame {
    struct Data {
      Sensor sensor;
      uint64_t data_id = 0;  // of a camera: the ImageId
    };
    FrameId frame_id{};
    RigId rig_id{};
    Pose rig_from_world;
    std::vector<Data> data;
  };

  std::vector<Camera> cameras;
  std::vector<Image> images;  // registered ones only, as in COLMAP's files
  std::vector<Point3d> points3d;
  std::vector<Rig> rigs;      // empty before COLMAP 3.12
  std::vector<Frame> frames;  // empty before COLMAP 3.12
  // What the reader left out of an inconsistent file, one sentence each, to be told to the user.
  std::vector<std::string> warnings;
};

// Positions in model.images, in the order of COLMAP's list of registered images, which is what the
// indices of fused.ply.vis mean: the order of the frames, and in each by sensor, where there are
// any; else that of the images. The model must be consistent.
std::vector<size_t> RegisteredImageOrder(const SparseModel& model);

// Gives each camera a rig of its own and each image a frame of its own, with the camera's and the
// image's number, in the order of the model: what COLMAP 3.12 and later make of an older model.
void AddTrivialRigsAndFrames(SparseModel* model);

}  // namespace lsmvs
