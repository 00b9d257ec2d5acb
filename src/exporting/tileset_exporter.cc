#include "lsmvs/exporting/tileset_exporter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "lsmvs/exporting/files/glb_file.h"
#include "lsmvs/exporting/pages/page_parts.h"
#include "lsmvs/exporting/tiles/chart_repacking.h"
#include "lsmvs/exporting/tiles/coarser_tile.h"
#include "lsmvs/exporting/tiles/skirts.h"
#include "lsmvs/exporting/tiles/surface_octree.h"
#include "lsmvs/mesh/texture_charts.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kSkirtTexels = 2, kSkirtEdges = 0.25;
constexpr int kGutterPx = 4;
// Parents are coarser than their children for every viewer.
constexpr double kLeastErrorRatio = 1.25;
// Room in boxes, as a share of their size: for the rounding of positions, and for that of boxes.
constexpr double kBoxMargin = 1e-5, kNestingMargin = 1e-9;

// Texels that each face takes: its share of its chart's rectangle.
std::vector<double> TexelsOfFaces(const TexturedMesh& textured) {
  std::vector<double> texels(textured.mesh.faces.size(), 0);
  const TextureCharts charts = FindTextureCharts(textured);
  std::vector<Eigen::AlignedBox2f> boxes(static_cast<size_t>(charts.num_charts));
  std::vector<double> areas(boxes.size(), 0);
  const auto area_of = [&](size_t f) { return TriangleArea(textured.texcoords[f]) + 1e-3; };
  for (size_t f = 0; f < charts.chart_of_face.size(); ++f) {
    const size_t chart = static_cast<size_t>(charts.chart_of_face[f]);
    for (const Eigen::Vector2f& x : textured.texcoords[f]) boxes[chart].extend(x);
    areas[chart] += area_of(f);
  }
  for (size_t f = 0; f < charts.chart_of_face.size(); ++f) {
    const size_t chart = static_cast<size_t>(charts.chart_of_face[f]);
    const Eigen::Vector2f size = boxes[chart].sizes().array() + 2 * kGutterPx;
    texels[f] = static_cast<double>(size.x()) * size.y() * area_of(f) / areas[chart];
  }
  return texels;
}

Eigen::AlignedBox3d Grown(const Eigen::AlignedBox3d& box, double share) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(share * (box.diagonal().norm() + 1e-9));
  return {Eigen::Vector3d(box.min() - margin), Eigen::Vector3d(box.max() + margin)};
}

Json Numbers(const double* values, size_t count) {
  return Json(std::vector<double>(values, values + count));
}

Json BoxVolume(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d center = box.center(), half = 0.5 * box.sizes();
  const double values[12] = {center[0], center[1], center[2], half[0], 0, 0,
                             0,         half[1],   0,         0,       0, half[2]};
  return {{"box", Numbers(values, 12)}};
}

class TilesetWriter {
 public:
  TilesetWriter(const fs::path& folder, const TexturedMesh& textured,
                const ExportDirections& directions, const std::optional<GeodeticPosition>& origin,
                const TextureEncoding& encoding, const TilesetOptions& options,
                const RunContext& context)
      : folder_(folder),
        textured_(textured),
        encoding_(encoding),
        options_(options),
        context_(context) {
    if (encoding_.format == TextureFormat::kKeep) encoding_.format = TextureFormat::kJpeg;
    if (textured.has_texture()) {
      pages_ = std::make_unique<TexturePages>(textured, context.memory_budget_bytes / 4);
    }
    PlaceOnEarth(directions, origin);
    const std::vector<double> texels = TexelsOfFaces(textured);
    nodes_ = BuildSurfaceOctree(textured.mesh, texels, static_cast<size_t>(options.max_tile_faces),
                                1e6 * options.max_tile_megatexels);
    node_of_vertex_ = NodesOfVertices(textured.mesh, nodes_);
    normals_ = ComputeVertexNormals(textured.mesh);
  }

