#include "lsmvs/merging/tetrahedra/tetrahedral_patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "lsmvs/geometry/hilbert_order.h"
#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/merging/overlap/overlap.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/surface/visibility_weights.h"

namespace lsmvs {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr size_t kCellsPerBlock = 1 << 10;
// Of a facet of one square edge length: for its area, and for each edge length that it lies away
// from the meshes. A face of a mesh costs a share of that.
constexpr double kCapacity = 1000, kDistanceCost = 2, kMaxDistance = 6, kFaceShare = 0.1;
// How much the side counts on which a cell lies, for one square edge length of its cross section,
// and at what distance [edge lengths] from the surface wholly.
constexpr double kSideWeight = 4, kSideRamp = 0.25;
// Edge lengths between the patch and the end of the parts.
constexpr double kMargin = 2;
// Facets that are longer, or bridge a gap between the meshes' ends that is wider.
constexpr double kMaxEdge = 5, kMaxWeb = 0.3;
constexpr size_t kMinPieceFaces = 40;
// Of what views saw; the defaults of visibility_mesher.h.
constexpr double kVisibilitySigma = 3.0, kSigmaFactor = 0.8, kSinkFactor = 0.5;
// Edge lengths within which a vertex is a vertex in conflict.
constexpr double kSameConflict = 0.1;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

struct FaceKey {
  std::array<int32_t, 3> v;
  explicit FaceKey(std::array<int32_t, 3> corners) : v(corners) { std::sort(v.begin(), v.end()); }
  bool operator==(const FaceKey&) const = default;
};
struct FaceKeyHash {
  size_t operator()(const FaceKey& key) const {
    uint64_t hash = 0;
    for (const int32_t x : key.v) hash = (hash ^ static_cast<uint64_t>(x)) * 0x9E3779B97F4A7C15ull;
    return hash ^ hash >> 32;
  }
};

class PatchMaker {
 public:
  PatchMaker(const SourcedMesh& first, const SourcedMesh& second, const PatchFaces& faces,
             const TetrahedralPatchOptions& options, const RunContext& context)
      : options_(options), context_(context), conflicts_(options.conflicts) {
    bands_[0] = ExtractBand(first, faces[0]);
    bands_[1] = ExtractBand(second, faces[1]);
  }

  SourcedMesh Run() {
    for (int side = 0; side < 2; ++side) {
      if (bands_[side].mesh.faces.empty()) return {};
      surfaces_[side] = std::make_unique<BandSurface>(bands_[side]);
      FindMargin(side);
    }
    CollectPoints();
    complex_ = BuildDelaunay(points_, context_);
    if (complex_.cells.empty()) return {};
    CollectFaces();
    Weigh();
    MaximizeFlow(&complex_.cells, context_);
    return Extract();
  }

 private:
  // Finds the nearest conflict.
  struct ConflictIndex {
    explicit ConflictIndex(std::span<const ConflictPoint> conflicts)
        : positions(Positions(conflicts)),
          points(PointFaces(conflicts.size())),
          index(positions, points) {}
    static std::vector<Eigen::Vector3d> Positions(std::span<const ConflictPoint> conflicts) {
      std::vector<Eigen::Vector3d> positions;
      for (const ConflictPoint& conflict : conflicts) positions.push_back(conflict.position);
      return positions;
    }
    std::vector<Eigen::Vector3d> positions;
    std::vector<Eigen::Vector3i> points;
    SurfaceIndex index;
  };

  struct Place {
    int side;
    int32_t vertex;
  };

  // Vertices near the end of the part.
  void FindMargin(int side) {
    const MeshBand& band = bands_[side];
    std::vector<double> start(band.is_fixed.size(), kInfinity);
    double longest = 0;
    for (size_t v = 0; v < start.size(); ++v) {
      if (band.is_fixed[v]) start[v] = 0;
      longest = std::max(longest, surfaces_[side]->frames.edge_length[v]);
    }
    const std::vector<double> distance = DistanceAlongEdges(band.mesh, surfaces_[side]->topology,
                                                            std::move(start), kMargin * longest);
    in_margin_[side].resize(distance.size());
    for (size_t v = 0; v < distance.size(); ++v) {
      in_margin_[side][v] = distance[v] < kMargin * surfaces_[side]->frames.edge_length[v];
    }
  }

  void CollectPoints() {
    std::vector<Place> places;
    std::vector<Eigen::Vector3f> points;
    origin_ = bands_[0].mesh.vertices[0].cast<float>().cast<double>();
    for (int side = 0; side < 2; ++side) {
      for (size_t v = 0; v < bands_[side].mesh.vertices.size(); ++v) {
        places.push_back({side, static_cast<int32_t>(v)});
        points.push_back((bands_[side].mesh.vertices[v] - origin_).cast<float>());
      }
    }
    // Along a Hilbert curve.
    const std::vector<uint32_t> order = HilbertOrder(points);
    for (const uint32_t i : order) {
      places_.push_back(places[i]);
      points_.push_back(points[i]);
    }
  }

