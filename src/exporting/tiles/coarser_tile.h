#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/exporting/tiles/tile_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct CoarserTileOptions {
  size_t max_faces = 65536;
  double max_texels = 2.5e6;
};

// One tile in place of several finer ones: their union with about a quarter of their faces and of
// their texels, but not less than a quarter of what a tile may have. `is_locked` says of each
// vertex of the finest mesh whether faces outside of the tiles use it: those vertices and the edges
// between them stay, so that the tile fits its neighbours, whatever their level, to the last bit.
//
// The texture is made anew: the simplified faces are laid flat (UnfoldCharts), and each texel gets
// the colour of the nearest point of the finer tiles, averaged over its size there. It needs no
// photos, so that it works for meshes of any origin, and a level looks like the blurred finer one:
// nothing jumps when a viewer changes levels. Without texture, vertices take the colours of the
// finer tiles' vertices.
//
// `error` is the largest of the finer tiles' errors plus the distance between both surfaces,
// measured at all vertices of both and at the centroids of the new faces. Deterministic. About 3
// microseconds per texel and 20 per face.
TileMesh MakeCoarserTile(const std::vector<const TileMesh*>& finer,
                         const std::vector<uint8_t>& is_locked, const CoarserTileOptions& options,
                         const RunContext& context);

}  // namespace lsmvs
