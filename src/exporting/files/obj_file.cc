#include "lsmvs/exporting/files/obj_file.h"

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "lsmvs/exporting/pages/page_parts.h"
#include "lsmvs/util/atomic_file.h"

namespace lsmvs {

namespace {

constexpr size_t kFlushBytes = size_t{1} << 16;

// Collects text and passes it on in large pieces.
class TextWriter {
 public:
  explicit TextWriter(AtomicFile* file) : file_(file) {}

  template <class... Values>
  void Add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    if (text_.size() >= kFlushBytes) Flush();
  }
  void Flush() {
    file_->Write(text_);
    text_.clear();
  }

 private:
  AtomicFile* file_;
  std::string text_;
};

std::string Materials(const std::vector<std::filesystem::path>& pages) {
  std::string text;
  for (size_t p = 0; p < pages.size(); ++p) {
    text += fmt::format("newmtl page_{}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nd 1\nillum 1\nmap_Kd {}\n",
                        p, pages[p].filename().string());
  }
  return text;
}

void WriteVertices(const TexturedMesh& textured, const Eigen::Vector3d& offset, TextWriter* out) {
  const TriangleMesh& mesh = textured.mesh;
  const bool has_colors = !textured.has_texture() && !mesh.vertex_colors.empty();
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3f x = (mesh.vertices[v] - offset).cast<float>();
    out->Add("v {} {} {}", x[0], x[1], x[2]);
    if (has_colors) {
      const Eigen::Vector3f color = mesh.vertex_colors[v].cast<float>() / 255;
      out->Add(" {:.5} {:.5} {:.5}", color[0], color[1], color[2]);
    }
    out->Add("\n");
  }
}

// `first_texcoord` counts on over the parts: OBJ numbers through, from 1.
void WritePart(const PagePart& part, size_t* first_texcoord, TextWriter* out) {
  for (const Eigen::Vector2f& uv : part.uv) out->Add("vt {} {}\n", uv[0], 1 - uv[1]);
  if (part.page >= 0) out->Add("usemtl page_{}\n", part.page);
  for (const Eigen::Vector3i& face : part.faces) {
    out->Add("f");
    for (const int i : face) {
      out->Add(" {}", part.vertices[i] + 1);
      if (part.page >= 0) out->Add("/{}", *first_texcoord + static_cast<size_t>(i));
    }
    out->Add("\n");
  }
  *first_texcoord += part.uv.size();
}

}  // namespace

void WriteObj(const std::filesystem::path& path, const TexturedMesh& textured,
              const std::vector<std::filesystem::path>& pages, const Eigen::Vector3d& offset) {
  std::filesystem::path material_path = path;
  material_path.replace_extension(".mtl");
  if (textured.has_texture()) WriteFileAtomically(material_path, Materials(pages));

  AtomicFile file(path);
  TextWriter out(&file);
  if (!offset.isZero(0.0)) {
    out.Add("# add {} {} {} to the coordinates\n", offset[0], offset[1], offset[2]);
  }
  if (textured.has_texture()) out.Add("mtllib {}\n", material_path.filename().string());
  WriteVertices(textured, offset, &out);
  size_t first_texcoord = 1;
  for (const PagePart& part : SplitByPage(textured)) WritePart(part, &first_texcoord, &out);
  out.Flush();
  file.Commit();
}

}  // namespace lsmvs
