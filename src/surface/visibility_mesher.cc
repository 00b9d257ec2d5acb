#include "lsmvs/surface/visibility_mesher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/surface/checkpoints/mesher_checkpoints.h"
#include "lsmvs/surface/extraction/surface_cleaning.h"
#include "lsmvs/surface/memory_model.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/points/point_sorting.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/surface/visibility_weights.h"
#include "lsmvs/surface/weights/free_space_filter.h"
#include "lsmvs/surface/weights/ray_weigher.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/scratch_memory.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

// With a ScratchMemory the same work is done in parts, with the same bytes: vertices lie along a
// Hilbert curve; tetrahedra are made tile by tile and stored in that order; rays go out block by
// block; the cut solves runs of tetrahedra that fit into memory and then augments across their
// walls. So each part is in memory while it is worked on, and is moved to the file and back a few
// times.
//   H.-H. Vu: Large-scale and high-quality multi-view stereo, PhD thesis, 2011, chapter 6, which
//   divides the points by a kd-tree; runs of a Hilbert curve are such parts.
//
// Checkpoints: kept are, in bytes a vertex of the tetrahedralisation, the merged points (about 75;
// for 30 % of the time of a run), the labels of the tetrahedra after the cut (1; for 40 %) and the
// surface before it is cleaned (50, when the tetrahedra have gone; with these, for 25 % more). The
// tetrahedra are not: 220 bytes a vertex, or 350 with their weights, would be half of the scratch
// file again. So a run that is killed while it makes or weighs tetrahedra begins with them.
//
// Runs the phases one after the other, each dropping what the next do not need.
class Mesher {
 public:
  Mesher(const Scene& scene, const std::function<VisibilityCloud()>& read_cloud,
         const VisibilityMesherOptions& options, const RunContext& context,
         const CheckpointFolder& checkpoints)
      : scene_(scene),
        read_cloud_(read_cloud),
        options_(options),
        context_(context),
        checkpoints_(checkpoints) {
    size_.num_threads = context.num_threads();
  }

  VisibilityMesherResult Run() {
    const RunContext& all = context_;
    // Parts as measured on clouds of 1 to 5 million points.
    MergeAndFilter(all.Part(0, 0.27));
    if (merged_.positions.empty()) {
      return Fail(VisibilityMesherStatus::kNoPoints, "no point that a view sees: nothing to mesh");
    }
    if (checkpoints_.HasSurface()) {
      checkpoints_.ReadSurface(&result_.counters, &surface_, &result_.point_is_free);
      merged_.positions = {};
    } else {
      Time("tetrahedra", [&] {
        complex_ = BuildDelaunay(std::exchange(merged_.positions, {}), all.Part(0.27, 0.51));
      });
      if (complex_.cells.empty()) {
        return Fail(VisibilityMesherStatus::kDegenerate,
                    fmt::format("{} different points, which span no volume: nothing to mesh",
                                complex_.points.size()));
      }
      LabelCells(all);
      Time("extraction", [&] { Extract(); });
    }
    all.Report(0.93);
    if (surface_.mesh.faces.empty()) {
      return Fail(VisibilityMesherStatus::kEmptyCut, "the views support no surface");
    }
    Time("cleaning", [&] { Clean(); });
    return Succeed();
  }

 private:
  template <class Phase>
  void Time(const char* name, const Phase& phase) {
    context_.ThrowIfCancelled();
    const PhaseTimer timer(name, &result_.seconds);
    phase();
  }

  void MergeAndFilter(const RunContext& context) {
    if (checkpoints_.HasMerged()) {
      Time("merging", [&] { checkpoints_.ReadMerged(&result_.counters, &merged_); });
      return;
    }
    Time("merging", [&] { Merge(context); });
    if (options_.filter_levels > 0) Time("filter", [&] { Filter(); });
    result_.counters.num_vertices = size_.num_vertices = merged_.positions.size();
    size_.num_sights = merged_.sights.size();
    result_.predicted_peak_bytes = size_.PeakBytes();
    CheckBudget(result_.predicted_peak_bytes);
    checkpoints_.WriteMerged(result_.counters, &merged_);
  }