  TilesetSummary Write() {
    std::error_code ignored;
    fs::remove(folder_ / "tileset.json", ignored);
    RemoveTiles();
    const Tile root = WriteTile(0);
    Json tileset;
    tileset["asset"] = {{"version", "1.1"}};
    // The error of showing nothing.
    tileset["geometricError"] =
        std::max(2 * root.json["geometricError"].get<double>(), root.box.diagonal().norm());
    tileset["root"] = root.json;
    tileset["root"]["transform"] = Numbers(transform_.data(), 16);
    WriteFileAtomically(folder_ / "tileset.json", tileset.dump(1) + "\n");
    summary_.num_tiles = nodes_.size();
    for (const SurfaceOctreeNode& node : nodes_) {
      summary_.num_levels = std::max(summary_.num_levels, node.depth + 1);
    }
    return summary_;
  }

 private:
  struct Tile {
    TileMesh mesh;  // without skirts
    Json json;
    Eigen::AlignedBox3d box;  // in the tileset's frame, with all children
  };

  void PlaceOnEarth(const ExportDirections& directions,
                    const std::optional<GeodeticPosition>& origin) {
    if (!origin) rotation_ = ZUpFromWorld(directions);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : textured_.mesh.vertices) {
      box.extend(Eigen::Vector3d(rotation_ * x));
    }
    center_ = box.center();
    transform_.setIdentity();
    transform_.block<3, 1>(0, 3) = center_;
    if (origin) transform_ = EcefFromEnu(*origin) * transform_;
  }

  // Those of an earlier export; nothing else.
  void RemoveTiles() const {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_ / "tiles", ignored)) {
      const fs::path& path = entry.path();
      if (path.extension() == ".glb" && path.filename().string().starts_with("r")) {
        fs::remove(path, ignored);
      }
    }
  }

  // From the world to the tileset's frame, of which transform_ leads on.
  Eigen::Vector3d ToTileset(const Eigen::Vector3d& x) const { return rotation_ * x - center_; }

  // Nodes come before all nodes below them, and those before all others.
  int EndOfBranch(int node) const {
    const int depth = nodes_[static_cast<size_t>(node)].depth;
    int end = node + 1;
    while (end < static_cast<int>(nodes_.size()) &&
           nodes_[static_cast<size_t>(end)].depth > depth) {
      ++end;
    }
    return end;
  }

  // Vertices that faces outside of the node use too.
  std::vector<uint8_t> LockedAt(int node) const {
    const int end = EndOfBranch(node);
    std::vector<uint8_t> locked(node_of_vertex_.size());
    for (size_t v = 0; v < locked.size(); ++v) {
      locked[v] =
          node_of_vertex_[v] >= 0 && (node_of_vertex_[v] < node || node_of_vertex_[v] >= end);
    }
    return locked;
  }

  // Writes the node's tile after those below it.
  Tile WriteTile(int n) {
    context_.ThrowIfCancelled();
    const SurfaceOctreeNode& node = nodes_[static_cast<size_t>(n)];
    Tile tile;
    Json children = Json::array();
    double geometric_error = 0;
    const std::vector<uint8_t> locked = LockedAt(n);
    if (node.children.empty()) {
      tile.mesh = MakeFinestTile(textured_, pages_.get(), node.faces);
    } else {
      std::vector<TileMesh> finer;
      for (const int child : node.children) {
        Tile written = WriteTile(child);
        finer.push_back(std::move(written.mesh));
        tile.box.extend(Grown(written.box, kNestingMargin));
        geometric_error = std::max(geometric_error,
                                   kLeastErrorRatio * written.json["geometricError"].get<double>());
        children.push_back(std::move(written.json));
      }
      tile.mesh = Coarser(finer, locked);
      geometric_error = std::max(
          {geometric_error, tile.mesh.error, options_.texels_of_error * tile.mesh.texel_size});
    }
    WriteContent(node.name, locked, &tile);
    tile.json = {{"boundingVolume", BoxVolume(tile.box)},
                 {"geometricError", geometric_error},
                 {"refine", "REPLACE"},
                 {"content", {{"uri", "tiles/" + node.name + ".glb"}}}};
    if (!children.empty()) tile.json["children"] = std::move(children);
    context_.Report(static_cast<double>(++num_written_) / static_cast<double>(nodes_.size()));
    return tile;
  }

  TileMesh Coarser(const std::vector<TileMesh>& finer, const std::vector<uint8_t>& locked) const {
    std::vector<const TileMesh*> pointers;
    for (const TileMesh& mesh : finer) pointers.push_back(&mesh);
    RunContext quiet = context_;
    quiet.set_progress(nullptr);
    return MakeCoarserTile(
        pointers, locked,
        {static_cast<size_t>(options_.max_tile_faces), 1e6 * options_.max_tile_megatexels}, quiet);
  }

  void WriteContent(const std::string& name, const std::vector<uint8_t>& locked, Tile* tile) const {
    TileMesh shown;  // with skirts; the page is not copied
    shown.mesh = tile->mesh.mesh;
    shown.vertex_ids = tile->mesh.vertex_ids;
    shown.texcoords = tile->mesh.texcoords;
    shown.page = std::move(tile->mesh.page);
    const double width = (shown.has_texture() ? kSkirtTexels : kSkirtEdges) * tile->mesh.texel_size;
    AddSkirts(locked, normals_, width, &shown);

    Eigen::AlignedBox3d box;
    for (Eigen::Vector3d& x : shown.mesh.vertices) {
      x = ToTileset(x);
      box.extend(x);
    }
    tile->box.extend(Grown(box, kBoxMargin));
    WriteGlb(folder_ / "tiles" / (name + ".glb"), MakeModel(shown, box.center()));
    tile->mesh.page = std::move(shown.page);
  }

  GlbModel MakeModel(const TileMesh& tile, const Eigen::Vector3d& center) const {
    TexturedMesh flat;  // for SplitByPage
    flat.mesh.vertices = tile.mesh.vertices;
    flat.mesh.faces = tile.mesh.faces;
    if (tile.has_texture()) {
      flat.pages = {"page"};
      flat.page_width = tile.page.width;
      flat.page_height = tile.page.height;
      flat.texcoords = tile.texcoords;
      flat.page_idx.assign(tile.mesh.faces.size(), 0);
    }
    GlbModel model;
    // z up to y up; viewers turn it back.
    Eigen::Matrix3d y_up;
    y_up << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    model.rotation = Eigen::Quaterniond(y_up);
    model.translation = y_up * center;
    for (PagePart& split : SplitByPage(flat)) {
      GlbPart part;
      for (const int v : split.vertices) {
        part.positions.push_back((tile.mesh.vertices[v] - center).cast<float>());
        if (!tile.mesh.vertex_colors.empty()) part.colors.push_back(tile.mesh.vertex_colors[v]);
      }
      part.uv = std::move(split.uv);
      part.faces = std::move(split.faces);
      part.image = split.page;
      model.parts.push_back(std::move(part));
    }
    if (tile.has_texture()) model.images = {EncodeImage(tile.page, encoding_)};
    return model;
  }

  const fs::path folder_;
  const TexturedMesh& textured_;
  TextureEncoding encoding_;
  const TilesetOptions& options_;
  const RunContext& context_;
  std::unique_ptr<TexturePages> pages_;
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  Eigen::Matrix4d transform_;  // of the root; column by column, as 3D Tiles wants it
  std::vector<SurfaceOctreeNode> nodes_;
  std::vector<int> node_of_vertex_;
  std::vector<Eigen::Vector3f> normals_;
  size_t num_written_ = 0;
  TilesetSummary summary_;
};

}  // namespace

void TilesetOptions::Describe(OptionSet* options) {
  options->Add("Tileset.max_tile_faces", &max_tile_faces,
               "Largest number of faces of a tile; more make fewer, larger files", {64, 1 << 20});
  options->Add("Tileset.max_tile_megatexels", &max_tile_megatexels,
               "Largest size of a tile's texture in millions of texels", {0.01, 64.0});
  options->Add("Tileset.texels_of_error", &texels_of_error,
               "A tile's geometric error is at least this many of its texels; more loads finer "
               "tiles earlier",
               {0.0, 1000.0});
}

TilesetSummary ExportTileset(const fs::path& folder, const TexturedMesh& textured,
                             const ExportDirections& directions,
                             const std::optional<GeodeticPosition>& origin,
                             const TextureEncoding& encoding, const TilesetOptions& options,
                             const RunContext& context) {
  std::string error;
  if (!options.Check(&error)) throw UsageError(error);
  return TilesetWriter(folder, textured, directions, origin, encoding, options, context).Write();
}

}  // namespace lsmvs
