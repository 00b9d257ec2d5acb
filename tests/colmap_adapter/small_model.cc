#include "lsmvs/adapter_test/small_model.h"

#include <gtest/gtest.h>

namespace lsmvs {

namespace {

SparseModel::Pose SomePose(double seed) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, seed, 2).normalized();
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.3 + 0.1 * seed, axis)),
          Eigen::Vector3d(seed, 1.0 / 3.0, -2 * seed)};
}

void AddRigs(SparseModel* model) {
  using enum SparseModel::SensorType;
  model->rigs = {{RigId{4}, {{{kCamera, 1}, {}}, {{kCamera, 7}, SomePose(3)}, {{kImu, 2}, {}}}},
                 {RigId{9}, {}}};
  model->frames = {{FrameId{2}, RigId{4}, SomePose(5), {{{kCamera, 1}, 12}, {{kImu, 2}, 77}}},
                   {FrameId{1}, RigId{4}, SomePose(6), {{{kCamera, 7}, 3}, {{kCamera, 1}, 5}}}};
}

}  // namespace

SparseModel SmallModel(bool with_rigs) {
  SparseModel model;
  model.cameras = {{CameraId{1}, 1, 640, 480, {500.25, 501.0 / 3.0, 320, 240}},
                   {CameraId{7}, 4, 320, 200, {300, 301, 160, 100, 1e-3, -1e-4, 1e-5, 2e-5}}};
  const Point3dId none = SparseModel::kNoPoint3d;
  model.images = {{ImageId{5},
                   SomePose(1),
                   CameraId{1},
                   "b.jpg",
                   2,
                   {{{10.5, 20.25}, Point3dId{100}}, {{0.1, 1.0 / 3.0}, none}}},
                  {ImageId{3}, SomePose(2), CameraId{7}, "sub folder/a.jpg", 0, {}},
                  {ImageId{12}, SomePose(4), CameraId{1}, "c.jpg", 1, {{{7, 8}, Point3dId{100}}}}};
  model.points3d = {
      {Point3dId{100}, {1, -2, 1.0 / 3.0}, {1, 2, 255}, 0.5, {{ImageId{5}, 0}, {ImageId{12}, 0}}},
      {Point3dId{200}, {4, 5, 6}, {0, 0, 0}, -1, {}}};
  if (with_rigs) AddRigs(&model);
  return model;
}

namespace {

void ExpectSamePose(const SparseModel::Pose& a, const SparseModel::Pose& b) {
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  EXPECT_EQ(a.translation, b.translation);
}

void ExpectSameImage(const SparseModel::Image& a, const SparseModel::Image& b) {
  EXPECT_EQ(a.image_id, b.image_id);
  ExpectSamePose(a.cam_from_world, b.cam_from_world);
  EXPECT_EQ(a.camera_id, b.camera_id);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.num_points2d, b.num_points2d);
  ASSERT_EQ(a.points2d.size(), b.points2d.size());
  for (size_t i = 0; i < a.points2d.size(); ++i) {
    EXPECT_EQ(a.points2d[i].x, b.points2d[i].x);
    EXPECT_EQ(a.points2d[i].point3d_id, b.points2d[i].point3d_id);
  }
}

void ExpectSamePoint(const SparseModel::Point3d& a, const SparseModel::Point3d& b) {
  EXPECT_EQ(a.point3d_id, b.point3d_id);
  EXPECT_EQ(a.x_in_world, b.x_in_world);
  EXPECT_EQ(a.color, b.color);
  EXPECT_EQ(a.error_px, b.error_px);
  ASSERT_EQ(a.track.size(), b.track.size());
  for (size_t i = 0; i < a.track.size(); ++i) {
    EXPECT_EQ(a.track[i].image_id, b.track[i].image_id);
    EXPECT_EQ(a.track[i].point2d_idx, b.track[i].point2d_idx);
  }
}

void ExpectSameRig(const SparseModel::Rig& a, const SparseModel::Rig& b) {
  EXPECT_EQ(a.rig_id, b.rig_id);
  ASSERT_EQ(a.sensors.size(), b.sensors.size());
  for (size_t i = 0; i < a.sensors.size(); ++i) {
    EXPECT_EQ(a.sensors[i].sensor.type, b.sensors[i].sensor.type);
    EXPECT_EQ(a.sensors[i].sensor.id, b.sensors[i].sensor.id);
    ASSERT_EQ(a.sensors[i].sensor_from_rig.has_value(), b.sensors[i].sensor_from_rig.has_value());
    if (a.sensors[i].sensor_from_rig) {
      ExpectSamePose(*a.sensors[i].sensor_from_rig, *b.sensors[i].sensor_from_rig);
    }
  }
}

void ExpectSameFrame(const SparseModel::Frame& a, const SparseModel::Frame& b) {
  EXPECT_EQ(a.frame_id, b.frame_id);
  EXPECT_EQ(a.rig_id, b.rig_id);
  ExpectSamePose(a.rig_from_world, b.rig_from_world);
  ASSERT_EQ(a.data.size(), b.data.size());
  for (size_t i = 0; i < a.data.size(); ++i) {
    EXPECT_EQ(a.data[i].sensor.type, b.data[i].sensor.type);
    EXPECT_EQ(a.data[i].sensor.id, b.data[i].sensor.id);
    EXPECT_EQ(a.data[i].data_id, b.data[i].data_id);
  }
}

template <class Record>
void ExpectSameList(const std::vector<Record>& a, const std::vector<Record>& b,
                    void (*expect_same)(const Record&, const Record&)) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) expect_same(a[i], b[i]);
}

void ExpectSameCamera(const SparseModel::Camera& a, const SparseModel::Camera& b) {
  EXPECT_EQ(a.camera_id, b.camera_id);
  EXPECT_EQ(a.model_id, b.model_id);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.params, b.params);
}

}  // namespace

void ExpectSameModel(const SparseModel& a, const SparseModel& b) {
  ExpectSameList(a.cameras, b.cameras, ExpectSameCamera);
  ExpectSameList(a.images, b.images, ExpectSameImage);
  ExpectSameList(a.points3d, b.points3d, ExpectSamePoint);
  ExpectSameList(a.rigs, b.rigs, ExpectSameRig);
  ExpectSameList(a.frames, b.frames, ExpectSameFrame);
}

}  // namespace lsmvs
