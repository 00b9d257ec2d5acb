#include "lsmvs/merging/common_origin.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lsmvs {
namespace {

MergingInput TriangleAt(const Eigen::Vector3d& corner, double edge) {
  MergingInput input;
  input.mesh.vertices = {corner, corner + Eigen::Vector3d(edge, 0, 0),
                         corner + Eigen::Vector3d(0, edge, 0)};
  input.mesh.faces = {{0, 1, 2}};
  return input;
}

TEST(CommonOrigin, SmallCoordinatesStayAsTheyAre) {
  std::vector<MergingInput> inputs = {TriangleAt({1, 2, 3}, 0.1), TriangleAt({2, 2, 3}, 0.1)};
  const std::vector<Eigen::Vector3d> before = inputs[0].mesh.vertices;
  EXPECT_TRUE(ShiftToCommonOrigin(&inputs).isZero(0));
  EXPECT_EQ(inputs[0].mesh.vertices, before);
}

TEST(CommonOrigin, LargeOnesAreShiftedWithoutLossWhateverTheirOrder) {
  std::vector<MergingInput> inputs = {TriangleAt({602134.25, 5340231.5, 171}, 0.25),
                                      TriangleAt({602140.75, 5340229.125, 180}, 0.5)};
  const std::vector<MergingInput> before = inputs;
  std::vector<MergingInput> reversed = inputs;
  std::reverse(reversed.begin(), reversed.end());
  const Eigen::Vector3d offset = ShiftToCommonOrigin(&inputs);
  EXPECT_EQ(offset, ShiftToCommonOrigin(&reversed));
  EXPECT_GT(offset.norm(), 1e6);
  for (size_t i = 0; i < inputs.size(); ++i) {
    for (size_t v = 0; v < 3; ++v) {
      const Eigen::Vector3d& x = inputs[i].mesh.vertices[v];
      EXPECT_LT(x.cwiseAbs().maxCoeff(), 100);
      EXPECT_EQ(x + offset, before[i].mesh.vertices[v]);
    }
  }
}

TEST(CommonOrigin, NothingIsNotShifted) {
  std::vector<MergingInput> inputs(2);
  EXPECT_TRUE(ShiftToCommonOrigin(&inputs).isZero(0));
}

}  // namespace
}  // namespace lsmvs
