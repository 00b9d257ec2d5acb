#include "lsmvs/refinement/regions/face_regions.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <vector>

#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/mesh/inspect.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

std::vector<size_t> Sizes(const FaceRegions& regions) {
  std::vector<size_t> sizes(static_cast<size_t>(regions.count), 0);
  for (const int32_t region : regions.of_face) ++sizes[static_cast<size_t>(region)];
  return sizes;
}

// Faces of each region that can be reached over edges from its first face, within it.
std::vector<size_t> ReachedSizes(const TriangleMesh& mesh, const FaceRegions& regions) {
  const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
  std::vector<size_t> reached(static_cast<size_t>(regions.count), 0);
  std::vector<char> seen(mesh.faces.size(), 0), begun(reached.size(), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto region = static_cast<size_t>(regions.of_face[f]);
    if (begun[region]) continue;
    begun[region] = seen[f] = 1;
    std::vector<size_t> open = {f};
    while (!open.empty()) {
      const size_t face = open.back();
      open.pop_back();
      ++reached[region];
      for (const int32_t next : neighbors[face]) {
        if (next < 0 || seen[static_cast<size_t>(next)]) continue;
        if (regions.of_face[static_cast<size_t>(next)] != regions.of_face[f]) continue;
        seen[static_cast<size_t>(next)] = 1;
        open.push_back(static_cast<size_t>(next));
      }
    }
  }
  return reached;
}

TEST(FaceRegions, AreConnectedAndOfAboutTheSizeAskedFor) {
  const TriangleMesh mesh = GridMesh(41);
  for (const int size : {16, 100, 500}) {
    const FaceRegions regions = GrowFaceRegions(mesh, size);
    ASSERT_EQ(regions.of_face.size(), mesh.faces.size());
    const std::vector<size_t> sizes = Sizes(regions);
    EXPECT_EQ(ReachedSizes(mesh, regions), sizes);
    for (const size_t faces : sizes) {
      EXPECT_GE(faces, static_cast<size_t>(size) / 4);
      EXPECT_LE(faces, static_cast<size_t>(2 * size));
    }
  }
}

TEST(FaceRegions, PiecesThatDoNotTouchStayApart) {
  TriangleMesh mesh = GridMesh(3);
  const TriangleMesh other = GridMesh(2);
  for (const Eigen::Vector3i& face : other.faces) mesh.faces.push_back(face.array() + 9);
  for (const Eigen::Vector3d& x : other.vertices) {
    mesh.vertices.push_back(x + Eigen::Vector3d(9, 0, 0));
  }
  const FaceRegions regions = GrowFaceRegions(mesh, 1000);
  EXPECT_EQ(Sizes(regions), (std::vector<size_t>{8, 2}));
}

TEST(FaceRegions, AMeshWithoutFacesHasNone) {
  const FaceRegions regions = GrowFaceRegions({}, 10);
  EXPECT_EQ(regions.count, 0);
  EXPECT_TRUE(regions.of_face.empty());
}

// Triangles by their corners, whatever the numbers of faces and vertices.
std::multiset<std::vector<double>> Corners(const TriangleMesh& mesh) {
  std::multiset<std::vector<double>> triangles;
  for (const Eigen::Vector3i& face : mesh.faces) {
    std::vector<double> corners;
    for (const int v : face) {
      const Eigen::Vector3d& x = mesh.vertices[static_cast<size_t>(v)];
      corners.insert(corners.end(), {x.x(), x.y(), x.z()});
    }
    triangles.insert(corners);
  }
  return triangles;
}

TEST(FaceRegions, OrderChangesNoTriangleAndKeepsVerticesWithTheirPlaces) {
  TriangleMesh mesh = GridMesh(30);
  mesh.vertices.push_back({100, 100, 100});  // of no face
  std::vector<Eigen::Vector3d> places = mesh.vertices;
  for (Eigen::Vector3d& x : places) x *= 2;
  const auto corners = Corners(mesh);
  OrderAlongCurve(&mesh, &places);
  EXPECT_EQ(Corners(mesh), corners);
  EXPECT_EQ(mesh.vertices.size(), 900u);
  ASSERT_EQ(places.size(), mesh.vertices.size());
  for (size_t v = 0; v < places.size(); ++v) EXPECT_EQ(places[v], 2 * mesh.vertices[v]);

  const FaceRegions regions = GrowFaceRegions(mesh, 64);
  OrderByRegions(regions, &mesh, &places);
  EXPECT_EQ(Corners(mesh), corners);
  for (size_t v = 0; v < places.size(); ++v) EXPECT_EQ(places[v], 2 * mesh.vertices[v]);
  // Vertices lie in the order in which faces first use them.
  int highest = -1;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (const int v : face) {
      EXPECT_LE(v, highest + 1);
      highest = std::max(highest, v);
    }
  }
}

// Along the curve neighbours are near: so are the faces that a block of the mesh holds.
TEST(FaceRegions, BlocksAlongTheCurveAreCompact) {
  TriangleMesh mesh = GridMesh(65);
  std::vector<Eigen::Vector3d> places = mesh.vertices;
  OrderAlongCurve(&mesh, &places);
  constexpr size_t kBlock = 512;  // of the area of 16 x 16 cells
  double sum = 0;
  for (size_t begin = 0; begin < mesh.faces.size(); begin += kBlock) {
    Eigen::AlignedBox3d box;
    for (size_t f = begin; f < begin + kBlock; ++f) box.extend(FaceMiddle(mesh, f));
    sum += box.sizes().maxCoeff();
  }
  // Rows of faces, as the grid has them, reach over all of its 64 cells.
  EXPECT_LT(sum / (static_cast<double>(mesh.faces.size()) / kBlock), 33);
}

}  // namespace
}  // namespace lsmvs
