// COLMAP's binary files: little endian, packed, every list behind a count of 64 bits unless said
// otherwise.
#include <fmt/format.h>

#include "lsmvs/colmap_adapter/files/binary_reader.h"
#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/model/sparse_model_parts.h"
#include "lsmvs/util/atomic_file.h"

namespace lsmvs::internal {

namespace {

constexpr size_t kPoseBytes = 7 * sizeof(double);
constexpr size_t kPoint2dBytes = 2 * sizeof(double) + sizeof(uint64_t);
constexpr size_t kTrackElementBytes = 2 * sizeof(uint32_t);
// The smallest record of each kind.
constexpr size_t kMinCameraBytes = 4 + 4 + 8 + 8 + 2 * sizeof(double);
constexpr size_t kMinImageBytes = 4 + kPoseBytes + 4 + 1 + 8;
constexpr size_t kMinPoint3dBytes = 8 + 3 * sizeof(double) + 3 + 8 + 8;
constexpr size_t kMinRigBytes = 4 + 4;
constexpr size_t kMinMountBytes = 4 + 4 + 1;
constexpr size_t kMinFrameBytes = 4 + 4 + kPoseBytes + 4;
constexpr size_t kFrameDataBytes = 4 + 4 + 8;

SparseModel::Pose ReadPose(BinaryReader* reader) {
  SparseModel::Pose pose;
  pose.rotation.w() = reader->Read<double>();
  pose.rotation.x() = reader->Read<double>();
  pose.rotation.y() = reader->Read<double>();
  pose.rotation.z() = reader->Read<double>();
  reader->ReadBytes(pose.translation.data(), 3 * sizeof(double));
  return pose;
}

SparseModel::Sensor ReadSensor(BinaryReader* reader) {
  const uint64_t position = reader->Position();
  const auto type = reader->Read<int32_t>();
  if (type != 0 && type != 1) {
    reader->FailAt(fmt::format("has the unknown sensor type {}", type), position);
  }
  return {static_cast<SparseModel::SensorType>(type), reader->Read<uint32_t>()};
}

SparseModel::Camera ReadCamera(BinaryReader* reader) {
  SparseModel::Camera camera;
  camera.camera_id = CameraId{reader->Read<uint32_t>()};
  const uint64_t position = reader->Position();
  camera.model_id = reader->Read<int32_t>();
  const CameraModel* camera_model = FindCameraModel(camera.model_id);
  if (camera_model == nullptr) {
    reader->FailAt(fmt::format("has the unknown camera model {}", camera.model_id), position);
  }
  camera.width = reader->Read<uint64_t>();
  camera.height = reader->Read<uint64_t>();
  camera.params.resize(camera_model->num_params);
  reader->ReadBytes(camera.params.data(), camera.params.size() * sizeof(double));
  return camera;
}

SparseModel::Image ReadImage(BinaryReader* reader, bool keep_points2d) {
  SparseModel::Image image;
  image.image_id = ImageId{reader->Read<uint32_t>()};
  image.cam_from_world = ReadPose(reader);
  image.camera_id = CameraId{reader->Read<uint32_t>()};
  image.name = reader->ReadNulTerminated(kMaxNameLength);
  image.num_points2d = reader->ReadCount<uint64_t>(kPoint2dBytes, "features");
  if (!keep_points2d) {
    reader->Skip(image.num_points2d * kPoint2dBytes);
    return image;
  }
  image.points2d.resize(static_cast<size_t>(image.num_points2d));
  for (SparseModel::Point2d& point : image.points2d) {
    reader->ReadBytes(point.x.data(), 2 * sizeof(double));
    point.point3d_id = Point3dId{reader->Read<uint64_t>()};
  }
  return image;
}

SparseModel::Point3d ReadPoint3d(BinaryReader* reader) {
  SparseModel::Point3d point;
  point.point3d_id = Point3dId{reader->Read<uint64_t>()};
  reader->ReadBytes(point.x_in_world.data(), 3 * sizeof(double));
  reader->ReadBytes(point.color.data(), 3);
  point.error_px = reader->Read<double>();
  point.track.resize(
      static_cast<size_t>(reader->ReadCount<uint64_t>(kTrackElementBytes, "observations")));
  for (SparseModel::TrackElement& element : point.track) {
    element.image_id = ImageId{reader->Read<uint32_t>()};
    element.point2d_idx = reader->Read<uint32_t>();
  }
  return point;
}

SparseModel::Rig ReadRig(BinaryReader* reader) {
  SparseModel::Rig rig;
  rig.rig_id = RigId{reader->Read<uint32_t>()};
  // The first sensor has no flag and no pose, one byte less than the smallest of the others.
  const uint64_t position = reader->Position();
  const auto num_sensors = reader->Read<uint32_t>();
  if (num_sensors == 0) return rig;
  if (num_sensors - 1 > reader->Remaining() / kMinMountBytes) {
    reader->FailAt(fmt::format("claims {} sensors, more than its size allows", num_sensors),
                   position);
  }
  rig.sensors.push_back({ReadSensor(reader), std::nullopt});
  for (uint32_t i = 1; i < num_sensors; ++i) {
    SparseModel::Rig::Mount mount{ReadSensor(reader), std::nullopt};
    if (reader->Read<uint8_t>() != 0) mount.sensor_from_rig = ReadPose(reader);
    rig.sensors.push_back(mount);
  }
  return rig;
}

SparseModel::Frame ReadFrame(BinaryReader* reader) {
  SparseModel::Frame frame;
  frame.frame_id = FrameId{reader->Read<uint32_t>()};
  frame.rig_id = RigId{reader->Read<uint32_t>()};
  frame.rig_from_world = ReadPose(reader);
  frame.data.resize(static_cast<size_t>(reader->ReadCount<uint32_t>(kFrameDataBytes, "data")));
  for (SparseModel::Frame::Data& data : frame.data) {
    data.sensor = ReadSensor(reader);
    data.data_id = reader->Read<uint64_t>();
  }
  return frame;
}

// Reads a file that is one list: a count and its records.
template <class Record, class ReadRecord>
void ReadList(const std::filesystem::path& path, size_t min_record_bytes, const char* what,
              const ReadRecord& read_record, std::vector<Record>* records) {
  BinaryReader reader(path, kSparseRemedy);
  const uint64_t count = reader.ReadCount<uint64_t>(min_record_bytes, what);
  records->reserve(static_cast<size_t>(count));
  for (uint64_t i = 0; i < count; ++i) records->push_back(read_record(&reader));
  reader.ExpectEnd();
}

}  // namespace

void ReadCamerasBinary(const std::filesystem::path& path, SparseModel* model) {
  ReadList(path, kMinCameraBytes, "cameras", ReadCamera, &model->cameras);
}

void ReadImagesBinary(const std::filesystem::path& path, bool keep_points2d, SparseModel* model) {
  const auto read = [&](BinaryReader* reader) { return ReadImage(reader, keep_points2d); };
  ReadList(path, kMinImageBytes, "images", read, &model->images);
}

void ReadPoints3dBinary(const std::filesystem::path& path, const PointSink& sink) {
  BinaryReader reader(path, kSparseRemedy);
  const auto count = reader.ReadCount<uint64_t>(kMinPoint3dBytes, "points");
  if (sink.expect) sink.expect(count);
  for (uint64_t i = 0; i < count; ++i) sink.take(ReadPoint3d(&reader));
  reader.ExpectEnd();
}

void ReadRigsBinary(const std::filesystem::path& path, SparseModel* model) {
  ReadList(path, kMinRigBytes, "rigs", ReadRig, &model->rigs);
}

void ReadFramesBinary(const std::filesystem::path& path, SparseModel* model) {
  ReadList(path, kMinFrameBytes, "frames", ReadFrame, &model->frames);
}

namespace {

void WritePose(const SparseModel::Pose& pose, AtomicFile* file) {
  for (const double q :
       {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()}) {
    file->WriteValue(q);
  }
  file->Write(pose.translation.data(), 3 * sizeof(double));
}

void WriteSensor(const SparseModel::Sensor& sensor, AtomicFile* file) {
  file->WriteValue(static_cast<int32_t>(sensor.type));
  file->WriteValue(sensor.id);
}

void WriteCamera(const SparseModel::Camera& camera, AtomicFile* file) {
  file->WriteValue(camera.camera_id);
  file->WriteValue(static_cast<int32_t>(camera.model_id));
  file->WriteValue(camera.width);
  file->WriteValue(camera.height);
  file->Write(camera.params.data(), camera.params.size() * sizeof(double));
}

void WriteImage(const SparseModel::Image& image, AtomicFile* file) {
  file->WriteValue(image.image_id);
  WritePose(image.cam_from_world, file);
  file->WriteValue(image.camera_id);
  file->Write(image.name.c_str(), image.name.size() + 1);
  file->WriteValue(static_cast<uint64_t>(image.points2d.size()));
  for (const SparseModel::Point2d& point : image.points2d) {
    file->Write(point.x.data(), 2 * sizeof(double));
    file->WriteValue(point.point3d_id);
  }
}

void WritePoint3d(const SparseModel::Point3d& point, AtomicFile* file) {
  file->WriteValue(point.point3d_id);
  file->Write(point.x_in_world.data(), 3 * sizeof(double));
  file->Write(point.color.data(), 3);
  file->WriteValue(point.error_px);
  file->WriteValue(static_cast<uint64_t>(point.track.size()));
  for (const SparseModel::TrackElement& element : point.track) {
    file->WriteValue(element.image_id);
    file->WriteValue(element.point2d_idx);
  }
}

void WriteRig(const SparseModel::Rig& rig, AtomicFile* file) {
  file->WriteValue(rig.rig_id);
  file->WriteValue(static_cast<uint32_t>(rig.sensors.size()));
  for (size_t i = 0; i < rig.sensors.size(); ++i) {
    const SparseModel::Rig::Mount& mount = rig.sensors[i];
    WriteSensor(mount.sensor, file);
    if (i == 0) continue;
    file->WriteValue(static_cast<uint8_t>(mount.sensor_from_rig ? 1 : 0));
    if (mount.sensor_from_rig) WritePose(*mount.sensor_from_rig, file);
  }
}

void WriteFrame(const SparseModel::Frame& frame, AtomicFile* file) {
  file->WriteValue(frame.frame_id);
  file->WriteValue(frame.rig_id);
  WritePose(frame.rig_from_world, file);
  file->WriteValue(static_cast<uint32_t>(frame.data.size()));
  for (const SparseModel::Frame::Data& data : frame.data) {
    WriteSensor(data.sensor, file);
    file->WriteValue(data.data_id);
  }
}

template <class Record>
void WriteList(const std::filesystem::path& path, const std::vector<Record>& records,
               void (*write_record)(const Record&, AtomicFile*)) {
  AtomicFile file(path);
  file.WriteValue(static_cast<uint64_t>(records.size()));
  for (const Record& record : records) write_record(record, &file);
  file.Commit();
}

}  // namespace

void WriteModelBinary(const FileNames& names, const SparseModel& model) {
  WriteList(names.cameras, model.cameras, WriteCamera);
  WriteList(names.images, model.images, WriteImage);
  WriteList(names.points3d, model.points3d, WritePoint3d);
  if (model.rigs.empty() && model.frames.empty()) return;
  WriteList(names.rigs, model.rigs, WriteRig);
  WriteList(names.frames, model.frames, WriteFrame);
}

}  // namespace lsmvs::internal
