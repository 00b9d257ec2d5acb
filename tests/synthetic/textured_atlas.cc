#include "lsmvs/synthetic/textured_atlas.h"

#include <fmt/format.h>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

TexturedMesh PaintAtlas(const TriangleMesh& mesh,
                        const std::function<Color(const Eigen::Vector3d& x_in_world)>& color,
                        const std::filesystem::path& folder, const AtlasOptions& options) {
  const int cell = options.chart_px + 2 * options.gutter_px;
  const int columns = options.page_width / cell, rows = options.page_height / cell;
  LSMVS_CHECK_GT(columns * rows, 0);
  TexturedMesh textured;
  textured.mesh = mesh;
  textured.page_width = options.page_width;
  textured.page_height = options.page_height;
  const size_t per_page = static_cast<size_t>(columns * rows);
  ColorImage page;
  const auto flush = [&] {
    if (page.empty()) return;
    textured.pages.push_back(folder / fmt::format("{}{}.png", options.name, textured.pages.size()));
    WritePng(textured.pages.back(), page);
  };
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const int place = static_cast<int>(f % per_page);
    if (place == 0) {
      flush();
      page = ColorImage(options.page_width, options.page_height, Color(255, 0, 255));
    }
    const int left = place % columns * cell, top = place / columns * cell;
    const Eigen::Vector3i& face = mesh.faces[f];
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    const Eigen::Vector3d right = (mesh.vertices[face[1]] - a) / options.chart_px,
                          down = (mesh.vertices[face[2]] - a) / options.chart_px;
    for (int y = 0; y < cell; ++y) {
      for (int x = 0; x < cell; ++x) {
        page(left + x, top + y) =
            color(a + (x + 0.5 - options.gutter_px) * right + (y + 0.5 - options.gutter_px) * down);
      }
    }
    const float x = static_cast<float>(left + options.gutter_px),
                y = static_cast<float>(top + options.gutter_px),
                side = static_cast<float>(options.chart_px);
    textured.texcoords.push_back(
        {Eigen::Vector2f(x, y), Eigen::Vector2f(x + side, y), Eigen::Vector2f(x, y + side)});
    textured.page_idx.push_back(static_cast<uint16_t>(f / per_page));
  }
  flush();
  return textured;
}

}  // namespace lsmvs
