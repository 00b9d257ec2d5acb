#include "lsmvs/stereo/quasi_dense/cross_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs::quasi_dense {
namespace {

constexpr float kTolerance = 0.8f;

// Two views of the plane z = 0 with points whose depths are true up to noise, some of them wrong.
struct TwoGrids {
  PinholeCamera camera = MakeCamera(160, 120);
  std::vector<Rigid3> poses = {LookAt({0, -1, 3}, {0, 0, 0}), LookAt({0.7, -0.8, 2.9}, {0, 0, 0})};
  std::vector<PointGrid> grids;
  std::vector<Pairing> pairings;  // of view 0

  TwoGrids() {
    for (size_t v = 0; v < 2; ++v) grids.push_back(MakeGrid(poses[v], v));
    pairings = {{1, MakePairTransfer(poses[0], camera, poses[1], camera),
                 MakePairTransfer(poses[1], camera, poses[0], camera)}};
  }

  double InverseDepth(const Rigid3& pose, const Eigen::Vector2d& x_px) const {
    const Rigid3 world_from_cam = pose.Inverse();
    const Eigen::Vector3d direction = world_from_cam.rotation * camera.Ray(x_px);
    return -direction.z() / world_from_cam.translation.z();
  }

  PointGrid MakeGrid(const Rigid3& pose, uint64_t seed) const {
    Random random(seed);
    PointGrid grid;
    grid.spacing = 4;
    grid.cells = Raster<InterestPoint>(40, 30);
    for (int row = 0; row < 30; ++row) {
      for (int column = 0; column < 40; ++column) {
        if (random.Uniform() < 0.2) continue;
        InterestPoint& point = grid.cells(column, row);
        const Eigen::Vector2d x(4 * (column + random.Uniform()), 4 * (row + random.Uniform()));
        point.position = x.cast<float>();
        const double middle = InverseDepth(pose, x);
        const double wrong = random.Uniform() < 0.3 ? random.Uniform(-0.1, 0.1) : 0.0;
        point.plane = {static_cast<float>(middle * (1 + 0.002 * random.Gaussian() + wrong)),
                       static_cast<float>(InverseDepth(pose, x + Eigen::Vector2d(1, 0)) - middle),
                       static_cast<float>(InverseDepth(pose, x + Eigen::Vector2d(0, 1)) - middle)};
        if (random.Uniform() < 0.1) point.plane = Plane();
      }
    }
    return grid;
  }

  // Everything in double and over all points of the other view.
  bool Confirmed(const InterestPoint& point, bool* near_the_limit) const {
    const Eigen::Vector3d x =
        poses[0].Inverse() * (camera.Ray(point.position.cast<double>()) / double{point.plane.q});
    const Eigen::Vector2d place = camera.Project(poses[1] * x);
    if (!camera.Contains(place)) return false;
    bool confirmed = false;
    for (const InterestPoint& other : grids[1].cells.pixels) {
      if (!other.matched()) continue;
      const auto cell = [](double position) { return static_cast<int>(position / 4); };
      if (std::abs(cell(place.x()) - cell(other.position.x())) > 1 ||
          std::abs(cell(place.y()) - cell(other.position.y())) > 1) {
        continue;
      }
      const Eigen::Vector2d offset = place - other.position.cast<double>();
      const double inverse_depth =
          other.plane.q + other.plane.qx * offset.x() + other.plane.qy * offset.y();
      const Eigen::Vector3d back = poses[1].Inverse() * (camera.Ray(place) / inverse_depth);
      const double error = (camera.Project(poses[0] * back) - point.position.cast<double>()).norm();
      confirmed |= error <= kTolerance;
      *near_the_limit |= std::abs(error - kTolerance) < 1e-3;
    }
    return confirmed;
  }
};

TEST(QuasiDenseMutual, AgreesWithTheObviousCheck) {
  const TwoGrids scene;
  const Raster<uint32_t> confirmed = ConfirmedSlots(
      {std::make_shared<PointGrid>(scene.grids[0]), {std::make_shared<PointGrid>(scene.grids[1])}},
      scene.pairings, kTolerance, RunContext(2));
  int num_confirmed = 0, num_refused = 0;
  for (size_t cell = 0; cell < confirmed.size(); ++cell) {
    const InterestPoint& point = scene.grids[0].cells.pixels[cell];
    if (!point.matched()) {
      EXPECT_EQ(confirmed.pixels[cell], 0u);
      continue;
    }
    bool near_the_limit = false;
    const bool expected = scene.Confirmed(point, &near_the_limit);
    if (near_the_limit) continue;
    EXPECT_EQ(confirmed.pixels[cell], expected ? 1u : 0u);
    (expected ? num_confirmed : num_refused) += 1;
  }
  EXPECT_GT(num_confirmed, 400);
  EXPECT_GT(num_refused, 100);
}

TEST(QuasiDenseMutual, TellsWhatTheOtherViewSays) {
  TwoGrids scene;
  const Eigen::Vector2f position(80, 60);
  const float truth =
      static_cast<float>(scene.InverseDepth(scene.poses[0], position.cast<double>()));
  const auto ask = [&](float inverse_depth) {
    return CrossCheckPoint(scene.pairings[0], scene.grids[1], position, inverse_depth, kTolerance)
        .status;
  };
  for (InterestPoint& point : scene.grids[1].cells.pixels) {
    if (!point.exists()) continue;
    point.plane.q =
        static_cast<float>(scene.InverseDepth(scene.poses[1], point.position.cast<double>()));
  }
  EXPECT_EQ(ask(truth), CrossCheckStatus::kConfirmed);
  EXPECT_EQ(ask(1.1f * truth), CrossCheckStatus::kContradicted);
  EXPECT_EQ(ask(100 * truth), CrossCheckStatus::kUnseen);
  EXPECT_EQ(ask(-truth), CrossCheckStatus::kUnseen);
  for (InterestPoint& point : scene.grids[1].cells.pixels) point.plane = Plane();
  EXPECT_EQ(ask(truth), CrossCheckStatus::kUnknown);
}

}  // namespace
}  // namespace lsmvs::quasi_dense
