#include "lsmvs/workflow/mesh_clouds.h"

#include <filesystem>

#include "lsmvs/colmap_adapter/cloud_inputs.h"
#include "lsmvs/util/error.h"
#include "lsmvs/workflow/planning/run_reconstruction.h"

namespace lsmvs {

namespace {

bool IsSparse(const CloudMeshingRun& options) { return options.input_type == CloudKind::kSparse; }

PhotoUse Photos(const CloudMeshingRun& options) {
  return IsSparse(options) ? PhotoUse::kNoCamera : PhotoUse::kNothing;
}

void Check(const CloudMeshingRun& options) {
  if (options.filtered_cloud_path.empty()) return;
  if (IsSparse(options)) {
    throw UsageError("--filtered_cloud_path goes with --input_type dense only");
  }
  if (options.input_paths.size() > 1) {
    throw UsageError("--filtered_cloud_path goes with one --input_path only");
  }
}

void RunTask(const ReconstructionPtr& reconstruction, const CloudInput& input,
             const DenseWorkspace& workspace, const CloudMeshingRun& options,
             const CommandContext& context) {
  const Task task = IsSparse(options)
                        ? MakeSparseSurfaceTask(reconstruction, options.output_path)
                        : MakeSurfaceTask(reconstruction, input.cloud, options.output_path,
                                          options.filtered_cloud_path);
  RunPlannedTask(workspace, *reconstruction, task, workspace.VisibilityMeshPath(), options.stage,
                 context);
}

void MeshOne(const CloudMeshingRun& options, const ReconstructionOptions& applied,
             const CommandContext& context) {
  const CloudInput input = FindCloudInput(options.input_paths.front());
  const auto reconstruction =
      OpenReconstruction(input.workspace, options.stage, applied, context, Photos(options));
  RunTask(reconstruction, input, input.workspace, options, context);
}

void MeshSeveral(const CloudMeshingRun& options, const ReconstructionOptions& applied,
                 const CommandContext& context) {
  const std::vector<CloudInput> inputs = FindCloudInputs(options.input_paths, IsSparse(options));
  const std::filesystem::path folder = std::filesystem::path(options.output_path).parent_path();
  const DenseWorkspace output{folder.empty() ? std::filesystem::path(".") : folder};
  const auto reconstruction =
      OpenJoinedReconstruction(output, inputs, applied, context, Photos(options));
  RunTask(reconstruction, inputs.front(), output, options, context);
}

}  // namespace

void CloudMeshingRun::Describe(OptionSet* options) {
  options->Add("input_path", &input_paths,
               "Dense workspace that holds fused.ply and fused.ply.vis, or another cloud (PLY, "
               "with PLY.vis) in such a folder; with --input_type sparse the sparse model's "
               "folder, as COLMAP's, or the workspace or project.");
  options->AddEnum("input_type", &input_type,
                   "Points to mesh: the fused cloud or the sparse model's.",
                   {{"dense", CloudKind::kDense}, {"sparse", CloudKind::kSparse}});
  options->Add("output_path", &output_path, "The mesh to write (PLY).");
  options->Add("filtered_cloud_path", &filtered_cloud_path,
               "Also write the fused cloud without the points that the surface leaves in free "
               "space (outliers that the views contradict) to this PLY and PLY.vis.");
  stage.DescribeBoundingBox(options);
  stage.DescribeRun(options);
  stage.DescribeScratch(options);
  reconstruction.surface.Describe(options);
}

void MeshClouds(const CloudMeshingRun& options, const CommandContext& context) {
  Check(options);
  ReconstructionOptions applied = options.reconstruction;
  options.stage.Apply(&applied);
  (options.input_paths.size() > 1 ? MeshSeveral : MeshOne)(options, applied, context);
}

}  // namespace lsmvs
