#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/surface/tetrahedralization.h"

namespace lsmvs {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Oracle = CGAL::Delaunay_triangulation_3<
    Kernel, CGAL::Triangulation_data_structure_3<
                CGAL::Triangulation_vertex_base_with_info_3<int32_t, Kernel>>>;
using Points = std::vector<Eigen::Vector3f>;
using VertexSets = std::vector<std::array<int32_t, 4>>;

Points InHilbertOrder(const Points& points) {
  Points sorted;
  for (const uint32_t i : HilbertOrder(points)) sorted.push_back(points[i]);
  return sorted;
}

VertexSets SortedCells(const Tetrahedralization& complex) {
  VertexSets sets;
  for (const Cell& cell : complex.cells) {
    sets.push_back(cell.vertex);
    std::sort(sets.back().begin(), sets.back().end());
  }
  std::sort(sets.begin(), sets.end());
  return sets;
}

VertexSets SortedOracleCells(const Tetrahedralization& complex) {
  Oracle oracle;
  for (size_t i = 0; i < complex.points.size(); ++i) {
    const Eigen::Vector3f& x = complex.points[i];
    if (complex.incident_cell[i] < 0) continue;
    oracle.insert({x.x(), x.y(), x.z()})->info() = static_cast<int32_t>(i);
  }
  oracle.infinite_vertex()->info() = Cell::kInfiniteVertex;
  VertexSets sets;
  for (auto it = oracle.all_cells_begin(); it != oracle.all_cells_end(); ++it) {
    sets.push_back({it->vertex(0)->info(), it->vertex(1)->info(), it->vertex(2)->info(),
                    it->vertex(3)->info()});
    std::sort(sets.back().begin(), sets.back().end());
  }
  std::sort(sets.begin(), sets.end());
  return sets;
}

void ExpectConsistent(const Tetrahedralization& complex) {
  for (size_t c = 0; c < complex.cells.size(); ++c) {
    const Cell& cell = complex.cells[c];
    const auto infinite = std::count(cell.vertex.begin(), cell.vertex.end(), Cell::kInfiniteVertex);
    EXPECT_EQ(infinite, c < complex.num_finite_cells ? 0 : 1);
    for (int i = 0; i < 4; ++i) {
      const Cell& other = complex.cells[cell.neighbor[i]];
      const int j = cell.Reverse(i);
      EXPECT_EQ(other.neighbor[j], static_cast<int32_t>(c));
      EXPECT_EQ(other.Reverse(j), i);
      // The same three vertices, the other way round.
      std::array<int32_t, 3> mine, theirs;
      for (int k = 0; k < 3; ++k) {
        mine[k] = cell.vertex[kFacetVertices[i][k]];
        theirs[k] = other.vertex[kFacetVertices[j][2 - k]];
      }
      std::rotate(theirs.begin(), std::find(theirs.begin(), theirs.end(), mine[0]), theirs.end());
      EXPECT_EQ(mine, theirs);
    }
  }
  for (size_t v = 0; v < complex.points.size(); ++v) {
    const int32_t c = complex.incident_cell[v];
    if (c < 0) continue;
    const auto& vertices = complex.cells[c].vertex;
    EXPECT_NE(std::find(vertices.begin(), vertices.end(), static_cast<int32_t>(v)), vertices.end());
  }
}

void ExpectDelaunay(const Points& points) {
  const Tetrahedralization complex = BuildDelaunay(InHilbertOrder(points));
  ASSERT_FALSE(complex.cells.empty());
  ExpectConsistent(complex);
  EXPECT_EQ(SortedCells(complex), SortedOracleCells(complex));
}

Points RandomPoints(int count, int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<float> uniform(-1, 1);
  Points points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(uniform(random), uniform(random), uniform(random));
  return points;
}

TEST(Delaunay, OneTetrahedron) { ExpectDelaunay({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}); }

TEST(Delaunay, AgreesWithOracleInACube) { ExpectDelaunay(RandomPoints(3000, 1)); }

TEST(Delaunay, AgreesWithOracleOnASurface) {
  Points points = RandomPoints(3000, 2);
  for (Eigen::Vector3f& x : points) x.z() *= 1e-3f;
  ExpectDelaunay(points);
}

TEST(Delaunay, AgreesWithOracleOnAGrid) {
  Points points;
  for (int i = 0; i < 512; ++i) {
    points.emplace_back(static_cast<float>(i % 8), static_cast<float>(i / 8 % 8),
                        static_cast<float>(i / 64));
  }
  ExpectDelaunay(points);
}

TEST(Delaunay, AgreesWithOracleOnASphere) {
  Points points = RandomPoints(2000, 3);
  for (Eigen::Vector3f& x : points) x.normalize();
  ExpectDelaunay(points);
}

TEST(Delaunay, AgreesWithOracleOverManyScales) {
  Points points = RandomPoints(2000, 4);
  for (size_t i = 0; i < points.size(); ++i) points[i] *= std::exp2(-static_cast<float>(i % 30));
  ExpectDelaunay(points);
}

TEST(Delaunay, TwoPlanesAndDuplicates) {
  Points points;
  for (int i = 0; i < 200; ++i) {
    points.emplace_back(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10),
                        i < 100 ? 0.0f : 1.0f);
    if (i % 3 == 0) points.push_back(points.back());
  }
  const Tetrahedralization complex = BuildDelaunay(InHilbertOrder(points));
  EXPECT_EQ(complex.duplicates.size(), 67u);
  for (const auto& [copy, original] : complex.duplicates) {
    EXPECT_EQ(complex.points[copy], complex.points[original]);
    EXPECT_EQ(complex.incident_cell[copy], -1);
    EXPECT_GE(complex.incident_cell[original], 0);
  }
  ExpectConsistent(complex);
  EXPECT_EQ(SortedCells(complex), SortedOracleCells(complex));
}

