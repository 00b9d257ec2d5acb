#pragma once

#include <cstddef>

namespace lsmvs {

// What the surface stage holds at once, in bytes, from the sizes of its arrays. Peaks of real runs
// are within a fifth of it (tests/surface/memory_model_test.cc).
struct MeshingSize {
  size_t num_points = 0, num_view_entries = 0;  // of the cloud
  size_t num_vertices = 0;                      // once points are merged
  size_t num_sights = 0;                        // (vertex, view) pairs
  int num_threads = 1;

  // The cloud itself, which is there before and is freed once it is merged.
  size_t CloudBytes() const;
  // Beside the cloud, while points are merged: the order and vertex of each point, the grid of
  // vertices.
  size_t MergingBytes() const;
  // Beside the cloud, in scratch memory only: while its points are sorted by place, before they are
  // merged.
  size_t SortingBytes() const;
  // Without the cloud, while rays are walked or facets collected: the cells above all.
  size_t CuttingBytes() const;
  // Growth of a process that holds the cloud.
  size_t PeakBytes() const;
  // On disk, of the merged points and the labels; see MeshVisibilityCloud.
  size_t CheckpointBytes() const;
};

}  // namespace lsmvs
