#include "lsmvs/merging/mesh_merger.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "lsmvs/merging/overlap/free_space.h"
#include "lsmvs/merging/overlap/input_check.h"
#include "lsmvs/merging/overlap/overlap.h"
#include "lsmvs/merging/seam/surface_merging.h"
#include "lsmvs/merging/tetrahedra/tetrahedral_patch.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"

namespace lsmvs {

namespace {

// Edge lengths within which registration is measured.
constexpr double kMeasuringReach = 40;
// Edge lengths around an overlap, or a place of trouble, that a new surface takes in.
constexpr double kPatchReach = 8;
// Edge lengths before the other mesh where nothing can be if its views are right.
constexpr double kFreeSpaceMargin = 6;
constexpr size_t kMinSamplesOver = 10;
constexpr double kMaxOppositeShare = 0.5;
// Surfaces are matched up to this many times the offset that was measured, and edge lengths beyond:
// the offset is a median, and noise has tails.
constexpr double kMatchingOffsets = 3, kMatchingMargin = 3;

const Eigen::Matrix<uint8_t, 3, 1> kGrey(160, 160, 160);

size_t Index(int32_t i) { return static_cast<size_t>(i); }

template <class Value>
void UpdateWith(const std::vector<Value>& values, Hasher* hasher) {
  const uint64_t count = values.size();
  hasher->Update(&count, sizeof count);
  hasher->Update(values.data(), values.size() * sizeof(Value));
}

// The content of an input, but not its name: what its place in the order follows from.
std::string ContentKey(const MergingInput& input) {
  Hasher hasher;
  UpdateWith(input.mesh.vertices, &hasher);
  UpdateWith(input.mesh.faces, &hasher);
  UpdateWith(input.mesh.vertex_colors, &hasher);
  UpdateWith(input.mesh.vertex_normals, &hasher);
  UpdateWith(input.mesh.vertex_quality, &hasher);
  UpdateWith(input.view_begin, &hasher);
  UpdateWith(input.view_idxs, &hasher);
  return hasher.HexDigest();
}

std::string DescribePlace(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : mesh.vertices) box.extend(x);
  const Eigen::Vector3d c = box.center(), s = box.sizes();
  return fmt::format(
      "a box of {:.4g} x {:.4g} x {:.4g} about ({:.4g}, {:.4g}, {:.4g}), edges of "
      "{:.3g}",
      s.x(), s.y(), s.z(), c.x(), c.y(), c.z(), MeanEdgeLength(mesh));
}

class Merger {
 public:
  Merger(std::vector<MergingInput> inputs, const std::vector<View>& views,
         const MeshMergerOptions& options, const RunContext& context)
      : inputs_(std::move(inputs)), views_(views), options_(options), context_(context) {}

  MergedMesh Run() {
    SortInputs();
    parts_.resize(inputs_.size());
    std::vector<size_t> waiting(inputs_.size());
    std::iota(waiting.begin(), waiting.end(), size_t{0});
    for (const size_t i : waiting) parts_[i] = MakePart(i);
    merged_ = std::move(parts_[0]);
    names_ = inputs_[0].name;
    waiting.erase(waiting.begin());
    const double num_steps = static_cast<double>(waiting.size());
    for (size_t step = 0; !waiting.empty(); ++step) {
      const double begin = static_cast<double>(step) / num_steps;
      const RunContext part = context_.Part(begin, begin + 1 / num_steps);
      MergeOne(&waiting, part);
    }
    return Finish();
  }

 private:
  void SortInputs() {
    std::vector<std::pair<std::string, size_t>> order;
    for (size_t i = 0; i < inputs_.size(); ++i) order.emplace_back(ContentKey(inputs_[i]), i);
    std::sort(order.begin(), order.end());
    std::vector<MergingInput> sorted;
    for (const auto& [key, i] : order) sorted.push_back(std::move(inputs_[i]));
    inputs_ = std::move(sorted);
  }

