#include "lsmvs/merging/seam/surface_merging.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "lsmvs/merging/seam/blending.h"
#include "lsmvs/merging/seam/grading.h"
#include "lsmvs/merging/seam/overlap_side.h"
#include "lsmvs/merging/seam/rim_smoothing.h"
#include "lsmvs/merging/seam/seam_labels.h"
#include "lsmvs/merging/zip/refilling.h"
#include "lsmvs/merging/zip/untangling.h"
#include "lsmvs/merging/zip/zipper.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {

namespace {

// Edge lengths around the other mesh that are worked on.
constexpr double kReach = 20;
constexpr double kMinSmoothWidth = 3, kMaxBlendWidth = 18;
// Growth of edges with the distance from the seam.
constexpr double kGrowth = 0.3;
// Ratio of edge lengths from which on large faces are split where the other surface ends.
constexpr double kCoarse = 16;
constexpr double kClearance = 0.6;
constexpr size_t kMinPieceFaces = 40;
constexpr double kMaxRoundingPart = 1e-4;

size_t Index(int32_t i) { return static_cast<size_t>(i); }

class SurfaceMerger {
 public:
  SurfaceMerger(const SourcedMesh& first, const SourcedMesh& second,
                const SurfaceMergingOptions& options, const RunContext& context,
                SurfaceMergingCounters* counters)
      : whole_{&first, &second}, options_(options), context_(context), counters_(*counters) {}

  SourcedMesh Run() {
    CompareMeshes();
    counters_.num_conflict_faces += sides_[0]->num_conflict_faces + sides_[1]->num_conflict_faces;
    counters_.conflicts = Conflicts();
    for (const ConflictPoint& conflict : counters_.conflicts) {
      counters_.trouble.push_back(conflict.position);
    }
    kept_[0] = LabelFirstSurface(*sides_[0], *sides_[1], SeamChoice(), context_);
    context_.Report(0.5);
    Refine();
    kept_[1] = LabelSecondSurface(*sides_[0], *sides_[1], kept_[0], kClearance, context_);
    for (int side = 0; side < 2; ++side) SmoothRim(bands_[side], kMinPieceFaces, &kept_[side]);
    Blend();
    context_.Report(0.8);
    Join();
    context_.Report(0.95);
    return Assemble();
  }

  void CompareMeshes() {
    edge_ = CoarserEdgeLength(*whole_[0], *whole_[1]);
    for (int side = 0; side < 2; ++side) {
      in_band_[side] = FacesNear(whole_[side]->mesh, whole_[1 - side]->mesh, kReach * edge_);
      bands_[side] = ExtractBand(*whole_[side], in_band_[side]);
      mean_edge_[side] = MeanEdgeLength(bands_[side].mesh);
      num_band_faces_ += bands_[side].mesh.faces.size();
    }
    for (int side = 0; side < 2; ++side) RefineAlongOtherBorder(side);
    context_.ThrowIfCancelled();
    if (options_.in_free_space) {
      for (int side = 0; side < 2; ++side) {
        in_free_space_[side] = options_.in_free_space(*whole_[side], *whole_[1 - side]);
      }
    }
    Compare();
  }

  std::vector<ConflictPoint> Conflicts() const {
    std::vector<ConflictPoint> conflicts;
    for (size_t k = 0; k < 2; ++k) {
      const OverlapSide& side = *sides_[k];
      for (size_t v = 0; v < side.states.size(); ++v) {
        if (side.states[v] != VertexState::kConflict) continue;
        conflicts.push_back({side.surface->mesh().vertices[v], k == 0, side.first_wins[v] != 0});
      }
    }
    return conflicts;
  }

 private:
  SeamOptions SeamChoice() const {
    SeamOptions choice;
    choice.inset = options_.inset;
    return choice;
  }

  void Compare() {
    for (int side = 0; side < 2; ++side) {
      sides_[side].reset();
      surfaces_[side] = std::make_unique<BandSurface>(bands_[side]);
    }
    for (int side = 0; side < 2; ++side) {
      sides_[side] = std::make_unique<OverlapSide>(*surfaces_[side], *surfaces_[1 - side],
                                                   options_.max_edges, context_);
    }
    for (int side = 0; side < 2; ++side) {
      sides_[side]->in_free_space = BandFlags(side, in_free_space_[side]);
    }
    for (int side = 0; side < 2; ++side) {
      sides_[side]->Classify(*sides_[1 - side], options_.inset, options_.max_edges, context_);
    }
    DecideConflicts(options_.worth, options_.max_edges, sides_[0].get(), sides_[1].get());
  }