  PointMergingOptions Merging() const {
    PointMergingOptions merging = options_.merging;
    merging.keep_assignment = options_.find_free_points;
    return merging;
  }

  void Merge(const RunContext& context) {
    VisibilityCloud cloud = read_cloud_();
    cloud.CheckConsistent(scene_.views.size());
    result_.counters.num_points = size_.num_points = cloud.size();
    size_.num_view_entries = cloud.view_idxs.size();
    CheckBudget(size_.MergingBytes());
    // In scratch memory points that merge must lie together; in memory that gains nothing.
    std::vector<uint32_t> places;
    if (ScratchMemory::IsOn()) places = SortByPlace(&cloud, context);
    if (!options_.find_free_points) std::vector<uint32_t>().swap(places);
    merged_ = MergePoints(scene_, cloud, Merging(), context);
    if (!places.empty()) PutBack(places, &merged_.vertex_of_point);
    result_.counters.num_ignored_points = merged_.num_ignored_points;
  }

  // From the order of the sorted cloud to that of the file.
  static void PutBack(const std::vector<uint32_t>& places, std::vector<uint32_t>* vertices) {
    std::vector<uint32_t> in_file_order;
    in_file_order.reserve(places.size());
    for (const uint32_t place : places) in_file_order.push_back((*vertices)[place]);
    vertices->swap(in_file_order);
  }

  void Filter() {
    const FreeSpaceFilterOptions filter{options_.filter_levels, Merging(), options_.weights,
                                        CellsAtOnce()};
    // Reports no progress of its own: it takes a tenth of the time.
    RunContext context = context_;
    context.set_progress(nullptr);
    result_.counters.num_filtered_vertices = FilterFreeSpace(scene_, filter, context, &merged_);
  }

  // Which cells are empty and which full.
  void LabelCells(const RunContext& all) {
    if (checkpoints_.HasLabels()) {
      checkpoints_.ReadLabels(&result_.counters, &complex_);
    } else {
      result_.counters.num_cells = complex_.cells.size();
      Time("rays", [&] { Weigh(all.Part(0.51, 0.8)); });
      Time("cut", [&] { Cut(all.Part(0.8, 0.87)); });
      checkpoints_.WriteLabels(result_.counters, complex_);
    }
    if (options_.find_free_points) FindFreePoints();
  }

  void CheckBudget(size_t bytes) const {
    if (bytes <= context_.memory_budget_bytes || ScratchMemory::IsOn()) return;
    const double need = static_cast<double>(bytes),
                 allowed = static_cast<double>(context_.memory_budget_bytes);
    std::string advice = "give a smaller cloud or --bounding_box";
    if (size_.num_vertices > 0) {
      // The number of vertices goes with the square of their distance.
      const double distance = options_.merging.max_proj_dist * std::sqrt(need / allowed);
      advice = distance > 0 ? fmt::format("set --VisibilityMeshing.max_proj_dist to {:.1f}",
                                          std::ceil(12 * distance) / 10)
                            : "raise --VisibilityMeshing.max_proj_dist above 0";
    }
    throw MemoryError(fmt::format(
        "the surface of {} points needs about {} of memory and {} are allowed; "
        "raise --max_memory or {}",
        size_.num_points, FormatBytes(bytes), FormatBytes(context_.memory_budget_bytes), advice));
  }

  void Weigh(const RunContext& context) {
    checkpoints_.LoadSights(&merged_);
    result_.counters.rays = WeighCells(scene_, merged_, options_.weights, context, &complex_);
    checkpoints_.DropSights(&merged_);
  }

  // Cells that are cut together: all, or as many as stay in memory with what the cut needs.
  static size_t CellsAtOnce() {
    if (!ScratchMemory::IsOn()) return kAllNodes;
    constexpr size_t kShare = 4;
    return ScratchMemory::MaxBytesInMemory() / kShare / sizeof(Cell);
  }

