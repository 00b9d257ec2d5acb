#include "lsmvs/workflow/single_stages.h"

#include <filesystem>

#include "lsmvs/workflow/planning/run_reconstruction.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

ReconstructionPtr Open(const StageOptions& stage, const ReconstructionOptions& given,
                       const CommandContext& context) {
  ReconstructionOptions options = given;
  stage.Apply(&options);
  return OpenReconstruction(stage.Workspace(), stage, options, context);
}

// For a cloud whose path the user names: nothing that others made is taken in its place.
Task RefuseForeign(Task task) {
  task.foreign_outputs = ForeignOutputs::kRefuse;
  return task;
}

void DescribeInputMesh(const char* verb, std::string* input_path, OptionSet* options) {
  options->Add("input_path", input_path, std::string("The mesh to ") + verb + " (PLY).");
}

void DescribeCloudPath(std::string* output_path, OptionSet* options) {
  options->Add("output_path", output_path, "The cloud to write, such as WORKSPACE/fused.ply.");
}

}  // namespace

void PatchMatchStereoRun::Describe(OptionSet* options) {
  stage.DescribeWorkspace(options);
  stage.DescribeMaskPath(options);
  stage.DescribeAlphaMask(options);
  stage.DescribeSourcesPath(options);
  stage.DescribeSkipMissingImages(options);
  stage.DescribeRun(options);
  stage.DescribeMaps(true, options);
  stage.DescribeMaxImageSize("PatchMatchStereo.max_image_size", options);
  reconstruction.patch_match.Describe(options);
  reconstruction.view_selection.Describe(options);
}

void RunPatchMatchStereo(const PatchMatchStereoRun& options, const CommandContext& context) {
  const auto reconstruction = Open(options.stage, options.reconstruction, context);
  RunPlanned(options.stage.Workspace(), *reconstruction, MakeStereoTasks(reconstruction),
             options.stage, context);
}

void StereoFusionRun::Describe(OptionSet* options) {
  stage.DescribeWorkspace(options);
  options->AddEnum(
      "input_type", &input_type, "Which of the depth maps to fuse.",
      {{"geometric", DepthMapKind::kGeometric}, {"photometric", DepthMapKind::kPhotometric}});
  DescribeCloudPath(&output_path, options);
  options->AddEnum("output_type", &output_type, "Format of the cloud.", {{"PLY", PlyOnly::kPly}});
  stage.DescribeBoundingBox(options);
  stage.DescribeBoxPath(options);
  stage.DescribeAlphaMask(options);
  stage.DescribeSkipMissingImages(options);
  stage.DescribeRun(options);
  options->Add("StereoFusion.mask_path", &stage.mask_path,
               "Folder with masks: of image a/b.jpg it is a/b.jpg.png; black pixels are not used.");
  stage.DescribeMaxImageSize("StereoFusion.max_image_size", options);
  reconstruction.fusion.Describe(options);
  reconstruction.view_selection.Describe(options);
}

void RunStereoFusion(const StereoFusionRun& options, const CommandContext& context) {
  const DenseWorkspace workspace = options.stage.Workspace();
  const auto reconstruction = Open(options.stage, options.reconstruction, context);
  std::vector<Task> tasks = MakeFusionTasks(reconstruction, options.input_type,
                                            MapsToFuse::kPresent, options.output_path);
  tasks.back() = RefuseForeign(std::move(tasks.back()));
  RunPlannedTasks(workspace, *reconstruction, std::move(tasks), workspace.FusedPath(),
                  options.stage, context);
}

void QuasiDenseRun::Describe(OptionSet* options) {
  stage.DescribeWorkspace(options);
  DescribeCloudPath(&output_path, options);
  stage.DescribeMaskPath(options);
  stage.DescribeAlphaMask(options);
  stage.DescribeSourcesPath(options);
  stage.DescribeSkipMissingImages(options);
  stage.DescribeDatabasePath(options);
  stage.DescribeBoundingBox(options);
  stage.DescribeRun(options);
  stage.DescribeMaxImageSize("max_image_size", options);
  reconstruction.quasi_dense.Describe(options);
  reconstruction.view_selection.Describe(options);
}

void RunQuasiDenseMatcher(const QuasiDenseRun& options, const CommandContext& context) {
  const DenseWorkspace workspace = options.stage.Workspace();
  const auto reconstruction = Open(options.stage, options.reconstruction, context);
  const Task task = RefuseForeign(MakeQuasiDenseTask(reconstruction, options.output_path));
  RunPlannedTask(workspace, *reconstruction, task, workspace.FusedPath(), options.stage, context);
}

void MeshRefinementRun::Describe(OptionSet* options) {
  stage.DescribeWorkspace(options);
  DescribeInputMesh("refine", &input_path, options);
  options->Add("output_path", &output_path, "The mesh to write (PLY).");
  stage.DescribeMeshStage(options);
  reconstruction.refinement.Describe(options);
}

void RunMeshRefiner(const MeshRefinementRun& options, const CommandContext& context) {
  const DenseWorkspace workspace = options.stage.Workspace();
  const auto reconstruction = Open(options.stage, options.reconstruction, context);
  const Task task = MakeRefinementTask(reconstruction, options.input_path, options.output_path);
  RunPlannedTask(workspace, *reconstruction, task, workspace.RefinedMeshPath(), options.stage,
                 context);
}

void MeshTexturingRun::Describe(OptionSet* options) {
  stage.DescribeWorkspace(options);
  DescribeInputMesh("texture", &input_path, options);
  options->Add("output_path", &output_path,
               "Folder for mesh.ply and its pages; made if it is missing.");
  options->AddEnum("output_type", &output_type, "Format of the textured mesh.",
                   {{"PLY", PlyOnly::kPly}});
  stage.DescribeMeshStage(options);
  reconstruction.texturing.Describe(options);
}

void RunMeshTexturer(const MeshTexturingRun& options, const CommandContext& context) {
  const DenseWorkspace workspace = options.stage.Workspace();
  const auto reconstruction = Open(options.stage, options.reconstruction, context);
  const Task task = MakeTexturingTask(reconstruction, options.input_path,
                                      fs::path(options.output_path) / "mesh.ply");
  RunPlannedTask(workspace, *reconstruction, task, workspace.TexturedMeshPath(), options.stage,
                 context);
}

}  // namespace lsmvs
