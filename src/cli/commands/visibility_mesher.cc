#include <memory>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

enum class CloudKind { kDense, kSparse };

class VisibilityMesherCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {"visibility_mesher",
            "Point cloud with visibility -> mesh",
            "Makes the surface that agrees with what each view saw, as COLMAP's delaunay_mesher "
            "does: a minimum cut of a Delaunay "
            "tetrahedralisation. Reads fused.ply and fused.ply.vis of a dense workspace (or with "
            "--input_type sparse the points "
            "of its sparse model) and writes a triangle mesh with colours and normals, and "
            "beside it OUTPUT.vis: the views of each vertex, in the format of fused.ply.vis. The "
            "photos need not be there.",
            {"lsmvs visibility_mesher --input_path project/dense/0 --output_path "
             "project/dense/0/meshed-visibility.ply",
             "lsmvs visibility_mesher --input_type sparse --input_path project/sparse/0 "
             "--output_path project/meshed-sparse.ply"},
            {"input_path", "output_path"},
            "input_path",
            {"log_to_stderr"}};
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &stage_.workspace_path,
                 "Dense workspace that holds fused.ply and fused.ply.vis; with --input_type sparse "
                 "the sparse model's folder, as COLMAP's, or the workspace or project.");
    options->AddEnum("input_type", &input_type_,
                     "Points to mesh: the fused cloud or the sparse model's.",
                     {{"dense", CloudKind::kDense}, {"sparse", CloudKind::kSparse}});
    options->Add("output_path", &output_path_, "The mesh to write (PLY).");
    options->Add("filtered_cloud_path", &filtered_cloud_path_,
                 "Also write the fused cloud without the points that the surface leaves in free "
                 "space (outliers that the views contradict) to this PLY and PLY.vis.");
    stage_.DescribeBoundingBox(options);
    stage_.DescribeOverwrite(options);
    stage_.DescribeScratch(options);
    options_.surface.Describe(options);
  }

  void Run(const CommandContext& context) override {
    stage_.Apply(&options_);
    const DenseWorkspace workspace = stage_.Workspace();
    const bool sparse = input_type_ == CloudKind::kSparse;
    if (sparse && !filtered_cloud_path_.empty()) {
      throw UsageError("--filtered_cloud_path goes with --input_type dense only");
    }
    const auto reconstruction = OpenReconstruction(
        workspace, stage_, options_, context, sparse ? PhotoUse::kNoCamera : PhotoUse::kNothing);
    Task task = sparse ? MakeSparseSurfaceTask(reconstruction, output_path_)
                       : MakeSurfaceTask(reconstruction, workspace.FusedPath(), output_path_,
                                         filtered_cloud_path_);
    RenameForOutput(workspace.VisibilityMeshPath(), &task);
    RunPlanned(workspace, *reconstruction, {task}, stage_, context);
  }

 private:
  StageOptions stage_;
  CloudKind input_type_ = CloudKind::kDense;
  std::string output_path_, filtered_cloud_path_;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeVisibilityMesherCommand() {
  return std::make_unique<VisibilityMesherCommand>();
}

}  // namespace lsmvs
