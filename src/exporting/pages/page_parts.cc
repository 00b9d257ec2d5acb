#include "lsmvs/exporting/pages/page_parts.h"

#include <algorithm>
#include <array>

namespace lsmvs {

namespace {

// Gives each (vertex of the mesh, texture coordinates) of a part its number.
class PartBuilder {
 public:
  explicit PartBuilder(const TexturedMesh& textured)
      : textured_(textured), first_(textured.mesh.vertices.size(), -1) {}

  PagePart Build(int page, const std::vector<int>& faces) {
    PagePart part;
    part.page = page;
    next_.clear();
    for (const int f : faces) {
      Eigen::Vector3i corners;
      for (int c = 0; c < 3; ++c) corners[c] = Number(f, c, &part);
      part.faces.push_back(corners);
    }
    for (const int v : part.vertices) first_[v] = -1;
    return part;
  }

 private:
  int Number(int face, int corner, PagePart* part) {
    const int v = textured_.mesh.faces[face][corner];
    const Eigen::Vector2f uv =
        part->page < 0 ? Eigen::Vector2f(Eigen::Vector2f::Zero())
                       : Eigen::Vector2f(textured_.NormalizedTexcoord(face, corner).cast<float>());
    for (int i = first_[v]; i >= 0; i = next_[i]) {
      if (part->page < 0 || part->uv[i] == uv) return i;
    }
    const int number = static_cast<int>(part->vertices.size());
    part->vertices.push_back(v);
    if (part->page >= 0) part->uv.push_back(uv);
    next_.push_back(first_[v]);
    first_[v] = number;
    return number;
  }

  const TexturedMesh& textured_;
  std::vector<int> first_;  // #V: head of the list of a vertex's numbers
  std::vector<int> next_;
};

}  // namespace

std::vector<PagePart> SplitByPage(const TexturedMesh& textured) {
  std::vector<std::vector<int>> faces_of_page(std::max<size_t>(1, textured.pages.size()));
  for (size_t f = 0; f < textured.mesh.faces.size(); ++f) {
    faces_of_page[textured.has_texture() ? textured.page_idx[f] : 0].push_back(static_cast<int>(f));
  }
  PartBuilder builder(textured);
  std::vector<PagePart> parts;
  for (size_t p = 0; p < faces_of_page.size(); ++p) {
    if (faces_of_page[p].empty()) continue;
    parts.push_back(
        builder.Build(textured.has_texture() ? static_cast<int>(p) : -1, faces_of_page[p]));
  }
  return parts;
}

}  // namespace lsmvs
