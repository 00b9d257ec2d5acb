#include "lsmvs/exporting/tiles/chart_repacking.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <unordered_map>

#include "lsmvs/exporting/tiles/rectangle_packing.h"
#include "lsmvs/image/hole_filling.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/texture_charts.h"

namespace lsmvs {

namespace {

// Texels around a chart that come along: enough for two levels of mip maps.
constexpr int kGutterPx = 4;

// A block of texels of a page that holds one chart.
struct Block {
  int page = 0;
  Eigen::AlignedBox2f bounds;                        // of the texture coordinates [px of the file]
  Eigen::Vector2i corner = Eigen::Vector2i::Zero();  // in the page
  Eigen::Vector2i size = Eigen::Vector2i::Zero();
};

// The faces as a mesh of their own.
TexturedMesh Extract(const TexturedMesh& textured, const std::vector<int>& faces,
                     std::vector<int>* vertex_ids) {
  TexturedMesh part;
  part.pages = textured.pages;
  part.page_width = textured.page_width;
  part.page_height = textured.page_height;
  std::unordered_map<int, int> new_index;
  for (const int f : faces) {
    Eigen::Vector3i corners;
    for (int c = 0; c < 3; ++c) {
      const int v = textured.mesh.faces[f][c];
      const auto [entry, is_new] = new_index.try_emplace(v, static_cast<int>(vertex_ids->size()));
      corners[c] = entry->second;
      if (!is_new) continue;
      vertex_ids->push_back(v);
      part.mesh.vertices.push_back(textured.mesh.vertices[v]);
      if (textured.mesh.vertex_colors.empty()) continue;
      part.mesh.vertex_colors.push_back(textured.mesh.vertex_colors[v]);
    }
    part.mesh.faces.push_back(corners);
    if (!textured.has_texture()) continue;
    part.texcoords.push_back(textured.texcoords[f]);
    part.page_idx.push_back(textured.page_idx[f]);
  }
  return part;
}

std::vector<Block> BlocksOfCharts(const TexturedMesh& part, const TextureCharts& charts,
                                  const std::vector<Eigen::Vector2i>& page_sizes) {
  std::vector<Block> blocks(static_cast<size_t>(charts.num_charts));
  for (size_t f = 0; f < part.mesh.faces.size(); ++f) {
    Block& block = blocks[static_cast<size_t>(charts.chart_of_face[f])];
    block.page = part.page_idx[f];
    for (const Eigen::Vector2f& x : part.texcoords[f]) block.bounds.extend(x);
  }
  for (Block& block : blocks) {
    const Eigen::Vector2i limit = page_sizes[static_cast<size_t>(block.page)];
    const auto clamped = [&](const Eigen::Vector2f& x) {
      return Eigen::Vector2i(x.cast<int>().cwiseMax(0).cwiseMin(limit - Eigen::Vector2i(1, 1)));
    };
    const Eigen::Vector2f gutter = Eigen::Vector2f::Constant(kGutterPx);
    block.corner = clamped((block.bounds.min() - gutter).array().floor().matrix());
    block.size = clamped((block.bounds.max() + gutter).array().ceil().matrix()) - block.corner +
                 Eigen::Vector2i(1, 1);
  }
  return blocks;
}

// Texture coordinates in pixels of the files: pages may have sizes of their own.
std::vector<Eigen::Vector2i> ToFilePixels(const TexturePages& pages, TexturedMesh* part) {
  std::vector<Eigen::Vector2i> sizes(part->pages.size(), Eigen::Vector2i::Zero());
  for (size_t f = 0; f < part->mesh.faces.size(); ++f) {
    Eigen::Vector2i& size = sizes[part->page_idx[f]];
    if (size.x() == 0) size = pages.PageSize(part->page_idx[f]);
    const Eigen::Vector2f stretch = size.cast<float>().cwiseQuotient(
        Eigen::Vector2i(part->page_width, part->page_height).cast<float>());
    for (Eigen::Vector2f& x : part->texcoords[f]) x = x.cwiseProduct(stretch);
  }
  return sizes;
}

void RepackTexture(const TexturePages& pages, TexturedMesh* part, TileMesh* tile) {
  const std::vector<Eigen::Vector2i> page_sizes = ToFilePixels(pages, part);
  const TextureCharts charts = FindTextureCharts(*part);
  const std::vector<Block> blocks = BlocksOfCharts(*part, charts, page_sizes);
  std::vector<Eigen::Vector2i> sizes;
  for (const Block& block : blocks) sizes.push_back(block.size);
  const PackedRectangles packed = PackRectangles(sizes);

  tile->page = ColorImage(packed.page_size.x(), packed.page_size.y());
  ByteImage known(tile->page.width, tile->page.height, 0);
  std::vector<size_t> order(blocks.size());  // page by page: each is read once
  for (size_t b = 0; b < order.size(); ++b) order[b] = b;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return blocks[a].page < blocks[b].page; });
  for (const size_t b : order) {
    const Eigen::Vector2i &size = blocks[b].size, &target = packed.corners[b];
    pages.CopyBlock(static_cast<size_t>(blocks[b].page), blocks[b].corner, size, target,
                    &tile->page);
    for (int row = 0; row < size.y(); ++row) {
      std::fill_n(known.Row(target.y() + row) + target.x(), size.x(), uint8_t{1});
    }
  }
  FillHoles(known, &tile->page);
  tile->texcoords = part->texcoords;
  for (size_t f = 0; f < tile->texcoords.size(); ++f) {
    const size_t b = static_cast<size_t>(charts.chart_of_face[f]);
    const Eigen::Vector2f shift = (packed.corners[b] - blocks[b].corner).cast<float>();
    for (Eigen::Vector2f& x : tile->texcoords[f]) x += shift;
  }
}

}  // namespace

TileMesh MakeFinestTile(const TexturedMesh& textured, const TexturePages* pages,
                        const std::vector<int>& faces) {
  TileMesh tile;
  TexturedMesh part = Extract(textured, faces, &tile.vertex_ids);
  if (pages != nullptr) RepackTexture(*pages, &part, &tile);
  tile.mesh = std::move(part.mesh);
  if (pages != nullptr) tile.mesh.vertex_colors.clear();
  tile.texel_size =
      pages != nullptr ? MeanTexelSize(tile.mesh, tile.texcoords) : MeanEdgeLength(tile.mesh);
  return tile;
}

}  // namespace lsmvs
