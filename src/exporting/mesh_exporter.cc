#include "lsmvs/exporting/mesh_exporter.h"

#include <fmt/format.h>

#include "lsmvs/exporting/files/glb_file.h"
#include "lsmvs/exporting/files/obj_file.h"
#include "lsmvs/exporting/pages/page_parts.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

fs::path OffsetPath(const fs::path& path) {
  return fs::path(path).replace_extension(".offset.txt");
}

void WriteOffset(const fs::path& path, const Eigen::Vector3d& offset) {
  if (offset.isZero(0.0)) return;
  WriteFileAtomically(OffsetPath(path), fmt::format("{} {} {}\n", offset[0], offset[1], offset[2]));
}

void AddOffsetFile(const fs::path& path, const TexturedMesh& textured,
                   std::vector<fs::path>* files) {
  if (!ExportOffset(textured.mesh).isZero(0.0)) files->push_back(OffsetPath(path));
}

bool SameContent(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::file_size(a, error) == fs::file_size(b, error) && !error && HashFile(a) == HashFile(b);
}

// The targets that are not the mesh's own pages, nor copies of them that are there already.
std::vector<fs::path> NewPages(const TexturedMesh& textured, const std::vector<fs::path>& targets) {
  std::vector<fs::path> files;
  for (size_t p = 0; p < targets.size(); ++p) {
    if (!SameContent(targets[p], textured.pages[p])) files.push_back(targets[p]);
  }
  return files;
}

GlbPart MakePart(const TriangleMesh& mesh, const PagePart& part, const Eigen::Vector3d& offset) {
  GlbPart made;
  made.uv = part.uv;
  made.faces = part.faces;
  made.image = part.page;
  for (const int v : part.vertices) {
    made.positions.push_back((mesh.vertices[v] - offset).cast<float>());
    if (part.page < 0 && !mesh.vertex_colors.empty()) {
      made.colors.push_back(mesh.vertex_colors[v]);
    }
  }
  return made;
}

}  // namespace

std::vector<fs::path> PlyExportFiles(const fs::path& path, const TexturedMesh& textured,
                                     const TextureEncoding& encoding) {
  std::vector<fs::path> files = NewPages(textured, PageTargets(textured, path, encoding));
  files.push_back(path);
  return files;
}

std::vector<fs::path> ObjExportFiles(const fs::path& path, const TexturedMesh& textured,
                                     const TextureEncoding& encoding) {
  std::vector<fs::path> files = NewPages(textured, PageTargets(textured, path, encoding));
  if (textured.has_texture()) files.push_back(fs::path(path).replace_extension(".mtl"));
  AddOffsetFile(path, textured, &files);
  files.push_back(path);
  return files;
}

std::vector<fs::path> GlbExportFiles(const fs::path& path, const TexturedMesh& textured) {
  std::vector<fs::path> files;
  AddOffsetFile(path, textured, &files);
  files.push_back(path);
  return files;
}

void ExportPly(const fs::path& path, const TexturedMesh& textured,
               const TextureEncoding& encoding) {
  TexturedMesh placed = textured;
  placed.pages = PageTargets(textured, path, encoding);
  WritePages(textured, placed.pages, encoding);
  const Eigen::Vector3d offset = ExportOffset(textured.mesh);
  for (Eigen::Vector3d& x : placed.mesh.vertices) x -= offset;
  WriteTexturedPly(path, placed, offset);
}

void ExportObj(const fs::path& path, const TexturedMesh& textured,
               const TextureEncoding& encoding) {
  const std::vector<fs::path> pages = PageTargets(textured, path, encoding);
  WritePages(textured, pages, encoding);
  const Eigen::Vector3d offset = ExportOffset(textured.mesh);
  WriteOffset(path, offset);
  WriteObj(path, textured, pages, offset);
}

void ExportGlb(const fs::path& path, const TexturedMesh& textured,
               const ExportDirections& directions, const TextureEncoding& encoding, bool compress) {
  GlbModel model;
  model.compress = compress;
  model.offset = ExportOffset(textured.mesh);
  model.rotation = Eigen::Quaterniond(YUpFromWorld(directions));
  for (const PagePart& part : SplitByPage(textured)) {
    model.parts.push_back(MakePart(textured.mesh, part, model.offset));
    if (part.page < 0) continue;
    model.parts.back().image = static_cast<int>(model.images.size());
    model.images.push_back(EncodePage(textured.pages[static_cast<size_t>(part.page)], encoding));
  }
  WriteOffset(path, model.offset);
  WriteGlb(path, model);
}

}  // namespace lsmvs