  // Flags of the whole's vertices for those of the band; a vertex that was added takes its
  // neighbours'.
  std::vector<uint8_t> BandFlags(int side, const std::vector<uint8_t>& whole_flags) const {
    std::vector<uint8_t> flags;
    if (whole_flags.empty()) return flags;
    const std::vector<int32_t>& whole_vertex = bands_[side].whole_vertex;
    flags.assign(whole_vertex.size(), 0);
    for (size_t v = 0; v < flags.size(); ++v) {
      if (whole_vertex[v] >= 0) flags[v] = whole_flags[Index(whole_vertex[v])];
    }
    // Later vertices halve edges between earlier ones.
    for (size_t v = 0; v < flags.size(); ++v) {
      if (whole_vertex[v] >= 0) continue;
      surfaces_[side]->topology.ForNeighbors(static_cast<int32_t>(v), [&](int32_t w) {
        if (Index(w) < v) flags[v] |= flags[Index(w)];
      });
    }
    return flags;
  }

  // The vertices of the seam on the first surface, with the edge length of the finer one.
  SeamPoints FindSeam() const {
    const TriangleMesh& mesh = bands_[0].mesh;
    std::vector<uint8_t> on_seam(mesh.vertices.size(), 0);
    ForEdges(SortedHalfEdges(mesh.faces, mesh.vertices.size()),
             [&](const HalfEdge* begin, const HalfEdge* end) {
               if (end - begin != 2) return;
               if (kept_[0][Index(begin[0].face)] == kept_[0][Index(begin[1].face)]) return;
               on_seam[Index(begin->low)] = on_seam[Index(begin->high)] = 1;
             });
    SeamPoints seam;
    for (size_t v = 0; v < on_seam.size(); ++v) {
      if (!on_seam[v]) continue;
      const int32_t face = sides_[0]->matches[v].face;
      const double own = surfaces_[0]->frames.edge_length[v];
      seam.positions.push_back(mesh.vertices[v]);
      seam.edge_lengths.push_back(face < 0 ? own : std::min(own, surfaces_[1]->EdgeLengthAt(face)));
    }
    return seam;
  }

  void Refine() {
    const SeamPoints seam = FindSeam();
    const std::array<size_t, 2> before = {bands_[0].mesh.faces.size(), bands_[1].mesh.faces.size()};
    const MeshBand old_first = bands_[0];
    for (MeshBand& band : bands_) RefineTowardsSeam(seam, kGrowth, &band);
    if (bands_[0].mesh.faces.size() != before[0]) CarryLabels(old_first);
    if (bands_[0].mesh.faces.size() != before[0] || bands_[1].mesh.faces.size() != before[1]) {
      Compare();
    }
  }

  // Faces that are much larger than the other surface's cannot tell where that ends.
  void RefineAlongOtherBorder(int side) {
    const MeshBand& other = bands_[1 - side];
    if (mean_edge_[side] < kCoarse * mean_edge_[1 - side]) return;
    const SurfaceTopology topology(other.mesh, other.cut_edges);
    SeamPoints border;
    for (size_t v = 0; v < other.mesh.vertices.size(); ++v) {
      if (!topology.IsOnBorder(static_cast<int32_t>(v))) continue;
      border.positions.push_back(other.mesh.vertices[v]);
      border.edge_lengths.push_back(0.25 * kCoarse * mean_edge_[1 - side]);
    }
    RefineTowardsSeam(border, kGrowth, &bands_[side]);
  }

  // Parts of a face have its label.
  void CarryLabels(const MeshBand& old) {
    const SurfaceIndex index(old.mesh.vertices, old.mesh.faces);
    std::vector<uint8_t> labels(bands_[0].mesh.faces.size());
    ParallelFor(context_, labels.size(), 1 << 10, [&](size_t f) {
      const Eigen::Vector3i& face = bands_[0].mesh.faces[f];
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const int v : face) middle += bands_[0].mesh.vertices[Index(v)] / 3;
      const SurfaceIndex::Hit hit = index.Closest(middle, edge_);
      labels[f] = hit.face < 0 ? 1 : kept_[0][Index(hit.face)];
    });
    kept_[0] = std::move(labels);
  }

