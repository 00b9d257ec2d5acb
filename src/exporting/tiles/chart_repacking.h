#pragma once

#include <vector>

#include "lsmvs/exporting/tiles/tile_mesh.h"
#include "lsmvs/mesh/texture_pages.h"

namespace lsmvs {

// The finest tile of some faces: their charts, with the texels around them, are copied to a page of
// the tile's own. No texel is changed. Vertices are those of the faces, in the order of their first
// use. Without texture (`pages` is null) the tile has the vertices' colours. `error` is 0.
TileMesh MakeFinestTile(const TexturedMesh& textured, const TexturePages* pages,
                        const std::vector<int>& faces);

}  // namespace lsmvs
