#include "lsmvs/mesh/spikes.h"

#include <gtest/gtest.h>

#include "simple_meshes.h"

namespace lsmvs {
namespace {

constexpr int kSquares = 20;
constexpr int kInside = 8 * (kSquares + 1) + 11;

// The plane z = 0 in squares of side 1, with vertices raised.
TriangleMesh PlaneWith(const std::vector<std::pair<int, double>>& raised) {
  TriangleMesh mesh = UnitSquareMesh(
      kSquares, [](double x, double y) { return Eigen::Vector3d(kSquares * x, kSquares * y, 0); });
  for (const auto& [v, height] : raised) mesh.vertices[static_cast<size_t>(v)][2] = height;
  return mesh;
}

std::vector<double> LeastEdges(const TriangleMesh& mesh, double length) {
  return std::vector<double>(mesh.vertices.size(), length);
}

TEST(SinkSpikes, SinksWhatStandsOutAlone) {
  TriangleMesh mesh = PlaneWith({{kInside, 10}});
  const TriangleMesh plane = PlaneWith({});
  EXPECT_EQ(SinkSpikes(LeastEdges(mesh, 3), RunContext(1), &mesh), std::vector<int32_t>{kInside});
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_LT((mesh.vertices[v] - plane.vertices[v]).norm(), 0.01);
  }
}

TEST(SinkSpikes, OneBehindTheOther) {
  // The second is no spike before the first is gone: it leads up to it.
  TriangleMesh mesh = PlaneWith({{kInside, 12}, {kInside + 1, 24}});
  EXPECT_EQ(SinkSpikes(LeastEdges(mesh, 3), RunContext(1), &mesh),
            (std::vector<int32_t>{kInside, kInside + 1}));
  for (const Eigen::Vector3d& x : mesh.vertices) EXPECT_LT(x[2], 3);
}

TEST(SinkSpikes, LeavesWhatIsNoSpike) {
  // Low ones, ones with others near by, and those on the border.
  for (const auto& [v, height, least] :
       {std::tuple(kInside, 1.2, 0.5), {kInside, 10.0, 20.0}, {5, 10.0, 3.0}}) {
    TriangleMesh mesh = PlaneWith({{v, height}});
    const TriangleMesh before = mesh;
    EXPECT_TRUE(SinkSpikes(LeastEdges(mesh, least), RunContext(1), &mesh).empty());
    EXPECT_EQ(mesh.vertices, before.vertices);
  }
  TriangleMesh sphere = SphereMesh(1);  // an octahedron, split once
  EXPECT_TRUE(SinkSpikes(LeastEdges(sphere, 0), RunContext(1), &sphere).empty());
}

// Of any length and direction: the grid cuts the boxes of very long faces.
TEST(SinkSpikes, StaysWhereItWouldPassThroughTheSurface) {
  for (const double height : {10.0, 300.0, -300.0}) {
    TriangleMesh mesh = PlaneWith({{kInside, height}});
    // A small upright piece inside of the spike, through the plane that it would leave.
    const int piece = static_cast<int>(mesh.vertices.size());
    const double sign = height > 0 ? 1 : -1;
    for (const auto& [x, z] : {std::pair(0.0, -0.2), {0.02, 1.8}, {-0.02, 1.8}}) {
      mesh.vertices.emplace_back(mesh.vertices[kInside] +
                                 Eigen::Vector3d(x, 0.01, sign * z - height));
    }
    mesh.faces.emplace_back(piece, piece + 1, piece + 2);
    EXPECT_TRUE(SinkSpikes(LeastEdges(mesh, 3), RunContext(1), &mesh).empty());
    EXPECT_EQ(mesh.vertices[kInside][2], height);
  }
}

}  // namespace
}  // namespace lsmvs
