#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"
#include "lsmvs/colmap_adapter/cloud_inputs.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

enum class CloudKind { kDense, kSparse };

class VisibilityMesherCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {
        "visibility_mesher",
        "Point cloud with visibility -> mesh",
        "Makes the surface that agrees with what each view saw, as COLMAP's delaunay_mesher "
        "does: a minimum cut of a Delaunay "
        "tetrahedralisation. Reads fused.ply and fused.ply.vis of a dense workspace (or with "
        "--input_type sparse the points "
        "of its sparse model) and writes a triangle mesh with colours and normals, and "
        "beside it OUTPUT.vis: the views of each vertex, in the format of fused.ply.vis. The "
        "photos need not be there.\n"
        "With several --input_path, workspaces or clouds whose models are in one frame (two "
        "flights, sub-models of one project), the clouds are meshed as if they were one. Their "
        "order does not matter; clouds of one model share its photos, and a photo that two models "
        "have counts twice. What is kept of the "
        "run goes to lsmvs/ beside OUTPUT; the run prints which numbers in OUTPUT.vis the "
        "photos of each input have.",
        {"lsmvs visibility_mesher --input_path project/dense/0 --output_path "
         "project/dense/0/meshed-visibility.ply",
         "lsmvs visibility_mesher --input_type sparse --input_path project/sparse/0 "
         "--output_path project/meshed-sparse.ply",
         "lsmvs visibility_mesher --input_path flight_1/dense/0 --input_path flight_2/dense/0 "
         "--output_path both.ply"},
        {"input_path", "output_path"},
        "input_path",
        {"log_to_stderr"}};
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &input_paths_,
                 "Dense workspace that holds fused.ply and fused.ply.vis, or another cloud (PLY, "
                 "with PLY.vis) in such a folder; with --input_type sparse the sparse model's "
                 "folder, as COLMAP's, or the workspace or project.");
    options->AddEnum("input_type", &input_type_,
                     "Points to mesh: the fused cloud or the sparse model's.",
                     {{"dense", CloudKind::kDense}, {"sparse", CloudKind::kSparse}});
    options->Add("output_path", &output_path_, "The mesh to write (PLY).");
    options->Add("filtered_cloud_path", &filtered_cloud_path_,
                 "Also write the fused cloud without the points that the surface leaves in free "
                 "space (outliers that the views contradict) to this PLY and PLY.vis.");
    stage_.DescribeBoundingBox(options);
    stage_.DescribeRun(options);
    stage_.DescribeScratch(options);
    options_.surface.Describe(options);
  }

  void Run(const CommandContext& context) override {
    stage_.Apply(&options_);
    if (Sparse() && !filtered_cloud_path_.empty()) {
      throw UsageError("--filtered_cloud_path goes with --input_type dense only");
    }
    if (input_paths_.size() > 1) {
      MeshSeveral(context);
    } else {
      MeshOne(context);
    }
  }

 private:
  bool Sparse() const { return input_type_ == CloudKind::kSparse; }
  PhotoUse Photos() const { return Sparse() ? PhotoUse::kNoCamera : PhotoUse::kNothing; }

  void MeshOne(const CommandContext& context) {
    const CloudInput input = FindCloudInput(input_paths_.front());
    stage_.workspace_path = input.workspace.folder.string();
    const auto reconstruction =
        OpenReconstruction(input.workspace, stage_, options_, context, Photos());
    RunTask(reconstruction, input, input.workspace, context);
  }

  void MeshSeveral(const CommandContext& context) {
    if (!filtered_cloud_path_.empty()) {
      throw UsageError("--filtered_cloud_path goes with one --input_path only");
    }
    const std::vector<CloudInput> inputs = FindCloudInputs(input_paths_, Sparse());
    const std::filesystem::path folder = std::filesystem::path(output_path_).parent_path();
    const DenseWorkspace output{folder.empty() ? std::filesystem::path(".") : folder};
    const auto reconstruction =
        OpenJoinedReconstruction(output, inputs, options_, context, Photos());
    RunTask(reconstruction, inputs.front(), output, context);
  }

  void RunTask(const ReconstructionPtr& reconstruction, const CloudInput& input,
               const DenseWorkspace& workspace, const CommandContext& context) {
    Task task =
        Sparse() ? MakeSparseSurfaceTask(reconstruction, output_path_)
                 : MakeSurfaceTask(reconstruction, input.cloud, output_path_, filtered_cloud_path_);
    RenameForOutput(workspace.VisibilityMeshPath(), &task);
    RunPlanned(workspace, *reconstruction, {task}, stage_, context);
  }

  StageOptions stage_;
  CloudKind input_type_ = CloudKind::kDense;
  std::vector<std::string> input_paths_;
  std::string output_path_, filtered_cloud_path_;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeVisibilityMesherCommand() {
  return std::make_unique<VisibilityMesherCommand>();
}

}  // namespace lsmvs