  // Of the way to the other surface; the finer one is the more exact.
  double Share(int side) const {
    const double own = mean_edge_[side] * mean_edge_[side];
    const double other = mean_edge_[1 - side] * mean_edge_[1 - side];
    return own / (own + other);
  }

  void Blend() {
    for (int side = 0; side < 2; ++side) {
      displacements_[side] =
          BlendTowardsMatches(*sides_[side], kept_[side], Share(side), kMinSmoothWidth * edge_,
                              kMaxBlendWidth * edge_, &band_may_move_[side]);
    }
  }

  void AddTrouble(const std::vector<int32_t>& joined_vertices) {
    for (const int32_t v : joined_vertices) {
      counters_.trouble.push_back(joined_.vertices[Index(v)]);
    }
  }

  void Join() {
    const ZipResult zip = Zip();
    counters_.num_new_faces += zip.faces.size();
    counters_.num_open_edges += zip.open_edges.size();
    for (const auto& edge : zip.open_edges) AddTrouble({edge[0]});
    num_old_faces_ = joined_.faces.size();
    joined_.faces.insert(joined_.faces.end(), zip.faces.begin(), zip.faces.end());
    std::vector<int32_t> crossings =
        UntangleFaces(may_move_, num_old_faces_, context_, &has_moved_, &joined_);
    if (!crossings.empty()) crossings = Refill();
    // What the band around the seam does not give way to, its surroundings may.
    if (!crossings.empty()) {
      crossings = UntangleFaces(is_free_, num_old_faces_, context_, &has_moved_, &joined_);
      if (!crossings.empty()) crossings = Refill();
    }
    counters_.num_crossings += crossings.size();
    AddTrouble(crossings);
  }

  // Replaces faces that cross others; returns a vertex of each pair that is left.
  std::vector<int32_t> Refill() {
    std::vector<uint8_t> is_active(joined_.faces.size());
    for (size_t f = 0; f < is_active.size(); ++f) {
      const Eigen::Vector3i& face = joined_.faces[f];
      is_active[f] = f >= num_old_faces_ || std::any_of(face.begin(), face.end(), [&](int v) {
                       return has_moved_[Index(v)] || may_move_[Index(v)];
                     });
    }
    const Refilling refilling = RefillCrossings(joined_, normal_, is_free_, is_active, context_);
    size_t num_kept = 0, num_kept_old = 0;
    for (size_t f = 0; f < is_active.size(); ++f) {
      if (refilling.is_dropped[f]) continue;
      if (f < num_old_faces_) face_side_[num_kept_old++] = face_side_[f];
      is_active[num_kept] = is_active[f];
      joined_.faces[num_kept++] = joined_.faces[f];
    }
    num_old_faces_ = num_kept_old;
    joined_.faces.resize(num_kept);
    joined_.faces.insert(joined_.faces.end(), refilling.faces.begin(), refilling.faces.end());
    is_active.resize(num_kept);
    is_active.resize(joined_.faces.size(), 1);
    counters_.num_new_faces += refilling.faces.size();
    DropUnusedVertices();
    std::vector<int32_t> left;
    const FaceGrid grid(joined_.vertices, joined_.faces);
    for (const auto& [a, b] : grid.CrossingPairs(is_active, context_)) {
      left.push_back(joined_.faces[Index(a)][0]);
    }
    return left;
  }

  // Vertices that have lost all their faces are not part of the result.
  void DropUnusedVertices() {
    std::vector<uint8_t> used(joined_.vertices.size(), 0);
    for (const Eigen::Vector3i& face : joined_.faces) {
      for (const int v : face) used[Index(v)] = 1;
    }
    for (std::vector<int32_t>& place : place_) {
      for (int32_t& j : place) {
        if (j >= 0 && !used[Index(j)]) j = -1;
      }
    }
  }

  ZipResult Zip() {
    Combine();
    ZipProblem problem;
    problem.mesh = &joined_;
    problem.side = side_of_;
    problem.edge_length = edge_length_;
    problem.normal = normal_;
    problem.old_border = old_border_;
    problem.cut_edges = cut_edges_;
    return ZipRims(problem);
  }

