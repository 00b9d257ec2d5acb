#include "lsmvs/refinement/step/noise_filter.h"

#include <gtest/gtest.h>

#include "lsmvs/mesh/normal_filter.h"
#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {
namespace {

constexpr int kSquares = 10;
constexpr int kSpike = 5 * (kSquares + 1) + 5;

// A sheet of squares of side 1 with a spike of height 1, and inside of that a needle that stands
// upright.
TriangleMesh SpikeOverNeedle() {
  TriangleMesh mesh;
  for (int k = 0; k < (kSquares + 1) * (kSquares + 1); ++k) {
    mesh.vertices.emplace_back(k % (kSquares + 1), k / (kSquares + 1), k == kSpike ? 1 : 0);
  }
  for (int k = 0; k < kSquares * kSquares; ++k) {
    const int a = k / kSquares * (kSquares + 1) + k % kSquares, c = a + kSquares + 1;
    mesh.faces.emplace_back(a, a + 1, c + 1);
    mesh.faces.emplace_back(a, c + 1, c);
  }
  const int needle = static_cast<int>(mesh.vertices.size());
  for (const auto& [x, z] : {std::pair(5.0, 0.02), {5.02, 0.7}, {4.98, 0.7}}) {
    mesh.vertices.emplace_back(x, 5.01, z);
  }
  mesh.faces.emplace_back(needle, needle + 1, needle + 2);
  return mesh;
}

size_t NumCrossings(const TriangleMesh& mesh) {
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  return FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, RunContext(1)).size();
}

TEST(FilterNoise, TakesBackWhatWouldCross) {
  TriangleMesh mesh = SpikeOverNeedle(), crossing = mesh;
  ASSERT_EQ(NumCrossings(mesh), 0u);
  FilterNormals({}, ShortestEdges(mesh), RunContext(1), &crossing);
  ASSERT_GT(NumCrossings(crossing), 0u);
  FilterNoise(2, 3.5, std::vector<double>(mesh.vertices.size(), 1.0), &mesh, RunContext(2));
  EXPECT_EQ(NumCrossings(mesh), 0u);
  EXPECT_EQ(mesh.vertices[kSpike][2], 1);
}

TEST(FilterNoise, ShapeLargerThanTheWindowsStays) {
  TriangleMesh mesh = SpikeOverNeedle();
  mesh.faces.pop_back();
  const TriangleMesh before = mesh;
  // Edges of 1 are 10 pixels long.
  FilterNoise(2, 3.5, std::vector<double>(mesh.vertices.size(), 0.1), &mesh, RunContext(1));
  EXPECT_EQ(mesh.vertices, before.vertices);
  FilterNoise(0, 3.5, std::vector<double>(mesh.vertices.size(), 1.0), &mesh, RunContext(1));
  EXPECT_EQ(mesh.vertices, before.vertices);
  FilterNoise(2, 3.5, std::vector<double>(mesh.vertices.size(), 1.0), &mesh, RunContext(1));
  EXPECT_LT(mesh.vertices[kSpike][2], 0.4);
}

}  // namespace
}  // namespace lsmvs
