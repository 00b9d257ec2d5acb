#include "lsmvs/geometry/rigid3.h"

#include <gtest/gtest.h>

#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

Rigid3 RandomRigid(Random* random) {
  const Eigen::Vector3d a = random->Gaussian3();
  return Rigid3(Eigen::Quaterniond(random->Gaussian(), a.x(), a.y(), a.z()),
                Eigen::Vector3d(random->Gaussian3()));
}

TEST(Rigid3, QuaternionsAreNormalised) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d r = RandomRigid(&random).rotation;
    EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(r.determinant(), 1.0, 1e-12);
  }
}

TEST(Rigid3, ComposesAndInverts) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 c_from_b = RandomRigid(&random), b_from_a = RandomRigid(&random);
    const Eigen::Vector3d x = random.Gaussian3();
    EXPECT_LT(((c_from_b * b_from_a) * x - c_from_b * (b_from_a * x)).norm(), 1e-12);
    EXPECT_LT((b_from_a.Inverse() * (b_from_a * x) - x).norm(), 1e-12);
    EXPECT_LT((b_from_a * b_from_a.OriginInSource()).norm(), 1e-12);
  }
}

TEST(Rigid3, DefaultIsIdentity) {
  const Eigen::Vector3d x(1, 2, 3);
  EXPECT_EQ(Rigid3() * x, x);
  EXPECT_EQ(Rigid3().OriginInSource(), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace lsmvs
