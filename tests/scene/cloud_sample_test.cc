#include "lsmvs/scene/cloud_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace lsmvs {
namespace {

// A view that looks down from 100 m on pixels of 0.1 m.
Scene OneView() {
  Scene scene;
  View view;
  view.camera.width = view.camera.height = 10000;
  view.camera.fx = view.camera.fy = 1000;
  view.camera.cx = view.camera.cy = 5000;
  view.cam_from_world.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  view.cam_from_world.translation = {0, 0, 100};
  scene.views.push_back(view);
  return scene;
}

// Uniform on a square of `side` metres at height 0.
std::vector<Eigen::Vector3f> Square(size_t count, float side) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> at(0, side);
  std::vector<Eigen::Vector3f> points;
  for (size_t i = 0; i < count; ++i) points.emplace_back(at(random), at(random), 0.01f);
  return points;
}

CloudSample Sample(const std::vector<Eigen::Vector3f>& points,
                   const Eigen::AlignedBox3d& box = {}) {
  const Scene scene = OneView();
  CloudSampler sampler(scene, box);
  for (const auto& x : points) sampler.Add(x, {0, 0, 1}, std::vector<uint32_t>{0});
  return sampler.Take();
}

TEST(CloudSample, HasAllPointsOfItsPlaces) {
  const auto points = Square(400000, 200);
  const CloudSample sample = Sample(points);
  EXPECT_EQ(sample.num_points, points.size());
  EXPECT_EQ(sample.num_view_entries, points.size());
  ASSERT_GT(sample.places.size(), 5u);
  size_t total = 0;
  for (const CloudSample::Place& place : sample.places) {
    total += place.points.size();
    EXPECT_NEAR(place.cube.sizes().x(), 6.4, 0.01);  // 64 pixels of 0.1 m
    const auto inside = [&](const Eigen::Vector3f& x) { return place.cube.contains(x); };
    const auto& sampled = place.points.positions;
    EXPECT_EQ(std::count_if(sampled.begin(), sampled.end(), inside),
              std::count_if(points.begin(), points.end(), inside));
  }
  EXPECT_LE(total, CloudSampler::kMaxPoints);
  EXPECT_GT(total, CloudSampler::kMaxPoints / 4);
}

TEST(CloudSample, ASmallCloudIsTakenWhole) {
  const auto points = Square(3000, 20);
  const CloudSample sample = Sample(points);
  size_t total = 0;
  for (const CloudSample::Place& place : sample.places) {
    for (const auto& x : place.points.positions) total += place.cube.contains(x);
  }
  EXPECT_EQ(total, points.size());
}

TEST(CloudSample, CountsInsideTheBoxOnly) {
  const auto points = Square(100000, 100);
  const Eigen::AlignedBox3d half(Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(50, 100, 1));
  EXPECT_NEAR(static_cast<double>(Sample(points, half).num_points), 50000, 1000);
}

TEST(CloudSample, OfPointsWithoutViewsIsEmpty) {
  const Scene scene = OneView();
  CloudSampler sampler(scene, {});
  for (int i = 0; i < 10; ++i) sampler.Add({1, 2, 3}, {0, 0, 1}, {});
  sampler.Add({1, 2, std::numeric_limits<float>::infinity()}, {0, 0, 1}, {});
  const CloudSample sample = sampler.Take();
  EXPECT_EQ(sample.num_points, 10u);
  EXPECT_TRUE(sample.places.empty());
}

}  // namespace
}  // namespace lsmvs