  SourcedMesh MakePart(size_t i) {
    SourcedMesh part;
    num_vertices_.push_back(inputs_[i].mesh.vertices.size());
    part.mesh.vertices = std::exchange(inputs_[i].mesh.vertices, {});
    part.mesh.faces = std::exchange(inputs_[i].mesh.faces, {});
    part.is_changed.assign(part.mesh.vertices.size(), 0);
    part.sources.resize(part.mesh.vertices.size());
    for (size_t v = 0; v < part.sources.size(); ++v) {
      part.sources[v] = {static_cast<int32_t>(i), static_cast<int32_t>(v)};
    }
    const RepairCounters repair = RepairInput(inputs_[i].name, &part);
    counters_.num_repaired_faces += repair.num_dropped_faces;
    counters_.num_split_vertices += repair.num_split_vertices;
    return part;
  }

  // The first mesh that overlaps what is merged so far.
  void MergeOne(std::vector<size_t>* waiting, const RunContext& context) {
    for (size_t k = 0; k < waiting->size(); ++k) {
      const size_t i = (*waiting)[k];
      const std::optional<Registration> registration = Register(parts_[i], context);
      if (!registration) continue;
      CheckRegistration(*registration, i);
      Merge(std::exchange(parts_[i], {}), *registration, context);
      names_ += ", " + inputs_[i].name;
      waiting->erase(waiting->begin() + static_cast<std::ptrdiff_t>(k));
      return;
    }
    const size_t i = waiting->front();
    throw InputError(inputs_[i].name,
                     fmt::format("does not overlap {}: it lies in {}, the other in {}", names_,
                                 DescribePlace(parts_[i].mesh), DescribePlace(merged_.mesh)),
                     "bring the models into one frame and scale first, as colmap model_merger or "
                     "model_aligner does");
  }

  // Nothing if the meshes do not overlap.
  std::optional<Registration> Register(const SourcedMesh& part, const RunContext& context) const {
    const double reach = kMeasuringReach * CoarserEdgeLength(merged_, part);
    const MeshBand band = ExtractBand(part, FacesNear(part.mesh, merged_.mesh, reach));
    const MeshBand other = ExtractBand(merged_, FacesNear(merged_.mesh, part.mesh, reach));
    if (band.mesh.faces.empty() || other.mesh.faces.empty()) return std::nullopt;
    const BandSurface surface(band), other_surface(other);
    Registration there = MeasureRegistration(surface, other_surface, reach, context);
    Registration back = MeasureRegistration(other_surface, surface, reach, context);
    // Seen from the side of which more lies over the other.
    const Registration& result = there.num_over >= back.num_over ? there : back;
    if (result.num_over < kMinSamplesOver) return std::nullopt;
    return result;
  }

  void CheckRegistration(const Registration& registration, size_t i) const {
    if (registration.share_opposite > kMaxOppositeShare) {
      throw InputError(
          inputs_[i].name,
          fmt::format("is inside out to {}: {:.0f} % of its normals are opposite where "
                      "they overlap",
                      names_, 100 * registration.share_opposite),
          "flip the faces of one of them; they must look outward, to the cameras");
    }
    if (registration.offset_edges > options_.max_offset) {
      throw InputError(
          inputs_[i].name,
          fmt::format("is {:.3g} away from {} where they overlap (median), {:.1f} edge lengths; "
                      "at most {:g} can be absorbed",
                      registration.offset, names_, registration.offset_edges, options_.max_offset),
          "align the models first, with colmap model_aligner or model_merger, or raise "
          "--MeshMerging.max_offset");
    }
  }