  // The meshes' faces by points of the complex.
  void CollectFaces() {
    std::array<std::vector<int32_t>, 2> point_of;
    for (int side = 0; side < 2; ++side) point_of[side].resize(bands_[side].mesh.vertices.size());
    std::vector<int32_t> same(points_.size());
    std::iota(same.begin(), same.end(), 0);
    for (const auto& [duplicate, original] : complex_.duplicates) same[Index(duplicate)] = original;
    for (size_t i = 0; i < places_.size(); ++i) {
      point_of[places_[i].side][Index(places_[i].vertex)] = same[i];
    }
    for (int side = 0; side < 2; ++side) {
      for (const Eigen::Vector3i& face : bands_[side].mesh.faces) {
        faces_.insert(FaceKey({point_of[side][Index(face[0])], point_of[side][Index(face[1])],
                               point_of[side][Index(face[2])]}));
      }
    }
  }

  const Eigen::Vector3d& At(int32_t point) const {
    const Place& place = places_[Index(point)];
    return bands_[place.side].mesh.vertices[Index(place.vertex)];
  }
  double EdgeAt(int32_t point) const {
    const Place& place = places_[Index(point)];
    return surfaces_[place.side]->frames.edge_length[Index(place.vertex)];
  }

  // Where x lies to a surface.
  struct Sight {
    bool is_known = false, is_beside = false;
    double edge = 1, distance = 0;
    double side = 0;  // from -1, inside, to 1, outside
  };

  Sight SightOf(const BandSurface& surface, const Eigen::Vector3d& x) const {
    const SurfaceIndex::Hit hit = surface.index.Closest(x, kInfinity);
    Sight sight;
    if (hit.face < 0) return sight;
    const double edge = surface.EdgeLengthAt(hit.face);
    const double height = (x - hit.point).dot(surface.NormalAt(hit.face));
    sight = {true, surface.IsAtBorder(hit.face, hit.point), edge, hit.distance,
             std::clamp(height / (kSideRamp * edge), -1.0, 1.0)};
    return sight;
  }

  // Side of the surfaces on which x lies: from -1, inside, to 1, outside; 0 where it is not known.
  double SideOf(const Eigen::Vector3d& x) const {
    const std::array<Sight, 2> sights = {SightOf(*surfaces_[0], x), SightOf(*surfaces_[1], x)};
    if (AreInConflict(sights)) return sights[FirstWinsAt(x) ? 0 : 1].side;
    double sum = 0, weights = 0;
    for (const Sight& sight : sights) {
      if (!sight.is_known) continue;
      // Beyond its end a surface says little; the finer one says more.
      const double weight = (sight.is_beside ? 1e-3 : 1.0) / (sight.edge * sight.edge);
      sum += weight * sight.side;
      weights += weight;
    }
    return weights > 0 ? sum / weights : 0;
  }

  bool FirstWinsAt(const Eigen::Vector3d& x) const {
    const SurfaceIndex::Hit hit = conflicts_.index.Closest(x, kInfinity);
    return hit.face < 0 || options_.conflicts[Index(hit.face)].first_wins;
  }

  // Between two surfaces that are too far apart to be the same.
  bool AreInConflict(const std::array<Sight, 2>& sights) const {
    const auto& [a, b] = sights;
    if (!a.is_known || !b.is_known || a.is_beside || b.is_beside) return false;
    return a.side * b.side < 0 &&
           a.distance + b.distance > options_.max_edges * std::max(a.edge, b.edge);
  }

  double DistanceToSurfaces(const Eigen::Vector3d& x, double edge) const {
    double least = kMaxDistance * edge;
    for (const auto& surface : surfaces_)
      least = std::min(least, surface->index.Closest(x, least).distance);
    return least / edge;
  }

  void Weigh() {
    const bool has_sights = WeighSights();
    ParallelFor(context_, complex_.cells.size(), kCellsPerBlock, [&](size_t c) {
      Cell& cell = complex_.cells[c];
      if (!has_sights) cell.excess = 0;
      cell.excess =
          std::clamp(cell.excess + SideCapacity(c), -CutNode::kMaxCapacity, CutNode::kMaxCapacity);
      for (int i = 0; i < 4; ++i) {
        int32_t& capacity = cell.capacity[Index(i)];
        if (!has_sights) capacity = 0;
        capacity = std::min(capacity + FacetCapacity(cell, i), CutNode::kMaxCapacity);
      }
    });
  }

