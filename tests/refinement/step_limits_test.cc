#include "lsmvs/refinement/step/step_limits.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "lsmvs/refinement/step/vertex_frames.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

constexpr int kSide = 9;

class StepLimits : public testing::Test {
 protected:
  SurfaceBeforeStep Surface() const {
    return {mesh_, rings_, mesh_.vertices, directions_, pixel_size_, fixed_, on_rim_};
  }
  static size_t At(int column, int row) {
    return static_cast<size_t>(row) * kSide + static_cast<size_t>(column);
  }

  TriangleMesh mesh_ = GridMesh(kSide, 2.0);
  VertexRings rings_ = BuildVertexRings(mesh_);
  std::vector<Eigen::Vector3d> directions_ = VertexDirections(mesh_);
  std::vector<double> pixel_size_ = std::vector<double>(mesh_.vertices.size(), 0.5);
  std::vector<uint8_t> fixed_ = std::vector<uint8_t>(mesh_.vertices.size(), 0);
  std::vector<uint8_t> on_rim_ = rings_.on_border;
};

TEST_F(StepLimits, StepsAreInPixelsAlongTheDirections) {
  std::vector<double> step(mesh_.vertices.size(), 0.0);
  step[At(4, 4)] = 3.0;
  const std::vector<Eigen::Vector3d> moved = Displaced(Surface(), step);
  for (size_t v = 0; v < moved.size(); ++v) {
    const Eigen::Vector3d expected = mesh_.vertices[v] + 0.5 * step[v] * directions_[v];
    EXPECT_LT((moved[v] - expected).norm(), 1e-3 * 0.5 * 1.01);
  }
}

TEST_F(StepLimits, ARimGoesLittleFurtherThanTheSurfaceBesideIt) {
  std::vector<double> step(mesh_.vertices.size(), 1.0);
  step[At(0, 4)] = 9.0;
  step[At(8, 4)] = -9.0;
  HoldRims(Surface(), &step);
  EXPECT_DOUBLE_EQ(step[At(0, 4)], 2.5);
  EXPECT_DOUBLE_EQ(step[At(8, 4)], -0.5);
  EXPECT_DOUBLE_EQ(step[At(4, 4)], 1.0);
  fixed_[At(0, 4)] = 1;
  step[At(0, 4)] = 9.0;
  HoldRims(Surface(), &step);
  EXPECT_DOUBLE_EQ(step[At(0, 4)], 9.0);
}

TEST_F(StepLimits, FoldsAreTakenBackAndSlopesAreNot) {
  std::vector<double> step(mesh_.vertices.size(), 0.0);
  step[At(4, 4)] = 40.0;  // ten times the edge
  step[At(1, 1)] = 1.0;
  StopFolds(Surface(), &step);
  EXPECT_EQ(step[At(4, 4)], 0.0);
  EXPECT_EQ(step[At(1, 1)], 1.0);
}

}  // namespace
}  // namespace lsmvs