  void Merge(const SourcedMesh& part, const Registration& registration, const RunContext& context) {
    counters_.max_offset = std::max(counters_.max_offset, registration.offset);
    counters_.max_offset_edges = std::max(counters_.max_offset_edges, registration.offset_edges);
    // The finer mesh comes first.
    const bool is_finer = MeanEdgeLength(part.mesh) < MeanEdgeLength(merged_.mesh);
    const SourcedMesh& first = is_finer ? part : merged_;
    const SourcedMesh& second = is_finer ? merged_ : part;
    SurfaceMergingOptions surface;
    surface.max_edges = kMatchingOffsets * registration.offset_edges + kMatchingMargin;
    surface.inset = options_.inset;
    surface.worth = ConflictWorthOf();
    surface.in_free_space = FreeSpaceTest(context);
    SurfaceMergingCounters counters;
    if (options_.method == MergingMethod::kTetrahedra) {
      const double reach = kPatchReach * CoarserEdgeLength(first, second);
      const PatchFaces faces = {FacesNear(first.mesh, second.mesh, reach),
                                FacesNear(second.mesh, first.mesh, reach)};
      const auto conflicts = FindConflicts(first, second, surface, context);
      merged_ = MergeThroughPatch(first, second, faces, conflicts, surface, context, &counters);
    } else {
      SourcedMesh joined = MergeSurfaces(first, second, surface, context, &counters);
      if (options_.method == MergingMethod::kAuto && !counters.trouble.empty()) {
        MendTrouble(first, second, surface, context, &joined, &counters);
      }
      merged_ = std::move(joined);
    }
    counters_.num_dropped_faces += counters.num_dropped_faces;
    counters_.num_new_faces += counters.num_new_faces;
    counters_.num_open_seam_edges += counters.num_open_edges;
    counters_.num_seam_crossings += counters.num_crossings;
    counters_.num_conflict_faces += counters.num_conflict_faces;
  }

  // A new surface through tetrahedra in place of the faces, joined to what is left of both meshes.
  SourcedMesh MergeThroughPatch(const SourcedMesh& first, const SourcedMesh& second,
                                const PatchFaces& faces,
                                const std::vector<ConflictPoint>& conflicts,
                                const SurfaceMergingOptions& options, const RunContext& context,
                                SurfaceMergingCounters* counters) const {
    TetrahedralPatchOptions patch_options;
    patch_options.max_edges = options.max_edges;
    patch_options.conflicts = conflicts;
    patch_options.views = views_;
    patch_options.visit_views = ViewVisitor();
    SourcedMesh patch = MakeTetrahedralPatch(first, second, faces, patch_options, context);
    if (patch.mesh.faces.empty()) return MergeSurfaces(first, second, options, context, counters);
    patch.is_preferred.assign(patch.mesh.vertices.size(), 1);
    SurfaceMergingOptions join = options;
    join.in_free_space = LostVertices(conflicts);  // the patch has decided
    join.worth = nullptr;
    SourcedMesh merged = MergeSurfaces(patch, first, join, context, counters);
    merged = MergeSurfaces(merged, second, join, context, counters);
    merged.is_preferred.clear();
    return merged;
  }

  // Tells the vertices that have lost a conflict: what the patch leaves out must not come back.
  static std::function<std::vector<uint8_t>(const SourcedMesh&, const SourcedMesh&)> LostVertices(
      const std::vector<ConflictPoint>& conflicts) {
    const auto is_before = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    };
    std::vector<Eigen::Vector3d> lost;
    for (const ConflictPoint& conflict : conflicts) {
      if (conflict.IsLost()) lost.push_back(conflict.position);
    }
    std::sort(lost.begin(), lost.end(), is_before);
    return [lost = std::move(lost), is_before](const SourcedMesh& mesh, const SourcedMesh&) {
      std::vector<uint8_t> flags(mesh.mesh.vertices.size());
      for (size_t v = 0; v < flags.size(); ++v) {
        flags[v] = std::binary_search(lost.begin(), lost.end(), mesh.mesh.vertices[v], is_before);
      }
      return flags;
    };
  }