  // What is kept of both bands, as one mesh; displaced.
  void Combine() {
    for (int side = 0; side < 2; ++side) {
      const MeshBand& band = bands_[side];
      std::vector<uint8_t> used(band.mesh.vertices.size(), 0);
      for (size_t f = 0; f < kept_[side].size(); ++f) {
        if (!kept_[side][f]) continue;
        for (const int v : band.mesh.faces[f]) used[Index(v)] = 1;
      }
      place_[side].assign(used.size(), -1);
      for (size_t v = 0; v < used.size(); ++v) {
        if (used[v]) AddVertex(side, v);
      }
      for (size_t f = 0; f < kept_[side].size(); ++f) {
        if (!kept_[side][f]) continue;
        Eigen::Vector3i face = band.mesh.faces[f];
        for (int k = 0; k < 3; ++k) {
          const int a = face[k], b = face[(k + 1) % 3];
          if (!surfaces_[side]->topology.IsBorderSide(static_cast<int32_t>(f), k)) continue;
          old_border_.push_back(EdgeKey(place_[side][Index(a)], place_[side][Index(b)]));
        }
        for (int& v : face) v = place_[side][Index(v)];
        joined_.faces.push_back(face);
        face_side_.push_back(static_cast<uint8_t>(side));
      }
      for (const uint64_t key : band.cut_edges) {
        const int32_t a = place_[side][key >> 32], b = place_[side][key & 0xFFFFFFFFu];
        if (a >= 0 && b >= 0) cut_edges_.push_back(EdgeKey(a, b));
      }
    }
    std::sort(old_border_.begin(), old_border_.end());
    std::sort(cut_edges_.begin(), cut_edges_.end());
  }

  void AddVertex(int side, size_t v) {
    const MeshBand& band = bands_[side];
    const Eigen::Vector3d& moved = displacements_[side][v];
    const double edge = surfaces_[side]->frames.edge_length[v];
    place_[side][v] = static_cast<int32_t>(joined_.vertices.size());
    joined_.vertices.push_back(
        moved.isZero(0.0) ? band.mesh.vertices[v]
                          : RoundToFile(band.mesh.vertices[v] + moved, kMaxRoundingPart * edge));
    side_of_.push_back(static_cast<uint8_t>(side));
    edge_length_.push_back(edge);
    normal_.push_back(surfaces_[side]->frames.normal[v]);
    has_moved_.push_back(!moved.isZero(0.0));
    may_move_.push_back(band_may_move_[side][v]);
    is_free_.push_back(!band.is_fixed[v]);
  }

  // Both wholes with what has become of their bands: vertices of the first, then those that it got,
  // then the second's.
  SourcedMesh Assemble() {
    SourcedMesh result;
    std::array<std::vector<int32_t>, 2> whole_place;
    std::vector<int32_t> joined_place(joined_.vertices.size(), -1);
    std::vector<uint8_t> at_new_face(joined_.vertices.size(), 0);
    for (size_t f = num_old_faces_; f < joined_.faces.size(); ++f) {
      for (const int v : joined_.faces[f]) at_new_face[Index(v)] = 1;
    }
    for (int side = 0; side < 2; ++side) {
      const SourcedMesh& whole = *whole_[side];
      const MeshBand& band = bands_[side];
      // Of the whole's vertices: in the joined mesh, kUnused, or kOutside.
      std::vector<int32_t> in_joined(whole.mesh.vertices.size(), kUnused);
      for (size_t f = 0; f < whole.mesh.faces.size(); ++f) {
        if (in_band_[side][f]) continue;
        for (const int v : whole.mesh.faces[f]) in_joined[Index(v)] = kOutside;
      }
      for (size_t v = 0; v < place_[side].size(); ++v) {
        if (band.whole_vertex[v] >= 0 && place_[side][v] >= 0) {
          in_joined[Index(band.whole_vertex[v])] = place_[side][v];
        }
      }
      whole_place[side].assign(whole.mesh.vertices.size(), -1);
      for (size_t v = 0; v < in_joined.size(); ++v) {
        if (in_joined[v] == kUnused) continue;
        whole_place[side][v] = static_cast<int32_t>(result.mesh.vertices.size());
        if (in_joined[v] == kOutside) {
          Append(whole.mesh.vertices[v], whole.sources[v], whole.is_changed[v],
                 IsPreferred(whole, v), &result);
          continue;
        }
        const size_t j = Index(in_joined[v]);
        joined_place[j] = whole_place[side][v];
        Append(joined_.vertices[j], whole.sources[v],
               whole.is_changed[v] || has_moved_[j] || at_new_face[j], IsPreferred(whole, v),
               &result);
      }
      for (size_t v = 0; v < place_[side].size(); ++v) {
        if (band.whole_vertex[v] >= 0 || place_[side][v] < 0) continue;
        const size_t j = Index(place_[side][v]);
        joined_place[j] = static_cast<int32_t>(result.mesh.vertices.size());
        Append(joined_.vertices[j], band.sources[v], true, band.is_preferred[v] != 0, &result);
      }
    }
    size_t num_kept = 0;
    for (int side = 0; side < 2; ++side) {
      const TriangleMesh& mesh = whole_[side]->mesh;
      for (size_t f = 0; f < mesh.faces.size(); ++f) {
        if (in_band_[side][f]) continue;
        const Eigen::Vector3i& face = mesh.faces[f];
        result.mesh.faces.emplace_back(whole_place[side][Index(face[0])],
                                       whole_place[side][Index(face[1])],
                                       whole_place[side][Index(face[2])]);
      }
      for (size_t f = 0; f < joined_.faces.size(); ++f) {
        if (SideOf(f) != side) continue;
        const Eigen::Vector3i& face = joined_.faces[f];
        result.mesh.faces.emplace_back(joined_place[Index(face[0])], joined_place[Index(face[1])],
                                       joined_place[Index(face[2])]);
        num_kept += f < num_old_faces_;
      }
    }
    counters_.num_dropped_faces += num_band_faces_ - std::min(num_band_faces_, num_kept);
    return result;
  }

