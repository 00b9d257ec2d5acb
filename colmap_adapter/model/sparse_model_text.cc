// COLMAP's text files: one record a line (two an image), # starts a comment.
#include <fmt/format.h>

#include <limits>

#include "lsmvs/colmap_adapter/files/text_reader.h"
#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"
#include "lsmvs/util/atomic_file.h"

namespace lsmvs::internal {

namespace {

constexpr uint64_t kMaxId32 = std::numeric_limits<uint32_t>::max();
constexpr const char* kTwoLinesRemedy =
    "an image takes two lines; the second lists its features (x y point3D_id), or is empty";
constexpr uint64_t kMaxId64 = std::numeric_limits<uint64_t>::max();

template <class Id>
Id ReadId32(TextReader* reader) {
  return Id{static_cast<uint32_t>(reader->Unsigned(kMaxId32))};
}

SparseModel::Pose ReadPose(TextReader* reader) {
  SparseModel::Pose pose;
  pose.rotation.w() = reader->Double();
  pose.rotation.x() = reader->Double();
  pose.rotation.y() = reader->Double();
  pose.rotation.z() = reader->Double();
  for (double& value : pose.translation) value = reader->Double();
  return pose;
}

SparseModel::Sensor ReadSensor(TextReader* reader) {
  const std::string_view type = reader->Word();
  SparseModel::Sensor sensor;
  if (type == "IMU") {
    sensor.type = SparseModel::SensorType::kImu;
  } else if (type != "CAMERA") {
    reader->Fail("has the unknown sensor type '" + std::string(type.substr(0, 60)) + "'");
  }
  sensor.id = static_cast<uint32_t>(reader->Unsigned(kMaxId32));
  return sensor;
}

// The line of an image's features: x y point3D_id, -1 where there is no point.
void ReadPoints2d(bool keep, TextReader* reader, SparseModel::Image* image) {
  while (!reader->AtEndOfLine()) {
    SparseModel::Point2d point;
    point.x.x() = reader->Double();
    point.x.y() = reader->Double();
    const int64_t id = reader->Signed();
    if (id >= 0) point.point3d_id = Point3dId{static_cast<uint64_t>(id)};
    ++image->num_points2d;
    if (keep) image->points2d.push_back(point);
  }
}

}  // namespace

void ReadCamerasText(const std::filesystem::path& path, SparseModel* model) {
  TextReader reader(path, kSparseRemedy);
  while (reader.NextContentLine()) {
    SparseModel::Camera camera;
    camera.camera_id = ReadId32<CameraId>(&reader);
    const std::string_view name = reader.Word();
    const CameraModel* camera_model = FindCameraModel(name);
    if (camera_model == nullptr) {
      reader.Fail("has the unknown camera model '" + std::string(name.substr(0, 60)) + "'");
    }
    camera.model_id = camera_model->id;
    camera.width = reader.Unsigned(kMaxId64);
    camera.height = reader.Unsigned(kMaxId64);
    for (size_t i = 0; i < camera_model->num_params; ++i) camera.params.push_back(reader.Double());
    reader.ExpectEndOfLine();
    model->cameras.push_back(std::move(camera));
  }
}

void ReadImagesText(const std::filesystem::path& path, bool keep_points2d, SparseModel* model) {
  TextReader reader(path, kSparseRemedy);
  while (reader.NextContentLine()) {
    SparseModel::Image image;
    image.image_id = ReadId32<ImageId>(&reader);
    image.cam_from_world = ReadPose(&reader);
    image.camera_id = ReadId32<CameraId>(&reader);
    // The rest of the line, so that names with blanks survive where the writer kept them.
    image.name = reader.RestOfLine();
    if (image.name.empty() || image.name.size() > kMaxNameLength) reader.Fail("has no image name");
    // The second line may be empty, and the last one missing.
    if (reader.NextLine()) {
      reader.SetRemedy(kTwoLinesRemedy);
      ReadPoints2d(keep_points2d, &reader, &image);
      reader.SetRemedy(kSparseRemedy);
    }
    model->images.push_back(std::move(image));
  }
}

void ReadPoints3dText(const std::filesystem::path& path, const PointSink& sink) {
  TextReader reader(path, kSparseRemedy);
  while (reader.NextContentLine()) {
    SparseModel::Point3d point;
    point.point3d_id = Point3dId{reader.Unsigned(kMaxId64)};
    for (double& value : point.x_in_world) value = reader.Double();
    for (uint8_t& value : point.color) value = static_cast<uint8_t>(reader.Unsigned(255));
    point.error_px = reader.Double();
    while (!reader.AtEndOfLine()) {
      const auto image_id = ReadId32<ImageId>(&reader);
      point.track.push_back({image_id, static_cast<uint32_t>(reader.Unsigned(kMaxId32))});
    }
    sink.take(std::move(point));
  }
}

void ReadRigsText(const std::filesystem::path& path, SparseModel* model) {
  TextReader reader(path, kSparseRemedy);
  while (reader.NextContentLine()) {
    SparseModel::Rig rig;
    rig.rig_id = ReadId32<RigId>(&reader);
    const uint64_t num_sensors = reader.Count(2);
    for (uint64_t i = 0; i < num_sensors; ++i) {
      SparseModel::Rig::Mount mount{ReadSensor(&reader), std::nullopt};
      if (i > 0 && reader.Unsigned(1) == 1) mount.sensor_from_rig = ReadPose(&reader);
      rig.sensors.push_back(mount);
    }
    reader.ExpectEndOfLine();
    model->rigs.push_back(std::move(rig));
  }
}

void ReadFramesText(const std::filesystem::path& path, SparseModel* model) {
  TextReader reader(path, kSparseRemedy);
  while (reader.NextContentLine()) {
    SparseModel::Frame frame;
    frame.frame_id = ReadId32<FrameId>(&reader);
    frame.rig_id = ReadId32<RigId>(&reader);
    frame.rig_from_world = ReadPose(&reader);
    const uint64_t num_data = reader.Count(3);
    for (uint64_t i = 0; i < num_data; ++i) {
      const SparseModel::Sensor sensor = ReadSensor(&reader);
      frame.data.push_back({sensor, reader.Unsigned(kMaxId64)});
    }
    reader.ExpectEndOfLine();
    model->frames.push_back(std::move(frame));
  }
}

namespace {

// Numbers are written with as many digits as it takes to read the same double again.
std::string ToText(const SparseModel::Pose& pose) {
  return fmt::format("{} {} {} {} {} {} {}", pose.rotation.w(), pose.rotation.x(),
                     pose.rotation.y(), pose.rotation.z(), pose.translation.x(),
                     pose.translation.y(), pose.translation.z());
}

std::string ToText(const SparseModel::Sensor& sensor) {
  const bool is_camera = sensor.type == SparseModel::SensorType::kCamera;
  return fmt::format("{} {}", is_camera ? "CAMERA" : "IMU", sensor.id);
}

std::string ToText(const SparseModel::Camera& camera) {
  std::string line =
      fmt::format("{} {} {} {}", static_cast<uint32_t>(camera.camera_id),
                  FindCameraModel(camera.model_id)->name, camera.width, camera.height);
  for (const double value : camera.params) line += fmt::format(" {}", value);
  return line + "\n";
}

std::string ToText(const SparseModel::Image& image) {
  std::string lines =
      fmt::format("{} {} {} {}\n", static_cast<uint32_t>(image.image_id),
                  ToText(image.cam_from_world), static_cast<uint32_t>(image.camera_id), image.name);
  const char* separator = "";
  for (const SparseModel::Point2d& point : image.points2d) {
    const bool has_point = point.point3d_id != SparseModel::kNoPoint3d;
    const int64_t id = has_point ? static_cast<int64_t>(point.point3d_id) : -1;
    lines += fmt::format("{}{} {} {}", separator, point.x.x(), point.x.y(), id);
    separator = " ";
  }
  return lines + "\n";
}

std::string ToText(const SparseModel::Point3d& point) {
  std::string line = fmt::format("{} {} {} {} {} {} {} {}", static_cast<uint64_t>(point.point3d_id),
                                 point.x_in_world.x(), point.x_in_world.y(), point.x_in_world.z(),
                                 point.color[0], point.color[1], point.color[2], point.error_px);
  for (const SparseModel::TrackElement& element : point.track) {
    line += fmt::format(" {} {}", static_cast<uint32_t>(element.image_id), element.point2d_idx);
  }
  return line + "\n";
}

std::string ToText(const SparseModel::Rig& rig) {
  std::string line = fmt::format("{} {}", static_cast<uint32_t>(rig.rig_id), rig.sensors.size());
  for (size_t i = 0; i < rig.sensors.size(); ++i) {
    const SparseModel::Rig::Mount& mount = rig.sensors[i];
    line += fmt::format(" {}", ToText(mount.sensor));
    if (i > 0) line += mount.sensor_from_rig ? " 1" : " 0";
    if (mount.sensor_from_rig) line += fmt::format(" {}", ToText(*mount.sensor_from_rig));
  }
  return line + "\n";
}

std::string ToText(const SparseModel::Frame& frame) {
  std::string line = fmt::format("{} {} {} {}", static_cast<uint32_t>(frame.frame_id),
                                 static_cast<uint32_t>(frame.rig_id), ToText(frame.rig_from_world),
                                 frame.data.size());
  for (const SparseModel::Frame::Data& data : frame.data) {
    line += fmt::format(" {} {}", ToText(data.sensor), data.data_id);
  }
  return line + "\n";
}

template <class Record>
void WriteList(const std::filesystem::path& path, const char* header,
               const std::vector<Record>& records) {
  AtomicFile file(path);
  file.Write(header);
  for (const Record& record : records) file.Write(ToText(record));
  file.Commit();
}

}  // namespace

void WriteModelText(const FileNames& names, const SparseModel& model) {
  WriteList(names.cameras, "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n", model.cameras);
  WriteList(names.images,
            "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
            "# POINTS2D[] as (X, Y, POINT3D_ID)\n",
            model.images);
  WriteList(names.points3d,
            "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n",
            model.points3d);
  if (model.rigs.empty() && model.frames.empty()) return;
  WriteList(names.rigs,
            "# RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as (SENSOR_TYPE, "
            "SENSOR_ID, HAS_POSE, [QW, QX, QY, QZ, TX, TY, TZ])\n",
            model.rigs);
  WriteList(names.frames,
            "# FRAME_ID, RIG_ID, QW, QX, QY, QZ, TX, TY, TZ, NUM_DATA_IDS, DATA_IDS[] as "
            "(SENSOR_TYPE, SENSOR_ID, DATA_ID)\n",
            model.frames);
}

}  // namespace lsmvs::internal
