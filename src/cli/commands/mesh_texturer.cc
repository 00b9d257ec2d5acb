#include <memory>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"

namespace lsmvs {

namespace {

// COLMAP's --output_type. Other formats are lsmvs mesh_exporter's.
enum class TexturedFormat { kPly };

class MeshTexturerCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {
        "mesh_texturer",
        "Mesh + photos -> textured mesh",
        "Gives each face the photo that shows it best, with as few and as faint seams as a "
        "graph cut finds; balances exposure, leaves out who walked by, levels and fades what "
        "is left at seams. Texels are copied pixels: nothing is shifted, blurred or "
        "sharpened.\n"
        "Writes mesh.ply and its pages texture.png, texture_1.png, ... to the folder "
        "--output_path. The PLY is COLMAP's and MeshLab's dialect; lsmvs mesh_exporter turns "
        "it into OBJ, GLB and 3D Tiles. Any PLY mesh in the coordinates of the workspace will "
        "do, COLMAP's too; its surface stays as it is, but wide faces are split.",
        {"lsmvs mesh_texturer --workspace_path project/dense/0 --input_path "
         "project/dense/0/meshed-refined.ply --output_path project/dense/0/textured",
         "lsmvs mesh_texturer --workspace_path dense/0 --input_path dense/0/meshed-poisson.ply "
         "--output_path poisson --MeshTextureMapping.texture_scale_factor 0.5"},
        {"workspace_path", "input_path", "output_path"},
        "workspace_path",
        {"MeshTextureMapping.min_cos_normal_angle", "MeshTextureMapping.min_visible_vertices",
         "MeshTextureMapping.view_selection_smoothing_iterations",
         "MeshTextureMapping.inpaint_radius", "MeshTextureMapping.color_correction_regularization",
         "MeshTextureMapping.num_threads"}};
  }

  void Describe(OptionSet* options) override {
    stage_.DescribeWorkspace(options);
    options->Add("input_path", &input_path_, "The mesh to texture (PLY).");
    options->Add("output_path", &output_path_,
                 "Folder for mesh.ply and its pages; made if it is missing.");
    options->AddEnum("output_type", &format_, "Format of the textured mesh.",
                     {{"PLY", TexturedFormat::kPly}});
    stage_.DescribeMeshStage(options);
    options_.texturing.Describe(options);
  }

  void Run(const CommandContext& context) override {
    stage_.Apply(&options_);
    const DenseWorkspace workspace = stage_.Workspace();
    const auto reconstruction = OpenReconstruction(workspace, stage_, options_, context);
    Task task = MakeTexturingTask(reconstruction, input_path_,
                                  std::filesystem::path(output_path_) / "mesh.ply");
    RenameForOutput(workspace.TexturedMeshPath(), &task);
    RunPlanned(workspace, *reconstruction, {task}, stage_, context);
  }

 private:
  StageOptions stage_;
  std::string input_path_, output_path_;
  TexturedFormat format_ = TexturedFormat::kPly;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeMeshTexturerCommand() {
  return std::make_unique<MeshTexturerCommand>();
}

}  // namespace lsmvs
