#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// A triangle mesh whose faces show parts of texture pages (an atlas). The pages are image files:
// all of them never need to be in memory at once. Without pages it is a plain mesh, which may have
// vertex colours.
//
// Texture coordinates are in pixels of a page: x right, y down, the centre of the first texel at
// (0.5, 0.5). They refer to a page of page_width x page_height; a file of another size (other
// programs mix sizes) is stretched to it. Pages that we bake all have that size.
struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<std::array<Eigen::Vector2f, 3>> texcoords;  // #F, of the corners of each face
  std::vector<uint16_t> page_idx;                         // #F, indices into pages
  std::vector<std::filesystem::path> pages;               // PNG (ours) or JPEG files
  int page_width = 0, page_height = 0;                    // [px]; 0 without pages

  bool has_texture() const { return !pages.empty(); }

  // Texture coordinates of a corner as file formats want them: in [0, 1] of the page, x right, y
  // down (glTF).
  Eigen::Vector2d NormalizedTexcoord(size_t face, int corner) const {
    return texcoords[face][static_cast<size_t>(corner)].cast<double>().cwiseQuotient(
        Eigen::Vector2d(page_width, page_height));
  }

  // Whether all arrays fit each other and all indices and numbers are valid; if not, says what is
  // wrong in `error`. Does not look at the files. O(#F).
  bool Check(std::string* error) const;
};

}  // namespace lsmvs
