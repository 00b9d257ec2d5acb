#include "lsmvs/exporting/tiles/skirts.h"

#include <Eigen/Geometry>
#include <map>

#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr double kOutwardShare = 0.5;

// Sides of the tile with one face whose ends are both locked.
std::vector<HalfEdge> OpenSides(const std::vector<uint8_t>& is_locked, const TileMesh& tile) {
  std::vector<HalfEdge> open;
  const auto locked = [&](int v) {
    const int id = tile.vertex_ids[static_cast<size_t>(v)];
    return id >= 0 && is_locked[static_cast<size_t>(id)];
  };
  const std::vector<HalfEdge> sides = SortedHalfEdges(tile.mesh.faces, tile.mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    if (end - begin == 1 && locked(begin->low) && locked(begin->high)) open.push_back(*begin);
  });
  return open;
}

}  // namespace

void AddSkirts(const std::vector<uint8_t>& is_locked, const std::vector<Eigen::Vector3f>& normals,
               double width, TileMesh* tile) {
  TriangleMesh& mesh = tile->mesh;
  const std::vector<HalfEdge> sides = OpenSides(is_locked, *tile);
  const auto normal_of = [&](int v) -> Eigen::Vector3d {
    return normals[static_cast<size_t>(tile->vertex_ids[static_cast<size_t>(v)])].cast<double>();
  };
  std::map<int, Eigen::Vector3d> outward;  // of each border vertex, away from the tile
  for (const HalfEdge& side : sides) {
    const Eigen::Vector3i& f = mesh.faces[side.face];
    const int a = f[side.corner], b = f[(side.corner + 1) % 3];
    const Eigen::Vector3d direction = mesh.vertices[b] - mesh.vertices[a];
    for (const int v : {a, b}) {
      outward.try_emplace(v, Eigen::Vector3d::Zero()).first->second +=
          direction.cross(normal_of(v)).stableNormalized();
    }
  }
  std::map<int, int> lower;
  for (const auto& [v, direction] : outward) {
    lower[v] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.emplace_back(
        mesh.vertices[v] + width * (kOutwardShare * direction.stableNormalized() - normal_of(v)));
    if (!mesh.vertex_colors.empty()) mesh.vertex_colors.push_back(mesh.vertex_colors[v]);
    tile->vertex_ids.push_back(-1);
  }
  for (const HalfEdge& side : sides) {
    const size_t face = static_cast<size_t>(side.face), corner = static_cast<size_t>(side.corner);
    const int a = mesh.faces[face][side.corner], b = mesh.faces[face][(side.corner + 1) % 3];
    mesh.faces.emplace_back(b, a, lower[a]);
    mesh.faces.emplace_back(b, lower[a], lower[b]);
    if (!tile->has_texture()) continue;
    const Eigen::Vector2f at_a = tile->texcoords[face][corner],
                          at_b = tile->texcoords[face][(corner + 1) % 3];
    tile->texcoords.push_back({at_b, at_a, at_a});
    tile->texcoords.push_back({at_b, at_a, at_b});
  }
}

}  // namespace lsmvs
