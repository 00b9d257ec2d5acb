#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/exporting/export_frame.h"
#include "lsmvs/exporting/page_files.h"
#include "lsmvs/mesh/textured_mesh.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What an export writes beside or instead of `path`, so that the caller can see what is there
// already. In the order in which they are written; `path` comes last.
std::vector<std::filesystem::path> PlyExportFiles(const std::filesystem::path& path,
                                                  const TexturedMesh& textured,
                                                  const TextureEncoding& encoding);
std::vector<std::filesystem::path> ObjExportFiles(const std::filesystem::path& path,
                                                  const TexturedMesh& textured,
                                                  const TextureEncoding& encoding);
std::vector<std::filesystem::path> GlbExportFiles(const std::filesystem::path& path,
                                                  const TexturedMesh& textured);

// Each writes a mesh with its texture or its vertex colours; the mesh has faces and finite
// vertices. PLY: as WriteTexturedPly, coordinates in the world (double where single precision would
// lose them). OBJ: as WriteObj. GLB: one file, y up by `directions`, compressed if `compress` says
// so (GlbModel). Where coordinates are large, OBJ and GLB hold them minus an offset, which is
// written as "x y z" to <stem>.offset.txt.
void ExportPly(const std::filesystem::path& path, const TexturedMesh& textured,
               const TextureEncoding& encoding);
void ExportObj(const std::filesystem::path& path, const TexturedMesh& textured,
               const TextureEncoding& encoding);
void ExportGlb(const std::filesystem::path& path, const TexturedMesh& textured,
               const ExportDirections& directions, const TextureEncoding& encoding,
               bool compress = false);

}  // namespace lsmvs