  // Where the meshes contradict each other or could not be zipped, through tetrahedra. The result
  // is taken if it is not worse.
  void MendTrouble(const SourcedMesh& first, const SourcedMesh& second,
                   const SurfaceMergingOptions& options, const RunContext& context,
                   SourcedMesh* joined, SurfaceMergingCounters* counters) const {
    TriangleMesh trouble;
    trouble.vertices = counters->trouble;
    trouble.faces = PointFaces(trouble.vertices.size());
    const double reach = kPatchReach * CoarserEdgeLength(first, second);
    const PatchFaces faces = {FacesNear(first.mesh, trouble, reach),
                              FacesNear(second.mesh, trouble, reach)};
    SurfaceMergingCounters mended_counters;
    SourcedMesh mended = MergeThroughPatch(first, second, faces, counters->conflicts, options,
                                           context, &mended_counters);
    const auto faults = [](const SurfaceMergingCounters& c) {
      return c.num_open_edges + c.num_crossings;
    };
    if (faults(mended_counters) > faults(*counters)) return;
    mended_counters.num_conflict_faces = counters->num_conflict_faces;
    *joined = std::move(mended);
    *counters = std::move(mended_counters);
  }

  VisitViews ViewVisitor() const {
    return [this](const VertexSource& source, const std::function<void(uint32_t)>& visit) {
      const MergingInput& input = inputs_[Index(source.input)];
      if (input.view_begin.empty()) return;
      const size_t v = Index(source.vertex);
      for (uint64_t k = input.view_begin[v]; k < input.view_begin[v + 1]; ++k) {
        visit(input.view_idxs[k]);
      }
    };
  }

  // Nothing without views.
  std::function<std::vector<uint8_t>(const SourcedMesh&, const SourcedMesh&)> FreeSpaceTest(
      const RunContext& context) const {
    if (views_.empty() || std::none_of(inputs_.begin(), inputs_.end(), HasViews)) return nullptr;
    return [this, &context](const SourcedMesh& mesh, const SourcedMesh& other) {
      const double margin = kFreeSpaceMargin * CoarserEdgeLength(mesh, other);
      return FindVerticesInFreeSpace(mesh.mesh, other, views_, ViewVisitor(), margin, context);
    };
  }

  static bool HasViews(const MergingInput& input) { return !input.view_begin.empty(); }

  ConflictWorth ConflictWorthOf() const {
    if (options_.conflict_winner == ConflictWinner::kNewer) {
      return [this](const VertexSource& source, double) {
        return static_cast<double>(AgeRank(inputs_[Index(source.input)]));
      };
    }
    if (!std::all_of(inputs_.begin(), inputs_.end(), HasViews)) {
      return [](const VertexSource&, double edge_length) { return -edge_length; };
    }
    return [this](const VertexSource& source, double) {
      const std::vector<uint64_t>& begin = inputs_[Index(source.input)].view_begin;
      const size_t v = Index(source.vertex);
      return static_cast<double>(begin[v + 1] - begin[v]);
    };
  }

  // The number of inputs that are older.
  size_t AgeRank(const MergingInput& input) const {
    return static_cast<size_t>(
        std::count_if(inputs_.begin(), inputs_.end(), [&](const MergingInput& other) {
          return other.modification_time < input.modification_time;
        }));
  }

  MergedMesh Finish() {
    MergedMesh result;
    TriangleMesh& mesh = result.mesh;
    mesh.vertices = std::move(merged_.mesh.vertices);
    mesh.faces = std::move(merged_.mesh.faces);
    CarryColors(&mesh);
    Carry(&TriangleMesh::vertex_quality, &mesh);
    CarryNormals(&mesh);
    CarryViews(&result);
    counters_.num_moved_vertices = static_cast<size_t>(std::count_if(
        merged_.is_changed.begin(), merged_.is_changed.end(), [](uint8_t c) { return c != 0; }));
    result.counters = counters_;
    AddMessages();
    result.messages = std::move(messages_);
    return result;
  }

