#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "lsmvs/exporting/export_frame.h"
#include "lsmvs/exporting/georeference.h"
#include "lsmvs/exporting/page_files.h"
#include "lsmvs/mesh/textured_mesh.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct TilesetOptions {
  // Largest number of faces of a tile. More make fewer and larger files.
  int max_tile_faces = 65536;
  // Largest number of millions of texels of a tile: what a viewer loads at once.
  double max_tile_megatexels = 2.5;
  // Texels that a tile's error stands for at least. A viewer that shows errors of at most 16 pixels
  // (the default of Cesium) then loads finer tiles when a texel covers more than a pixel.
  double texels_of_error = 16;

  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

struct TilesetSummary {
  size_t num_tiles = 0;
  int num_levels = 0;
};

// What a folder must not hold before, unless it may be replaced: "tileset.json" and "tiles".
//
// Writes a tileset of 3D Tiles 1.1: `folder`/tileset.json and `folder`/tiles/*.glb.
// - Explicit tiling, refinement REPLACE. The leaves divide the faces of the mesh by an octree; a
//   parent stands for its children with about a quarter of their faces and texels
//   (tiles/coarser_tile.h). Tiles that meet share their border's vertices whatever their level, and
//   have skirts there.
// - geometricError: 0 for leaves; else a bound on the distance to the mesh, but at least
//   texels_of_error texels, and more than that of the children.
// - Bounding volumes are boxes that hold the tile and its children.
// - Coordinates: z up by `directions` without `origin`, in the unit of the mesh. With it the mesh's
//   coordinates are metres east, north and up of it, and the tileset lies there on the Earth. The
//   root's transform holds the large numbers in double precision; positions are relative to the
//   middle of their tile.
// - Textures are JPEG unless `encoding` says otherwise; materials are unlit.
//
// tileset.json is written last: without it the folder is no tileset. Holds one branch of the tree
// in memory, and pages within the budget. Deterministic for any number of threads.
TilesetSummary ExportTileset(const std::filesystem::path& folder, const TexturedMesh& textured,
                             const ExportDirections& directions,
                             const std::optional<GeodeticPosition>& origin,
                             const TextureEncoding& encoding, const TilesetOptions& options,
                             const RunContext& context);

}  // namespace lsmvs