  // Weighs the cells by what the views saw. False, and nothing is changed, without views.
  bool WeighSights() {
    if (options_.views.empty() || !options_.visit_views) return false;
    MergedCloud cloud;
    cloud.frame.origin = origin_;
    cloud.positions = points_;
    std::vector<std::vector<uint32_t>> views = ViewsOfPoints();
    cloud.sight_begin = {0};
    for (std::vector<uint32_t>& list : views) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      const auto support = static_cast<float>(ViewConfidence(list.size(), kVisibilitySigma));
      for (const uint32_t view : list) cloud.sights.push_back({view, support});
      cloud.sight_begin.push_back(cloud.sights.size());
    }
    if (cloud.sights.empty()) return false;
    Scene scene;
    scene.views.assign(options_.views.begin(), options_.views.end());
    WeighCells(scene, cloud, {kSigmaFactor, kSinkFactor, 0}, context_, &complex_);
    return true;
  }

  // Equal points share theirs. Those that lose a conflict are believed to have been seen wrongly,
  // or at another time.
  std::vector<std::vector<uint32_t>> ViewsOfPoints() const {
    std::vector<std::vector<uint32_t>> views(points_.size());
    std::vector<int32_t> original(points_.size());
    std::iota(original.begin(), original.end(), 0);
    for (const auto& [duplicate, first] : complex_.duplicates) original[Index(duplicate)] = first;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Place& place = places_[i];
      if (LosesConflict(place)) continue;
      options_.visit_views(bands_[place.side].sources[Index(place.vertex)], [&](uint32_t view) {
        if (view < options_.views.size()) views[Index(original[i])].push_back(view);
      });
    }
    return views;
  }

  bool LosesConflict(const Place& place) const {
    const MeshBand& band = bands_[place.side];
    const double edge =
        surfaces_[place.side]->frames.edge_length[Index(place.vertex)] * kSameConflict;
    const SurfaceIndex::Hit hit =
        conflicts_.index.Closest(band.mesh.vertices[Index(place.vertex)], edge);
    if (hit.face < 0) return false;
    const ConflictPoint& conflict = options_.conflicts[Index(hit.face)];
    return conflict.of_first == (place.side == 0) && conflict.IsLost();
  }

  // Source is outside.
  int32_t SideCapacity(size_t c) const {
    const Cell& cell = complex_.cells[c];
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    double edge = 0, section;
    if (complex_.IsInfinite(static_cast<int32_t>(c))) {
      const int k = cell.IndexOfVertex(Cell::kInfiniteVertex);
      const auto [x, y, z] = FacetCorners(cell, k);
      const Eigen::Vector3d normal = (y - x).cross(z - x);
      // The facet is counter-clockwise seen from within the cell.
      middle = (x + y + z) / 3 + std::sqrt(normal.norm()) * normal.normalized();
      section = 0.5 * normal.norm();
      for (const int j : kFacetVertices[Index(k)]) edge += EdgeAt(cell.vertex[Index(j)]) / 3;
    } else {
      for (const int32_t v : cell.vertex) {
        middle += At(v) / 4;
        edge += EdgeAt(v) / 4;
      }
      const double volume = std::abs((At(cell.vertex[1]) - At(cell.vertex[0]))
                                         .cross(At(cell.vertex[2]) - At(cell.vertex[0]))
                                         .dot(At(cell.vertex[3]) - At(cell.vertex[0]))) /
                            6;
      section = std::cbrt(volume * volume);
    }
    const double weight = kSideWeight * std::min(section / (edge * edge), 100.0);
    return static_cast<int32_t>(std::lround(kCapacity * weight * SideOf(middle)));
  }

  std::array<Eigen::Vector3d, 3> FacetCorners(const Cell& cell, int i) const {
    const auto& k = kFacetVertices[Index(i)];
    return {At(cell.vertex[Index(k[0])]), At(cell.vertex[Index(k[1])]),
            At(cell.vertex[Index(k[2])])};
  }

  int32_t FacetCapacity(const Cell& cell, int i) const {
    std::array<int32_t, 3> v;
    double edge = 0;
    for (size_t k = 0; k < 3; ++k) {
      v[k] = cell.vertex[Index(kFacetVertices[Index(i)][k])];
      if (v[k] == Cell::kInfiniteVertex) return 0;
      edge += EdgeAt(v[k]) / 3;
    }
    // The same from both sides: corners in a fixed order.
    const FaceKey key(v);
    const Eigen::Vector3d &x = At(key.v[0]), &y = At(key.v[1]), &z = At(key.v[2]);
    const double area = 0.5 * (y - x).cross(z - x).norm() / (edge * edge);
    double cost =
        std::min(area, 100.0) * (1 + kDistanceCost * DistanceToSurfaces((x + y + z) / 3, edge));
    if (faces_.contains(key)) cost *= kFaceShare;
    return 1 + static_cast<int32_t>(std::lround(kCapacity * cost));
  }

  SourcedMesh Extract() {
    ExtractedSurface surface = ExtractSurface(std::move(complex_));
    SourcedMesh patch;
    patch.mesh.faces = std::move(surface.mesh.faces);
    for (size_t v = 0; v < surface.vertex_point.size(); ++v) {
      const int32_t point = surface.vertex_point[v];
      const Eigen::Vector3d x = surface.mesh.vertices[v] + origin_;
      AddVertex(point, x, &patch);
    }
    FilterFaces(&patch.mesh, [&](size_t f) { return IsWanted(patch.mesh, f); });
    DropSmallPieces(&patch.mesh);
    return Compact(std::move(patch));
  }

  // Middles of split edges, which are no points, take after the nearest vertex of a mesh.
  void AddVertex(int32_t point, const Eigen::Vector3d& x, SourcedMesh* patch) {
    if (point < 0) {
      const SurfaceIndex::Hit hit = surfaces_[0]->index.Closest(x, kInfinity);
      const int32_t v = bands_[0].mesh.faces[Index(hit.face)][0];
      patch->mesh.vertices.push_back(x);
      patch->sources.push_back(bands_[0].sources[Index(v)]);
      patch->is_changed.push_back(1);
      vertex_place_.push_back({0, v});
      return;
    }
    const Place& place = places_[Index(point)];
    patch->mesh.vertices.push_back(At(point));
    patch->sources.push_back(bands_[place.side].sources[Index(place.vertex)]);
    patch->is_changed.push_back(bands_[place.side].is_changed[Index(place.vertex)]);
    vertex_place_.push_back(place);
  }

  bool IsWanted(const TriangleMesh& mesh, size_t f) const {
    const Eigen::Vector3i& face = mesh.faces[f];
    double edge = 0;
    for (const int v : face) {
      const Place& place = vertex_place_[Index(v)];
      if (in_margin_[place.side][Index(place.vertex)]) return false;
      edge = std::max(edge, surfaces_[place.side]->frames.edge_length[Index(place.vertex)]);
    }
    for (int k = 0; k < 3; ++k) {
      const double length =
          (mesh.vertices[Index(face[k])] - mesh.vertices[Index(face[(k + 1) % 3])]).norm();
      if (length > kMaxEdge * edge) return false;
    }
    return !IsWeb(mesh, face, edge);
  }

  // Beyond the ends of both meshes.
  bool IsWeb(const TriangleMesh& mesh, const Eigen::Vector3i& face, double edge) const {
    const Eigen::Vector3d middle = (mesh.vertices[Index(face[0])] + mesh.vertices[Index(face[1])] +
                                    mesh.vertices[Index(face[2])]) /
                                   3;
    for (const auto& surface : surfaces_) {
      const SurfaceIndex::Hit hit = surface->index.Closest(middle, options_.max_edges * edge);
      if (hit.face < 0) continue;
      if (!surface->IsAtBorder(hit.face, hit.point) || hit.distance < kMaxWeb * edge) return false;
    }
    return true;
  }

  static void DropSmallPieces(TriangleMesh* mesh) {
    const MeshComponents pieces = FindComponents(*mesh);
    FilterFaces(mesh, [&](size_t f) {
      return pieces.num_faces[Index(pieces.of_face[f])] >= kMinPieceFaces;
    });
  }

  static SourcedMesh Compact(SourcedMesh patch) {
    for (const int source : SplitNonManifoldVertices(&patch.mesh)) {
      patch.sources.push_back(VertexSource(patch.sources[Index(source)]));
      patch.is_changed.push_back(1);
    }
    const std::vector<int> new_index = RemoveUnusedVertices(&patch.mesh);
    SourcedMesh result;
    result.mesh = std::move(patch.mesh);
    for (size_t v = 0; v < new_index.size(); ++v) {
      if (new_index[v] < 0) continue;
      result.sources.push_back(patch.sources[v]);
      result.is_changed.push_back(patch.is_changed[v]);
    }
    return result;
  }

  const TetrahedralPatchOptions& options_;
  const RunContext& context_;
  ConflictIndex conflicts_;
  std::array<MeshBand, 2> bands_;
  std::array<std::unique_ptr<BandSurface>, 2> surfaces_;
  std::array<std::vector<uint8_t>, 2> in_margin_;  // #V
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<Place> places_;  // of the points
  std::vector<Eigen::Vector3f> points_;
  Tetrahedralization complex_;
  std::unordered_set<FaceKey, FaceKeyHash> faces_;
  std::vector<Place> vertex_place_;  // of the extracted surface
};

}  // namespace

SourcedMesh MakeTetrahedralPatch(const SourcedMesh& first, const SourcedMesh& second,
                                 const PatchFaces& faces, const TetrahedralPatchOptions& options,
                                 const RunContext& context) {
  return PatchMaker(first, second, faces, options, context).Run();
}

}  // namespace lsmvs