  void AddMessages() {
    const auto num_with_views = std::count_if(inputs_.begin(), inputs_.end(), HasViews);
    if (num_with_views > 0 && static_cast<size_t>(num_with_views) < inputs_.size()) {
      messages_.push_back("not all meshes have views: the result has none");
    }
    if (counters_.num_repaired_faces > 0 || counters_.num_split_vertices > 0) {
      messages_.push_back(fmt::format(
          "the meshes were no manifolds: {} faces without area, double or turned over were left "
          "out, {} vertices split",
          counters_.num_repaired_faces, counters_.num_split_vertices));
    }
    if (counters_.num_open_seam_edges > 0) {
      messages_.push_back(
          fmt::format("{} edges along seams stay open", counters_.num_open_seam_edges));
    }
    if (counters_.num_seam_crossings > 0) {
      messages_.push_back(
          fmt::format("{} pairs of faces at seams cross", counters_.num_seam_crossings));
    }
  }

  template <class Value>
  void Carry(std::vector<Value> TriangleMesh::*attribute, TriangleMesh* mesh) const {
    for (const MergingInput& input : inputs_) {
      if ((input.mesh.*attribute).empty()) return;
    }
    for (const VertexSource& source : merged_.sources) {
      (mesh->*attribute)
          .push_back((inputs_[Index(source.input)].mesh.*attribute)[Index(source.vertex)]);
    }
  }

  void CarryColors(TriangleMesh* mesh) {
    const auto has_colors = [](const MergingInput& input) {
      return !input.mesh.vertex_colors.empty();
    };
    if (std::none_of(inputs_.begin(), inputs_.end(), has_colors)) return;
    for (MergingInput& input : inputs_) {
      if (has_colors(input)) continue;
      messages_.push_back(input.name + " has no colours: what comes from it is grey");
      input.mesh.vertex_colors.assign(num_vertices_[static_cast<size_t>(&input - inputs_.data())],
                                      kGrey);
    }
    Carry(&TriangleMesh::vertex_colors, mesh);
  }

  void CarryNormals(TriangleMesh* mesh) const {
    Carry(&TriangleMesh::vertex_normals, mesh);
    if (mesh->vertex_normals.empty()) return;
    const std::vector<Eigen::Vector3f> fresh = ComputeVertexNormals(*mesh);
    for (size_t v = 0; v < fresh.size(); ++v) {
      if (merged_.is_changed[v]) mesh->vertex_normals[v] = fresh[v];
    }
  }

  void CarryViews(MergedMesh* result) const {
    for (const MergingInput& input : inputs_) {
      if (input.view_begin.empty()) return;
    }
    result->view_begin = {0};
    for (const VertexSource& source : merged_.sources) {
      const MergingInput& input = inputs_[Index(source.input)];
      const auto begin = input.view_idxs.begin();
      const size_t v = Index(source.vertex);
      result->view_idxs.insert(result->view_idxs.end(),
                               begin + static_cast<std::ptrdiff_t>(input.view_begin[v]),
                               begin + static_cast<std::ptrdiff_t>(input.view_begin[v + 1]));
      result->view_begin.push_back(result->view_idxs.size());
    }
  }

  std::vector<MergingInput> inputs_;
  const std::vector<View>& views_;
  const MeshMergerOptions& options_;
  const RunContext& context_;
  std::vector<size_t> num_vertices_;  // of the inputs
  std::vector<SourcedMesh> parts_;
  SourcedMesh merged_;
  std::string names_;  // of what is merged so far
  MeshMergerCounters counters_;
  std::vector<std::string> messages_;
};

}  // namespace

MergedMesh MergeMeshes(std::vector<MergingInput> inputs, const std::vector<View>& views,
                       const MeshMergerOptions& options, const RunContext& context) {
  std::string error;
  if (!options.Check(&error)) throw UsageError(error);
  if (inputs.size() < 2) throw UsageError("give two or more meshes to merge");
  return Merger(std::move(inputs), views, options, context).Run();
}

}  // namespace lsmvs
