#include "lsmvs/surface/surface_extraction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <vector>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/mesh/inspect.h"
#include "lsmvs/test_support/expect_valid_mesh.h"

namespace lsmvs {
namespace {

Tetrahedralization RandomTetrahedra(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Eigen::Vector3f> points, sorted;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(uniform(random), uniform(random), uniform(random));
  }
  for (const uint32_t i : HilbertOrder(points)) sorted.push_back(points[i]);
  return BuildDelaunay(std::move(sorted));
}

void SetFull(bool full, Cell* cell) { cell->distance = full ? 0 : 1; }

// All empty but those that `is_full` says.
template <class IsFull>
void Label(Tetrahedralization* complex, const IsFull& is_full) {
  for (size_t c = 0; c < complex->cells.size(); ++c) {
    SetFull(c < complex->num_finite_cells && is_full(c), &complex->cells[c]);
  }
}

double CellVolume(const Tetrahedralization& complex, const Cell& cell) {
  const auto at = [&](int k) -> Eigen::Vector3d {
    return complex.points[static_cast<size_t>(cell.vertex[k])].cast<double>();
  };
  return (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) / 6;
}

double FullVolume(const Tetrahedralization& complex) {
  double volume = 0;
  for (size_t c = 0; c < complex.num_finite_cells; ++c) {
    if (!complex.cells[c].OnSourceSide()) volume += CellVolume(complex, complex.cells[c]);
  }
  return volume;
}

ExtractedSurface Extract(const Tetrahedralization& complex) { return ExtractSurface(complex); }

// Whatever the cut: a closed oriented manifold around the full cells.
TEST(SurfaceExtraction, RandomLabelsGiveAClosedManifoldOfTheFullVolume) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Tetrahedralization complex = RandomTetrahedra(150, seed);
    std::mt19937 random(seed);
    const unsigned share = 2 + seed % 4;  // a half to a fifth of the cells is full
    Label(&complex, [&](size_t) { return random() % share == 0; });
    const double volume = FullVolume(complex);
    const ExtractedSurface surface = Extract(complex);
    ExpectValidMesh(surface.mesh);
    const MeshInspection inspection = Inspect(surface.mesh);
    EXPECT_TRUE(inspection.IsClosed());
    EXPECT_TRUE(inspection.IsOriented());
    // Edges that many full cells share are split a little to the inside.
    EXPECT_NEAR(inspection.volume, volume, 0.01 * volume);
    EXPECT_GE(surface.mesh.faces.size(), surface.num_cut_facets);
  }
}

TEST(SurfaceExtraction, OneCellIsItsFourFacets) {
  Tetrahedralization complex = RandomTetrahedra(60, 1);
  const size_t cell = complex.num_finite_cells / 2;
  Label(&complex, [&](size_t c) { return c == cell; });
  const double volume = FullVolume(complex);
  const std::array<int32_t, 4> corners = complex.cells[cell].vertex;
  const ExtractedSurface surface = Extract(complex);
  EXPECT_EQ(surface.num_cut_facets, 4u);
  EXPECT_EQ(surface.mesh.faces.size(), 4u);
  EXPECT_EQ(surface.num_split_vertices, 0u);
  EXPECT_NEAR(Inspect(surface.mesh).volume, volume, 1e-12);
  std::vector<int32_t> expected(corners.begin(), corners.end()), found = surface.vertex_point;
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, expected);
}

// Two full cells that share a vertex only do not hang together; that vertex is there twice.
TEST(SurfaceExtraction, CellsThatTouchInAVertexAreApart) {
  Tetrahedralization complex = RandomTetrahedra(200, 3);
  const auto shared = [&](size_t a, size_t b) {
    int count = 0;
    for (const int32_t v : complex.cells[a].vertex) {
      count += complex.cells[b].IndexOfVertex(v) < 3 || complex.cells[b].vertex[3] == v;
    }
    return count;
  };
  for (size_t other = 1; other < complex.num_finite_cells; ++other) {
    if (shared(0, other) != 1) continue;
    Label(&complex, [&](size_t c) { return c == 0 || c == other; });
    const ExtractedSurface surface = Extract(complex);
    ExpectValidMesh(surface.mesh);
    EXPECT_EQ(surface.mesh.vertices.size(), 8u);
    EXPECT_EQ(surface.num_split_vertices, 1u);
    EXPECT_EQ(Inspect(surface.mesh).num_components, 2u);
    return;
  }
  FAIL() << "no such cells";
}

// Full space that reaches the hull leaves the surface open there.
TEST(SurfaceExtraction, FullInfinityLeavesTheHullOpen) {
  Tetrahedralization complex = RandomTetrahedra(60, 4);
  for (size_t c = 0; c < complex.cells.size(); ++c) SetFull(true, &complex.cells[c]);
  SetFull(false, &complex.cells[complex.num_finite_cells / 2]);
  const ExtractedSurface pocket = Extract(complex);
  EXPECT_EQ(pocket.mesh.faces.size(), 4u);
  EXPECT_LT(Inspect(pocket.mesh).volume, 0);  // seen from inside
  for (Cell& cell : complex.cells) SetFull(true, &cell);
  EXPECT_TRUE(Extract(complex).mesh.faces.empty());
}

}  // namespace
}  // namespace lsmvs
