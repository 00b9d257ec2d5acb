#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "lsmvs/surface/cell_complex.h"

namespace lsmvs {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<int32_t, Kernel>;
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<int32_t, Kernel,
                                              CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<Kernel,
                                   CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

constexpr int kNumRounds = 12;

// Biased randomised insertion order: each round holds about half of what is left, rounds are walked
// through in spatial order.
std::vector<uint32_t> InsertionOrder(size_t count) {
  std::array<size_t, kNumRounds + 1> begin = {};
  const auto round = [](size_t i) {
    const uint64_t hash = (i + 1) * 0x9E3779B97F4A7C15ull;
    return kNumRounds - 1 - std::min(kNumRounds - 1, std::countr_one(hash >> 20));
  };
  for (size_t i = 0; i < count; ++i) ++begin[round(i) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<uint32_t> order(count);
  for (size_t i = 0; i < count; ++i) order[begin[round(i)]++] = static_cast<uint32_t>(i);
  return order;
}

void Insert(CellComplex* complex, Delaunay* delaunay) {
  Delaunay::Cell_handle hint;
  for (const uint32_t i : InsertionOrder(complex->points.size())) {
    const Eigen::Vector3f& x = complex->points[i];
    const size_t before = delaunay->number_of_vertices();
    const auto vertex = delaunay->insert({x.x(), x.y(), x.z()}, hint);
    if (delaunay->number_of_vertices() == before) {
      complex->duplicates.push_back({static_cast<int32_t>(i), vertex->info()});
    } else {
      vertex->info() = static_cast<int32_t>(i);
    }
    hint = vertex->cell();
  }
  delaunay->infinite_vertex()->info() = Cell::kInfiniteVertex;
  std::sort(complex->duplicates.begin(), complex->duplicates.end());
}

// Numbers the cells: finite ones first, each part in the order of its lowest vertex, so that
// neighbours lie close.
void NumberCells(CellComplex* complex, Delaunay* delaunay) {
  const size_t num_vertices = complex->points.size();
  std::vector<uint32_t> begin(2 * num_vertices + 1, 0);
  const auto bucket = [&](const auto& cell) {
    uint32_t lowest = std::numeric_limits<uint32_t>::max();
    for (int k = 0; k < 4; ++k) {
      lowest = std::min(lowest, static_cast<uint32_t>(cell.vertex(k)->info()));
    }
    return lowest + (cell.info() != 0 ? num_vertices : 0);
  };
  for (auto it = delaunay->all_cells_begin(); it != delaunay->all_cells_end(); ++it) {
    it->info() = delaunay->is_infinite(it) ? 1 : 0;
    ++begin[bucket(*it) + 1];
    complex->num_finite_cells += (it->info() == 0);
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  for (auto it = delaunay->all_cells_begin(); it != delaunay->all_cells_end(); ++it) {
    it->info() = static_cast<int32_t>(begin[bucket(*it)]++);
  }
}

void CopyCells(CellComplex* complex, const Delaunay& delaunay) {
  complex->cells.resize(delaunay.tds().number_of_cells());
  complex->incident_cell.assign(complex->points.size(), -1);
  for (auto it = delaunay.all_cells_begin(); it != delaunay.all_cells_end(); ++it) {
    Cell& cell = complex->cells[it->info()];
    for (int k = 0; k < 4; ++k) {
      cell.vertex[k] = it->vertex(k)->info();
      cell.neighbor[k] = it->neighbor(k)->info();
      cell.SetReverse(k, it->neighbor(k)->index(it));
    }
  }
  for (size_t c = complex->num_finite_cells; c-- > 0;) {
    for (const int32_t v : complex->cells[c].vertex) {
      complex->incident_cell[v] = static_cast<int32_t>(c);
    }
  }
}

}  // namespace

CellComplex BuildDelaunay(std::vector<Eigen::Vector3f> points) {
  CellComplex complex;
  complex.points = std::move(points);
  Delaunay delaunay;
  Insert(&complex, &delaunay);
  if (delaunay.dimension() < 3) return complex;
  NumberCells(&complex, &delaunay);
  CopyCells(&complex, delaunay);
  return complex;
}

}  // namespace lsmvs
