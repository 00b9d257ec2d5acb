#include "lsmvs/merging/overlap/surface_index.h"

#include <gtest/gtest.h>

#include "lsmvs/merging/zip/polygon_filling.h"
#include "lsmvs/synthetic/random.h"

namespace lsmvs {
namespace {

// Faces of all sizes, some of them edges and points.
struct Soup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;

  explicit Soup(int num_faces) {
    Random random(1);
    for (int f = 0; f < num_faces; ++f) {
      const Eigen::Vector3d middle = random.Gaussian3();
      for (int k = 0; k < 3; ++k) vertices.push_back(middle + 0.1 * random.Gaussian3());
      faces.emplace_back(3 * f, 3 * f + (f % 7 != 0), 3 * f + (f % 7 != 0) + (f % 5 != 0));
    }
  }
  Triangle3 At(size_t f) const {
    return {vertices[faces[f][0]], vertices[faces[f][1]], vertices[faces[f][2]]};
  }
};

TEST(SurfaceIndex, FindsWhatTryingAllFinds) {
  for (const int num_faces : {1, 7, 8, 9, 500}) {
    const Soup soup(num_faces);
    const SurfaceIndex index(soup.vertices, soup.faces);
    Random random(2);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector3d x = 1.5 * random.Gaussian3();
      const auto accept = [](int32_t f) { return f % 3 != 1; };
      double least = 0.8;
      for (size_t f = 0; f < soup.faces.size(); ++f) {
        if (!accept(static_cast<int32_t>(f))) continue;
        least = std::min(least, (ClosestOnTriangle(x, soup.At(f)) - x).norm());
      }
      const SurfaceIndex::Hit hit = index.Closest(x, 0.8, accept);
      ASSERT_EQ(hit.face >= 0, least < 0.8);
      if (hit.face < 0) continue;
      EXPECT_NEAR(hit.distance, least, 1e-12);
      EXPECT_NEAR((hit.point - x).norm(), least, 1e-12);
      EXPECT_TRUE(accept(hit.face));
    }
  }
}

TEST(SurfaceIndex, MayBeEmpty) {
  const SurfaceIndex index({}, {});
  EXPECT_LT(index.Closest(Eigen::Vector3d::Zero(), 1e9).face, 0);
}

// A notched polygon in the plane: triangles fill it once, and none lies outside.
TEST(FillPolygon, CoversItOnce) {
  const std::vector<Eigen::Vector3d> corners = {{0, 0, 0}, {4, 0, 0}, {4, 3, 0},
                                                {2, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  const std::vector<Eigen::Vector3d> normals(corners.size(), Eigen::Vector3d::UnitZ());
  const auto faces =
      FillPolygon(corners, normals, {0, 1, 2, 3, 4, 5}, [](int32_t, int32_t) { return true; });
  ASSERT_EQ(faces.size(), 4u);
  double area = 0;
  for (const Eigen::Vector3i& f : faces) {
    const double twice = (corners[f[1]] - corners[f[0]]).cross(corners[f[2]] - corners[f[0]]).z();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_NEAR(area, 12 - 3, 1e-12);
}

TEST(FillPolygon, KeepsToTheDiagonalsThatAreAllowed) {
  const std::vector<Eigen::Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<Eigen::Vector3d> normals(4, Eigen::Vector3d::UnitZ());
  const auto not_02 = [](int32_t a, int32_t b) { return a + b != 2 || a == b; };
  for (const Eigen::Vector3i& f : FillPolygon(corners, normals, {0, 1, 2, 3}, not_02)) {
    EXPECT_TRUE((f.array() == 1).any() && (f.array() == 3).any());
  }
  EXPECT_TRUE(
      FillPolygon(corners, normals, {0, 1, 2, 3}, [](int32_t, int32_t) { return false; }).empty());
}

}  // namespace
}  // namespace lsmvs
