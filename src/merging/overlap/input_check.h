#pragma once

#include <cstddef>
#include <string>

#include "lsmvs/merging/overlap/mesh_band.h"

namespace lsmvs {

struct RepairCounters {
  size_t num_dropped_faces = 0, num_split_vertices = 0;
};

// Makes a manifold of a mesh: drops faces that name a vertex twice, lie on another face or have no
// area, and copies vertices where the faces form more than one fan. Throws InputError, with `name`,
// if no face is left, or if more than a thousandth of the edges join faces that are not oriented
// alike; if fewer are, they are parted there. O(F log F); about 50 bytes a face.
RepairCounters RepairInput(const std::string& name, SourcedMesh* mesh);

}  // namespace lsmvs
