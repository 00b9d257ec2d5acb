#include "lsmvs/exporting/tiles/coarser_tile.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/exporting/tiles/same_side.h"
#include "lsmvs/exporting/tiles/surface_baking.h"
#include "lsmvs/geometry/distances.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/mesh/texture_pages.h"

namespace lsmvs {

namespace {

constexpr size_t kReduction = 4;  // of faces and of texels
constexpr double kReachTexels = 64;
constexpr int kNumMipLevels = 4;

// The finer tiles as one mesh; vertices that they share are one.
struct Union {
  TriangleMesh mesh;
  std::vector<int> vertex_ids;
  std::vector<int> first_face;  // of each tile, and the number of faces at the end
};

Union Join(const std::vector<const TileMesh*>& tiles) {
  Union joined;
  std::unordered_map<int, int> vertex_of_id;
  for (const TileMesh* tile : tiles) {
    std::vector<int> new_index;
    for (size_t v = 0; v < tile->mesh.vertices.size(); ++v) {
      const int id = tile->vertex_ids[v], next = static_cast<int>(joined.vertex_ids.size());
      const int index = id < 0 ? next : vertex_of_id.try_emplace(id, next).first->second;
      new_index.push_back(index);
      if (index != next) continue;
      joined.vertex_ids.push_back(id);
      joined.mesh.vertices.push_back(tile->mesh.vertices[v]);
      if (tile->mesh.vertex_colors.empty()) continue;
      joined.mesh.vertex_colors.push_back(tile->mesh.vertex_colors[v]);
    }
    joined.first_face.push_back(static_cast<int>(joined.mesh.faces.size()));
    for (const Eigen::Vector3i& f : tile->mesh.faces) {
      joined.mesh.faces.emplace_back(new_index[f[0]], new_index[f[1]], new_index[f[2]]);
    }
  }
  joined.first_face.push_back(static_cast<int>(joined.mesh.faces.size()));
  return joined;
}

Triangle3 TriangleOf(const TriangleMesh& mesh, int face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  return {mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
}

// The colours of the finer tiles at points near them.
class FinerTexture {
 public:
  FinerTexture(const std::vector<const TileMesh*>& tiles, const Union& joined,
               const MeshTracer& tracer, double texel_size)
      : tiles_(tiles), joined_(joined), tracer_(tracer), reach_(kReachTexels * texel_size) {
    for (const TileMesh* tile : tiles) {
      std::vector<ColorImage> mips;  // from half size on
      for (int level = 1; level < kNumMipLevels; ++level) {
        const ColorImage& finer = level == 1 ? tile->page : mips.back();
        mips.push_back(ResizeColors(finer, finer.width / 2, finer.height / 2));
      }
      mips_.push_back(std::move(mips));
    }
    for (size_t t = 0; t < tiles.size(); ++t) {
      for (size_t f = 0; f < tiles[t]->mesh.faces.size(); ++f) {
        place_.push_back(
            {static_cast<int>(t), static_cast<int>(f), MipLevel(*tiles[t], f, texel_size)});
      }
    }
  }

  Eigen::Vector3f At(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
    const std::optional<ClosestPoint> nearest =
        ClosestOnSameSide(tracer_, joined_.mesh, x, normal, reach_);
    if (!nearest) return Eigen::Vector3f::Zero();
    const Place& place = place_[static_cast<size_t>(nearest->face)];
    const TileMesh& tile = *tiles_[static_cast<size_t>(place.tile)];
    const Eigen::Vector3d weights =
        BarycentricCoordinates(nearest->x_in_world, TriangleOf(joined_.mesh, nearest->face));
    const auto& corners = tile.texcoords[static_cast<size_t>(place.face)];
    Eigen::Vector2f x_px = Eigen::Vector2f::Zero();
    for (int c = 0; c < 3; ++c) {
      x_px += static_cast<float>(weights[c]) * corners[static_cast<size_t>(c)];
    }
    if (place.mip == 0) return SampleColor(tile.page, x_px);
    return SampleColor(mips_[static_cast<size_t>(place.tile)][static_cast<size_t>(place.mip - 1)],
                       x_px / static_cast<float>(1 << place.mip));
  }

 private:
  struct Place {
    int tile, face, mip;
  };

  // The level whose texels are about as wide as the coarser tile's.
  static int MipLevel(const TileMesh& tile, size_t face, double texel_size) {
    const double texels = TriangleArea(tile.texcoords[face]);
    const double area = 0.5 * FaceNormalTimesTwiceArea(tile.mesh, face).norm();
    if (!(texels > 0) || !(area > 0)) return 0;
    const double level = std::log2(texel_size / std::sqrt(area / texels));
    return static_cast<int>(std::clamp(std::floor(level + 0.5), 0.0, kNumMipLevels - 1.0));
  }

  const std::vector<const TileMesh*>& tiles_;
  const Union& joined_;
  const MeshTracer& tracer_;
  const double reach_;
  std::vector<std::vector<ColorImage>> mips_;
  std::vector<Place> place_;
};

double CoarserTexelSize(const std::vector<const TileMesh*>& finer, const TriangleMesh& mesh,
                        double max_texels) {
  double area = 0, texels = 0;
  for (const TileMesh* tile : finer) {
    double own_area = 0;
    for (size_t f = 0; f < tile->mesh.faces.size(); ++f) {
      own_area += 0.5 * FaceNormalTimesTwiceArea(tile->mesh, f).norm();
    }
    area += own_area;
    if (tile->texel_size > 0) texels += own_area / (tile->texel_size * tile->texel_size);
  }
  if (texels == 0) return std::max(TexelSizeFor(mesh, max_texels), 1e-30);
  const double finer_size = std::sqrt(area / texels), twice = std::sqrt(kReduction) * finer_size;
  // Small tiles are not made smaller still: where one child of several is large, levels are many.
  const double worthwhile = std::max(finer_size, TexelSizeFor(mesh, max_texels / kReduction));
  return std::max({std::min(twice, worthwhile), TexelSizeFor(mesh, max_texels), 1e-30});
}

void MakeTexture(const std::vector<const TileMesh*>& finer, const Union& joined,
                 const MeshTracer& tracer, double max_texels, const RunContext& context,
                 TileMesh* tile) {
  tile->texel_size = CoarserTexelSize(finer, tile->mesh, max_texels);
  const FinerTexture texture(finer, joined, tracer, tile->texel_size);
  BakedSurface baked = BakeSurface(
      tile->mesh, tile->texel_size,
      [&](const Eigen::Vector3d& x, const Eigen::Vector3d& normal) {
        return texture.At(x, normal);
      },
      context);
  tile->texcoords = std::move(baked.texcoords);
  tile->page = std::move(baked.page);
}

double LargestDistance(const MeshTracer& tracer, const std::vector<Eigen::Vector3d>& points,
                       const RunContext& context) {
  std::vector<double> distances(points.size());
  ParallelFor(context, points.size(), 1024, [&](size_t i) {
    const std::optional<ClosestPoint> nearest = tracer.Closest(points[i]);
    distances[i] = nearest ? nearest->distance : 0;
  });
  return points.empty() ? 0 : *std::max_element(distances.begin(), distances.end());
}

double DistanceBetween(const TriangleMesh& coarse, const TriangleMesh& fine,
                       const MeshTracer& fine_tracer, const RunContext& context) {
  std::vector<Eigen::Vector3d> points = coarse.vertices;
  for (const Eigen::Vector3i& f : coarse.faces) {
    points.push_back((coarse.vertices[f[0]] + coarse.vertices[f[1]] + coarse.vertices[f[2]]) / 3);
  }
  const MeshTracer coarse_tracer(coarse, context);
  return std::max(LargestDistance(fine_tracer, points, context),
                  LargestDistance(coarse_tracer, fine.vertices, context));
}

}  // namespace

TileMesh MakeCoarserTile(const std::vector<const TileMesh*>& finer,
                         const std::vector<uint8_t>& is_locked, const CoarserTileOptions& options,
                         const RunContext& context) {
  const Union joined = Join(finer);
  std::vector<uint8_t> locked;
  for (const int id : joined.vertex_ids) {
    locked.push_back(id >= 0 && is_locked[static_cast<size_t>(id)]);
  }
  const size_t target =
      std::clamp(joined.mesh.faces.size() / kReduction,
                 std::max<size_t>(4, options.max_faces / kReduction), options.max_faces);
  SimplifiedMesh simplified = SimplifyMeshPart(joined.mesh, locked, target, context);

  TileMesh tile;
  for (size_t v = 0; v < simplified.source_vertex.size(); ++v) {
    const size_t source = static_cast<size_t>(simplified.source_vertex[v]);
    tile.vertex_ids.push_back(locked[source] ? joined.vertex_ids[source] : -1);
  }
  tile.mesh = std::move(simplified.mesh);
  const MeshTracer tracer(joined.mesh, context);
  const bool has_texture = finer[0]->has_texture();
  if (has_texture) {
    MakeTexture(finer, joined, tracer, options.max_texels, context, &tile);
  } else {
    tile.texel_size = MeanEdgeLength(tile.mesh);
  }
  double finer_error = 0;
  for (const TileMesh* child : finer) finer_error = std::max(finer_error, child->error);
  tile.error = finer_error + DistanceBetween(tile.mesh, joined.mesh, tracer, context);
  return tile;
}

}  // namespace lsmvs