TEST(Delaunay, NothingWithoutVolume) {
  EXPECT_TRUE(BuildDelaunay({}).cells.empty());
  EXPECT_TRUE(BuildDelaunay({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).cells.empty());
  EXPECT_TRUE(BuildDelaunay(Points(10, Eigen::Vector3f(1, 2, 3))).cells.empty());
  Points line, plane;
  for (int i = 0; i < 20; ++i) {
    line.push_back(0.5f * static_cast<float>(i) * Eigen::Vector3f(1, 2, 4));
    plane.emplace_back(static_cast<float>(i % 5), static_cast<float>(i / 5), 0.25f);
  }
  EXPECT_TRUE(BuildDelaunay(line).cells.empty());
  EXPECT_TRUE(BuildDelaunay(plane).cells.empty());
}

// The oracle's answer, wherever the walk starts.
TEST(Delaunay, LocatesPoints) {
  const Tetrahedralization complex = BuildDelaunay(InHilbertOrder(RandomPoints(500, 3)));
  const auto volume = [&](const Cell& cell, int moved, const Eigen::Vector3f& x) {
    std::array<Eigen::Vector3d, 4> corners;
    for (int k = 0; k < 4; ++k) {
      corners[k] = (k == moved ? x : complex.points[cell.vertex[k]]).cast<double>();
    }
    return (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[3] - corners[0]);
  };
  size_t num_inside = 0;
  for (const Eigen::Vector3f& point : RandomPoints(300, 4)) {
    const Eigen::Vector3f x = 1.2f * point;
    int32_t holder = -1;
    for (size_t c = 0; c < complex.num_finite_cells; ++c) {
      bool inside = true;
      for (int k = 0; k < 4; ++k) inside = inside && volume(complex.cells[c], k, x) > 0;
      if (inside) holder = static_cast<int32_t>(c);
    }
    for (const size_t start : {size_t{0}, complex.cells.size() / 2, complex.cells.size() - 1}) {
      const int32_t found = LocateCell(complex, x, static_cast<int32_t>(start));
      if (holder >= 0) {
        EXPECT_EQ(found, holder);
      } else {
        EXPECT_TRUE(complex.IsInfinite(found));
      }
    }
    num_inside += holder >= 0;
  }
  EXPECT_GT(num_inside, 50u);
  EXPECT_LT(num_inside, 300u);
}

}  // namespace
}  // namespace lsmvs
