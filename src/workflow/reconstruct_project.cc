#include "lsmvs/workflow/reconstruct_project.h"

#include <fmt/format.h>

#include <algorithm>

#include "lsmvs/colmap_adapter/prepare_workspace.h"
#include "lsmvs/colmap_adapter/undistorted_masks.h"
#include "lsmvs/util/error.h"
#include "lsmvs/workflow/compare_meshes.h"
#include "lsmvs/workflow/planning/run_reconstruction.h"

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

class ProjectReconstruction {
 public:
  ProjectReconstruction(const ProjectReconstructionOptions& options, const CommandContext& context)
      : options_(options), context_(context), reconstruction_(options.reconstruction) {
    if (options.texture && options.to.value_or(ReconstructionStage::kTexturing) != To()) {
      throw UsageError("--texture and --to name different last stages; give one of them");
    }
    CheckStages(reconstruction_.point_source, From(), To());
    const StageOptions& stage = options.stage;
    if (options.max_image_size) {
      reconstruction_.max_image_size = std::max(0, *options.max_image_size);
    }
    reconstruction_.keep_photometric_maps = stage.keep_photometric_maps;
    reconstruction_.map_precision = stage.map_precision;
    reconstruction_.bounding_box = stage.bounding_box;
  }

  void Run() const {
    std::optional<Error> first_error;
    const auto entries = FindDenseWorkspaces(options_.stage.workspace_path, options_.image_path);
    for (const WorkspaceEntry& entry : entries) {
      try {
        RunWorkspace(entry);
      } catch (const InputError& error) {
        // The other models of the project are none the worse for it.
        if (entries.size() == 1) throw;
        context_.console->Abandon();
        context_.console->Note(fmt::format("error: {}", error.what()));
        if (!first_error) first_error = error;
      }
    }
    if (first_error) {
      throw Error(first_error->code(), "not all models could be reconstructed; see above");
    }
  }

 private:
  ReconstructionStage From() const {
    return options_.from.value_or(StagesOf(reconstruction_.point_source).front());
  }
  ReconstructionStage To() const {
    if (options_.texture) return ReconstructionStage::kTexturing;
    return options_.to.value_or(ReconstructionStage::kRefinement);
  }

  // A cloud is meshed without.
  bool UsesPhotos() const {
    return From() != ReconstructionStage::kSurface || To() != ReconstructionStage::kSurface;
  }

  void RunWorkspace(const WorkspaceEntry& entry) const {
    if (!IsWanted(entry.workspace, context_)) return;
    const DenseWorkspace workspace = Prepare(entry);
    StageOptions stage = options_.stage;
    if (UsesPhotos()) stage.mask_path = Masks(entry).string();
    const auto reconstruction =
        OpenReconstruction(workspace, stage, reconstruction_, context_,
                           UsesPhotos() ? PhotoUse::kPixels : PhotoUse::kNothing);
    RunPlanned(workspace, *reconstruction, MakeReconstructionTasks(reconstruction, From(), To()),
               options_.stage, context_);
    if (options_.report && !context_.job) WriteReport(workspace);
  }

  DenseWorkspace Prepare(const WorkspaceEntry& entry) const {
    if (entry.exists) return entry.workspace;
    context_.console->Begin("undistortion by colmap");
    PrepareWorkspaceOptions prepare;
    prepare.image_folder = options_.image_path;
    prepare.skip_missing_images = options_.stage.skip_missing_images;
    const DenseWorkspace workspace =
        PrepareDenseWorkspace(entry, ColmapRunner(), prepare, context_.run);
    context_.console->End(workspace.folder.string());
    return workspace;
  }

  // Folder of the masks of the workspace's images.
  std::filesystem::path Masks(const WorkspaceEntry& entry) const {
    const MaskOptions masks{options_.stage.mask_path, options_.stage.alpha_is_mask};
    return PrepareMasks(entry, masks, ColmapRunner(), context_.run);
  }

  void WriteReport(const DenseWorkspace& workspace) const {
    MeshComparisonOptions comparison;
    comparison.workspace_path = workspace.folder.string();
    CompareMeshes(comparison, context_);
  }

  const ProjectReconstructionOptions& options_;
  const CommandContext& context_;
  ReconstructionOptions reconstruction_;
};

}  // namespace

void ProjectReconstructionOptions::Describe(OptionSet* options) {
  options->Add("workspace_path", &stage.workspace_path,
               "The workspace; may be given without the name of the option.");
  options->Add("image_path", &image_path,
               "Folder of the photos of a project that do not lie in its images/.");
  options->AddEnum("quality", &quality,
                   "As COLMAP's: photos are reduced to 1000, 1600 or 2400 pixels or taken as "
                   "they are; the lower two take fewer "
                   "iterations, and low takes its points from quasi_dense_matcher.",
                   {{"low", Quality::kLow},
                    {"medium", Quality::kMedium},
                    {"high", Quality::kHigh},
                    {"extreme", Quality::kExtreme}});
  options->AddEnum(
      "point_source", &point_source,
      "How points come from photos: patch_match by depth maps and their fusion; "
      "quasi_dense by interest points, in about a quarter of the time and with "
      "an eighth of the points; auto: quasi_dense with --quality low, else patch_match.",
      {{"auto", std::nullopt},
       {"patch_match", PointSource::kPatchMatch},
       {"quasi_dense", PointSource::kQuasiDense}});
  options->Add("max_image_size", &max_image_size,
               "Longer side in pixels to which photos are reduced, instead of what --quality "
               "says; -1 takes them as they "
               "are. Time and memory go with its square.",
               {-1, 1000000});
  options->Add("mask_path", &stage.mask_path,
               "Folder with masks: of photo a/b.jpg it is a/b.jpg.png or a/b.png; black pixels "
               "are not used. Masks of a project are those of its photos, as given to COLMAP's "
               "--ImageReader.mask_path, and are undistorted with them; masks of a dense "
               "workspace are those of its undistorted images.");
  stage.DescribeAlphaMask(options);
  stage.DescribeSkipMissingImages(options);
  stage.DescribeBoundingBox(options);
  stage.DescribeDatabasePath(options);
  options->AddEnum("from", &from,
                   "First stage; what earlier stages make must be there and is used as it is.",
                   StageNames("first"));
  options->AddEnum("to", &to, "Last stage; last is mesh_refiner, or mesh_texturer with --texture.",
                   StageNames("last"));
  options->Add("texture", &texture,
               "Texture the refined mesh with the photos, as --to mesh_texturer does.");
  stage.DescribeRun(options);
  stage.DescribeScratch(options);
  stage.DescribeMaps(false, options);
  options->Add("report", &report,
               "End with a page that shows the meshes beside COLMAP's, those that are there: "
               "lsmvs/report/index.html (see lsmvs mesh_comparer).");
  options->MarkRare({"image_path", "point_source", "bounding_box"});
  reconstruction.Describe(options);
}

void ProjectReconstructionOptions::ApplyPresets() {
  ApplyQuality(quality, &reconstruction);
  reconstruction.point_source = point_source.value_or(reconstruction.point_source);
}

void ReconstructProject(const ProjectReconstructionOptions& options,
                        const CommandContext& context) {
  ProjectReconstruction(options, context).Run();
}

}  // namespace lsmvs
