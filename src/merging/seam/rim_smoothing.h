#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lsmvs/merging/overlap/mesh_band.h"

namespace lsmvs {

// Faces of `kept` (#F) that make a ragged rim are taken out: teeth that hang on one edge, faces at
// vertices where the rest touches itself, and pieces of fewer than `min_num_faces` faces without
// contact to faces outside of the band.
void SmoothRim(const MeshBand& band, size_t min_num_faces, std::vector<uint8_t>* kept);

}  // namespace lsmvs
