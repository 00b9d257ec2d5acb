#include <fmt/format.h>

#include <memory>
#include <optional>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/commands/comparison.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"
#include "lsmvs/colmap_adapter/prepare_workspace.h"
#include "lsmvs/colmap_adapter/undistorted_masks.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// Nothing: the first or the last one.
using StageChoice = std::optional<ReconstructionStage>;

// `open_end` is the name of the choice that names no stage.
std::vector<std::pair<std::string, StageChoice>> StageNames(const std::string& open_end) {
  using enum ReconstructionStage;
  std::vector<std::pair<std::string, StageChoice>> names = {{open_end, std::nullopt}};
  for (const auto stage : {kStereo, kFusion, kQuasiDense, kSurface, kRefinement, kTexturing}) {
    names.emplace_back(StageName(stage), stage);
  }
  return names;
}

class MesherCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {
        "lsmvs-mesher",
        "From what `colmap mapper` leaves to a refined mesh, in one command",
        "WORKSPACE is a COLMAP project (images/ and sparse/0, sparse/1, ...), whose models are "
        "undistorted by `colmap "
        "image_undistorter` into dense/0, dense/1, ...; or a folder that "
        "automatic_reconstructor made; or a dense workspace "
        "itself. Each dense workspace is taken through these stages:\n"
        "- patch_match_stereo: depth and normal maps in stereo/ (COLMAP's format); those of the "
        "photometric pass only until the geometric ones are done\n"
        "- stereo_fusion: fused.ply and fused.ply.vis (COLMAP's format)\n"
        "- quasi_dense_matcher, in the place of these two with --quality low or "
        "--point_source quasi_dense: fused.ply and fused.ply.vis from interest points\n"
        "- visibility_mesher: meshed-visibility.ply\n"
        "- mesh_refiner: meshed-refined.ply, with vertex colours\n"
        "- mesh_texturer, with --texture: textured/mesh.ply and its pages, textured/texture.png "
        "and further ones\n"
        "lsmvs/run.json keeps, for each stage, options, input hashes, time, memory and counts. "
        "A rerun skips what is up to "
        "date; a stopped or killed run goes on where it was. Files that COLMAP or you made are "
        "never replaced without "
        "--overwrite: depth maps and a fused.ply that are there are used as they are, a mesh "
        "in the way stops the run.\n"
        "The first Ctrl-C ends the run cleanly, a second one at once. The result does not "
        "depend on the number of threads.",
        {"lsmvs-mesher project", "lsmvs-mesher project --quality low",
         "lsmvs-mesher project --texture", "lsmvs-mesher project --quality medium --max_memory 8GB",
         "lsmvs-mesher project/dense/0 --from visibility_mesher "
         "--VisibilityMeshing.max_proj_dist 1"},
        {"workspace_path"},
        "workspace_path",
        {"log_to_stderr", "use_gpu", "gpu_index", "sparse", "dense", "PatchMatchStereo.gpu_index",
         "PatchMatchStereo.num_samples", "PatchMatchStereo.ncc_sigma",
         "PatchMatchStereo.incident_angle_sigma", "PatchMatchStereo.cache_size",
         "PatchMatchStereo.write_consistency_graph", "StereoFusion.max_traversal_depth",
         "StereoFusion.use_cache", "StereoFusion.cache_size"}};
  }

  void Describe(OptionSet* options) override {
    options->Add("workspace_path", &stage_.workspace_path,
                 "The workspace; may be given without the name of the option.");
    options->Add("image_path", &image_path_,
                 "Folder of the photos of a project that do not lie in its images/.");
    options->AddEnum("quality", &quality_,
                     "As COLMAP's: photos are reduced to 1000, 1600 or 2400 pixels or taken as "
                     "they are; the lower two take fewer "
                     "iterations, and low takes its points from quasi_dense_matcher.",
                     {{"low", Quality::kLow},
                      {"medium", Quality::kMedium},
                      {"high", Quality::kHigh},
                      {"extreme", Quality::kExtreme}});
    options->AddEnum(
        "point_source", &point_source_,
        "How points come from photos: patch_match by depth maps and their fusion; "
        "quasi_dense by interest points, in about a quarter of the time and with "
        "an eighth of the points; auto: quasi_dense with --quality low, else patch_match.",
        {{"auto", std::nullopt},
         {"patch_match", PointSource::kPatchMatch},
         {"quasi_dense", PointSource::kQuasiDense}});
    options->Add("max_image_size", &max_image_size_,
                 "Longer side in pixels to which photos are reduced, instead of what --quality "
                 "says; -1 takes them as they "
                 "are. Time and memory go with its square.",
                 {-1, 1000000});
    options->Add("mask_path", &stage_.mask_path,
                 "Folder with masks: of photo a/b.jpg it is a/b.jpg.png or a/b.png; black pixels "
                 "are not used. Masks of a project are those of its photos, as given to COLMAP's "
                 "--ImageReader.mask_path, and are undistorted with them; masks of a dense "
                 "workspace are those of its undistorted images.");
    stage_.DescribeAlphaMask(options);
    stage_.DescribeSkipMissingImages(options);
    stage_.DescribeBoundingBox(options);
    stage_.DescribeDatabasePath(options);
    options->AddEnum("from", &from_,
                     "First stage; what earlier stages make must be there and is used as it is.",
                     StageNames("first"));
    options->AddEnum("to", &to_, "Last stage.", StageNames("last"));
    options->Add("texture", &texture_,
                 "Texture the refined mesh with the photos, as --to mesh_texturer does.");
    stage_.DescribeRun(options);
    stage_.DescribeScratch(options);
    stage_.DescribeMaps(false, options);
    options->Add("report", &report_,
                 "End with a page that shows the meshes beside COLMAP's, those that are there: "
                 "lsmvs/report/index.html (see lsmvs mesh_comparer).");
    options_.Describe(options);
  }

  void ApplyPresets() override {
    ApplyQuality(quality_, &options_);
    options_.point_source = point_source_.value_or(options_.point_source);
  }

  void Run(const CommandContext& context) override {
    if (texture_ && to_.value_or(ReconstructionStage::kTexturing) != To()) {
      throw UsageError("--texture and --to name different last stages; give one of them");
    }
    CheckStages(options_.point_source, From(), To());
    if (max_image_size_.has_value()) options_.max_image_size = std::max(0, *max_image_size_);
    options_.keep_photometric_maps = stage_.keep_photometric_maps;
    options_.map_precision = stage_.map_precision;
    options_.bounding_box = ParseBox("bounding_box", stage_.bounding_box);
    std::optional<Error> first_error;
    const auto entries = FindDenseWorkspaces(stage_.workspace_path, image_path_);
    for (const WorkspaceEntry& entry : entries) {
      try {
        RunWorkspace(entry, context);
      } catch (const InputError& error) {
        // The other models of the project are none the worse for it.
        if (entries.size() == 1) throw;
        context.console->Abandon();
        fmt::print(stderr, "error: {}\n", error.what());
        if (!first_error) first_error = error;
      }
    }
    if (first_error)
      throw Error(first_error->code(), "not all models could be reconstructed; see above");
  }

 private:
  ReconstructionStage From() const {
    return from_.value_or(StagesOf(options_.point_source).front());
  }
  ReconstructionStage To() const {
    if (texture_) return ReconstructionStage::kTexturing;
    return to_.value_or(ReconstructionStage::kRefinement);
  }

  void RunWorkspace(const WorkspaceEntry& entry, const CommandContext& context) {
    if (!IsWanted(entry.workspace, context)) return;
    const DenseWorkspace workspace = Prepare(entry, context);
    StageOptions stage = stage_;
    if (UsesPhotos()) stage.mask_path = Masks(entry, context);
    const auto reconstruction = OpenReconstruction(
        workspace, stage, options_, context, UsesPhotos() ? PhotoUse::kPixels : PhotoUse::kNothing);
    RunPlanned(workspace, *reconstruction, MakeReconstructionTasks(reconstruction, From(), To()),
               stage_, context);
    if (report_ && !context.job) WriteReport(workspace, context);
  }

  // A cloud is meshed without.
  bool UsesPhotos() const {
    return From() != ReconstructionStage::kSurface || To() != ReconstructionStage::kSurface;
  }

  // Folder of the masks of the workspace's images.
  std::string Masks(const WorkspaceEntry& entry, const CommandContext& context) const {
    const MaskOptions options{stage_.mask_path, stage_.alpha_is_mask};
    return PrepareMasks(entry, options, ColmapRunner(), context.run);
  }

  static void WriteReport(const DenseWorkspace& workspace, const CommandContext& context) {
    ComparisonOptions options;
    options.workspace_path = workspace.folder.string();
    fmt::print("{}\n", WriteComparison(options, context).string());
  }

  DenseWorkspace Prepare(const WorkspaceEntry& entry, const CommandContext& context) {
    if (entry.exists) return entry.workspace;
    context.console->Begin("undistortion by colmap");
    PrepareWorkspaceOptions options;
    options.image_folder = image_path_;
    options.skip_missing_images = stage_.skip_missing_images;
    const DenseWorkspace workspace =
        PrepareDenseWorkspace(entry, ColmapRunner(), options, context.run);
    context.console->End(workspace.folder.string());
    return workspace;
  }

  StageOptions stage_;
  std::string image_path_;
  Quality quality_ = Quality::kHigh;
  std::optional<PointSource> point_source_;
  std::optional<int> max_image_size_;
  StageChoice from_, to_;
  bool texture_ = false, report_ = false;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeMesherCommand() { return std::make_unique<MesherCommand>(); }

}  // namespace lsmvs
