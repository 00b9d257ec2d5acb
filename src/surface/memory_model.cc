#include "lsmvs/surface/memory_model.h"

#include <algorithm>

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/tetrahedralization.h"

namespace lsmvs {

namespace {

// Of a Delaunay complex of points near a surface.
constexpr size_t kCellsPer100Vertices = 675;
constexpr size_t kFacetsPerVertex = 2;

}  // namespace

size_t MeshingSize::CloudBytes() const {
  constexpr size_t kPerPoint = 2 * sizeof(float[3]) + sizeof(Color) + sizeof(uint64_t);
  return kPerPoint * num_points + sizeof(uint32_t) * num_view_entries;
}

size_t MeshingSize::MergingBytes() const {
  constexpr size_t kIndices = 2 * sizeof(uint32_t);  // a point's place in the order and its vertex
  // Position, seed point and next one in its cell, in arrays that have grown; the grid's table, of
  // 16 bytes an entry and a third full, with the half as large one that it grew from.
  constexpr size_t kPerVertex = (12 + 4 + 4) * 3 / 2 + 16 * 3 * 3 / 2;
  return kIndices * num_points + kPerVertex * num_vertices;
}

size_t MeshingSize::SortingBytes() const {
  constexpr size_t kPositions = 4 + 16, kCounts = 12, kPerView = 4;
  return std::max(kPositions * num_points, kCounts * num_points + kPerView * num_view_entries);
}

size_t MeshingSize::CuttingBytes() const {
  const size_t num_cells = num_vertices * kCellsPer100Vertices / 100;
  // Position, incident cell; normal, colour, begin of the sights.
  constexpr size_t kPerVertex = 12 + 4 + 12 + 3 + 8;
  // The walkers' positions and sigmas, and the cells' steps of one view in each thread; or facets.
  constexpr size_t kWalkerPerVertex = 20, kStepPerCell = 4, kFacet = 36;
  const size_t walking =
      kWalkerPerVertex * num_vertices + kStepPerCell * num_cells * static_cast<size_t>(num_threads);
  const size_t extracting = kFacet * kFacetsPerVertex * num_vertices;
  return sizeof(Cell) * num_cells + kPerVertex * num_vertices + sizeof(Sight) * num_sights +
         std::max(walking, extracting);
}

size_t MeshingSize::CheckpointBytes() const {
  // Position, normal, colour, number of sights; a bit for each cell.
  constexpr size_t kPerVertex = 12 + 12 + 3 + 4 + 1, kPerSight = 6;
  return kPerVertex * num_vertices + kPerSight * num_sights;
}

size_t MeshingSize::PeakBytes() const {
  const size_t cutting = CuttingBytes(), cloud = CloudBytes();
  return std::max(MergingBytes(), cutting > cloud ? cutting - cloud : 0);
}

}  // namespace lsmvs
