#include "lsmvs/refinement/finishing/finishing.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

const RunContext kContext(2);

// A square of 80 x 80 pixels and what photos say of it.
class FinishedSquare : public testing::Test {
 protected:
  FinishedSquare() : mesh_(GridMesh(41, 2)) {
    pairs_.per_face = 1;
    pairs_.of_face.assign(mesh_.faces.size(), 0);
    pairs_.pixel_size.assign(mesh_.faces.size(), 1.0f);
    terms_.mass.assign(mesh_.faces.size(), 2.0f);
    terms_.pixels.assign(mesh_.faces.size(), 2.0f);
    terms_.error.assign(mesh_.faces.size(), 0.1f);
  }

  // Photos that have less than nothing in common.
  template <class Where>
  void Contradict(const Where& where) {
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (where(FaceMiddle(mesh_, f))) terms_.error[f] = 0.4f * terms_.mass[f];
    }
  }

  TriangleMesh mesh_;
  FacePairs pairs_;
  PhotoTerms terms_;
};

TEST_F(FinishedSquare, ContradictedEndsGoAndTheInsideStays) {
  Contradict([](const Eigen::Vector3d& x) {
    return x.x() < 20 || (x - Eigen::Vector3d(50, 40, 0)).norm() < 15;
  });
  const FinishingSummary summary =
      FinishSurface(pairs_, terms_, {.border_cost = 1}, &mesh_, kContext);
  EXPECT_EQ(summary.num_dropped_faces, 2u * 10 * 40);
  EXPECT_EQ(summary.num_closed_holes, 0u);
  ExpectValidMesh(mesh_);
  EXPECT_DOUBLE_EQ(Inspect(mesh_).area, 60.0 * 80);
}

TEST_F(FinishedSquare, WithoutTextureNothingIsContradicted) {
  terms_.mass.assign(mesh_.faces.size(), 0.0f);
  terms_.error.assign(mesh_.faces.size(), 0.0f);
  // But for corners, which the border takes.
  EXPECT_LE(FinishSurface(pairs_, terms_, {.border_cost = 1}, &mesh_, kContext).num_dropped_faces,
            4u);
}

TEST_F(FinishedSquare, SmallHolesAreClosedAndVerticesWithoutFacesRemoved) {
  FilterFaces(&mesh_, [&](size_t f) {
    return (FaceMiddle(mesh_, f) - Eigen::Vector3d(40, 40, 0)).norm() > 5;
  });
  const FinishingSummary summary =
      FinishSurface(pairs_, terms_, {.border_cost = 0}, &mesh_, kContext);
  EXPECT_EQ(summary.num_closed_holes, 1u);
  ExpectValidMesh(mesh_);
  EXPECT_NEAR(Inspect(mesh_).area, 80.0 * 80, 1e-9);
}

TEST_F(FinishedSquare, AMeshThatIsNotManifoldStaysAsItIs) {
  mesh_.faces.push_back(mesh_.faces[0]);
  const auto faces = mesh_.faces;
  for (auto* values : {&terms_.mass, &terms_.pixels, &terms_.error}) values->push_back(1.0f);
  EXPECT_EQ(FinishSurface(pairs_, terms_, {}, &mesh_, kContext).num_dropped_faces, 0u);
  EXPECT_EQ(mesh_.faces, faces);
}

}  // namespace
}  // namespace lsmvs