  void Cut(const RunContext& context) {
    result_.counters.cut_value =
        static_cast<double>(MaximizeFlow(&complex_.cells, context, CellsAtOnce())) /
        kCapacityPerWeight;
    for (const Cell& cell : complex_.cells) {
      result_.counters.num_empty_cells += cell.OnSourceSide();
    }
  }

  void FindFreePoints() {
    checkpoints_.LoadVertexOfPoint(&merged_);
    std::vector<uint8_t> is_free(complex_.points.size(), 1);
    for (size_t c = 0; c < complex_.num_finite_cells; ++c) {
      const Cell& cell = complex_.cells[c];
      if (cell.OnSourceSide()) continue;
      for (const int32_t v : cell.vertex) is_free[static_cast<size_t>(v)] = 0;
    }
    for (const auto& [duplicate, original] : complex_.duplicates) {
      is_free[static_cast<size_t>(duplicate)] = is_free[static_cast<size_t>(original)];
    }
    result_.point_is_free.reserve(merged_.vertex_of_point.size());
    for (const uint32_t vertex : merged_.vertex_of_point) {
      result_.point_is_free.push_back(vertex == MergedCloud::kIgnoredPoint || is_free[vertex]);
    }
    std::vector<uint32_t>().swap(merged_.vertex_of_point);
  }

  void Extract() {
    surface_ = ExtractSurface(std::move(complex_));
    result_.counters.num_cut_facets = surface_.num_cut_facets;
    result_.counters.num_split_vertices = surface_.num_split_vertices;
    checkpoints_.WriteSurface(result_.counters, surface_, result_.point_is_free);
  }

  void Clean() {
    checkpoints_.LoadSights(&merged_);
    checkpoints_.LoadLooks(&merged_);
    result_.counters.cleaning = CleanSurface(
        scene_, merged_, options_.cleaning, options_.merging.visibility_sigma, context_, &surface_);
  }

  VisibilityMesherResult Fail(VisibilityMesherStatus status, const std::string& message) {
    result_.status = status;
    result_.message = message;
    return std::move(result_);
  }

  VisibilityMesherResult Succeed() {
    TriangleMesh& mesh = surface_.mesh;
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      mesh.vertices[v] = merged_.frame.ToWorld(mesh.vertices[v]);
      const int32_t point = surface_.vertex_point[v];
      if (point >= 0) {
        for (const Sight& sight : merged_.SightsOf(static_cast<size_t>(point))) {
          result_.view_idxs.push_back(sight.view_idx);
        }
      }
      result_.view_begin.push_back(result_.view_idxs.size());
    }
    mesh.vertex_normals = ComputeVertexNormals(mesh);
    result_.message = fmt::format("{} vertices and {} faces from {} points", mesh.vertices.size(),
                                  mesh.faces.size(), result_.counters.num_points);
    result_.mesh = std::move(mesh);
    result_.measured_peak_bytes = memory_.PeakBytes() - memory_.bytes_before();
    context_.Report(1);
    return std::move(result_);
  }

  const Scene& scene_;
  const std::function<VisibilityCloud()>& read_cloud_;
  const VisibilityMesherOptions& options_;
  const RunContext& context_;
  const internal::MesherCheckpoints checkpoints_;
  MergedCloud merged_;
  Tetrahedralization complex_;
  ExtractedSurface surface_;
  VisibilityMesherResult result_;
  MeshingSize size_;
  PeakMemoryWatch memory_;
};

}  // namespace

VisibilityMesherResult MeshVisibilityCloud(const Scene& scene, VisibilityCloud cloud,
                                           const VisibilityMesherOptions& options,
                                           const RunContext& context) {
  return MeshVisibilityCloud(
      scene, [&] { return std::move(cloud); }, options, context, CheckpointFolder());
}

VisibilityMesherResult MeshVisibilityCloud(const Scene& scene,
                                           const std::function<VisibilityCloud()>& read_cloud,
                                           const VisibilityMesherOptions& options,
                                           const RunContext& context,
                                           const CheckpointFolder& checkpoints) {
  RequireValid(options);
  return Mesher(scene, read_cloud, options, context, checkpoints).Run();
}

}  // namespace lsmvs