  // New faces are listed with the second surface's.
  int SideOf(size_t f) const { return f < num_old_faces_ ? face_side_[f] : 1; }

  static bool IsPreferred(const SourcedMesh& mesh, size_t v) {
    return !mesh.is_preferred.empty() && mesh.is_preferred[v];
  }

  static void Append(const Eigen::Vector3d& x, const VertexSource& source, bool is_changed,
                     bool is_preferred, SourcedMesh* mesh) {
    mesh->mesh.vertices.push_back(x);
    mesh->sources.push_back(source);
    mesh->is_changed.push_back(is_changed);
    mesh->is_preferred.push_back(is_preferred);
  }

  static constexpr int32_t kUnused = -1, kOutside = -2;

  std::array<const SourcedMesh*, 2> whole_;
  const SurfaceMergingOptions& options_;
  const RunContext& context_;
  SurfaceMergingCounters& counters_;
  double edge_ = 0;
  std::array<double, 2> mean_edge_ = {};
  std::array<std::vector<uint8_t>, 2> in_band_;        // #F of the wholes
  std::array<std::vector<uint8_t>, 2> in_free_space_;  // #V of the wholes, or empty
  std::array<MeshBand, 2> bands_;
  size_t num_band_faces_ = 0;
  std::array<std::unique_ptr<BandSurface>, 2> surfaces_;
  std::array<std::unique_ptr<OverlapSide>, 2> sides_;
  std::array<std::vector<uint8_t>, 2> kept_;  // #F of the bands
  std::array<std::vector<Eigen::Vector3d>, 2> displacements_;
  std::array<std::vector<uint8_t>, 2> band_may_move_;
  std::array<std::vector<int32_t>, 2> place_;  // of the bands' vertices in the joined mesh
  // What is kept of both bands, then the seam's faces.
  TriangleMesh joined_;
  size_t num_old_faces_ = 0;
  std::vector<uint8_t> face_side_, side_of_, has_moved_, may_move_, is_free_;
  std::vector<double> edge_length_;
  std::vector<Eigen::Vector3d> normal_;
  std::vector<uint64_t> old_border_, cut_edges_;
};

}  // namespace

std::vector<ConflictPoint> FindConflicts(const SourcedMesh& first, const SourcedMesh& second,
                                         const SurfaceMergingOptions& options,
                                         const RunContext& context) {
  SurfaceMergingCounters counters;
  SurfaceMerger merger(first, second, options, context, &counters);
  merger.CompareMeshes();
  return merger.Conflicts();
}

double CoarserEdgeLength(const SourcedMesh& first, const SourcedMesh& second) {
  return std::max(MeanEdgeLength(first.mesh), MeanEdgeLength(second.mesh));
}

SourcedMesh MergeSurfaces(const SourcedMesh& first, const SourcedMesh& second,
                          const SurfaceMergingOptions& options, const RunContext& context,
                          SurfaceMergingCounters* counters) {
  return SurfaceMerger(first, second, options, context, counters).Run();
}

}  // namespace lsmvs
