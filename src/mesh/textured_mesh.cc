#include "lsmvs/mesh/textured_mesh.h"

#include <fmt/format.h>

namespace lsmvs {

namespace {

std::string ArrayFault(const TexturedMesh& textured) {
  const size_t num_faces = textured.mesh.faces.size();
  const size_t expected = textured.has_texture() ? num_faces : 0;
  if (textured.texcoords.size() != expected || textured.page_idx.size() != expected) {
    return fmt::format("{} faces have {} texcoords and {} page_idx; there should be {}", num_faces,
                       textured.texcoords.size(), textured.page_idx.size(), expected);
  }
  if (textured.has_texture() != (textured.page_width > 0 && textured.page_height > 0)) {
    return fmt::format("{} pages of {} x {} pixels", textured.pages.size(), textured.page_width,
                       textured.page_height);
  }
  const auto fits = [&](size_t size) { return size == 0 || size == textured.mesh.vertices.size(); };
  if (!fits(textured.mesh.vertex_colors.size()) || !fits(textured.mesh.vertex_normals.size())) {
    return "vertex_colors or vertex_normals have another size than vertices";
  }
  return "";
}

std::string FaceFault(const TexturedMesh& textured, size_t f) {
  const Eigen::Vector3i& face = textured.mesh.faces[f];
  if (face.minCoeff() < 0 ||
      static_cast<size_t>(face.maxCoeff()) >= textured.mesh.vertices.size()) {
    return fmt::format("face {} names a vertex that is not there", f);
  }
  if (!textured.has_texture()) return "";
  if (textured.page_idx[f] >= textured.pages.size()) {
    return fmt::format("face {} names page {}, but there are {}", f, textured.page_idx[f],
                       textured.pages.size());
  }
  for (const Eigen::Vector2f& texcoord : textured.texcoords[f]) {
    if (!texcoord.allFinite()) return fmt::format("texcoords of face {} are not finite", f);
  }
  return "";
}

}  // namespace

bool TexturedMesh::Check(std::string* error) const {
  *error = ArrayFault(*this);
  for (size_t f = 0; error->empty() && f < mesh.faces.size(); ++f) *error = FaceFault(*this, f);
  return error->empty();
}

}  // namespace lsmvs
