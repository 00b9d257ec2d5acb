#include <memory>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/run_reconstruction.h"
#include "lsmvs/cli/stage_options.h"

namespace lsmvs {

namespace {

class MeshRefinerCommand : public Command {
 public:
  CommandInfo Info() const override {
    return {"mesh_refiner",
            "Mesh + photos -> refined mesh",
            "Moves the vertices of a mesh until the photos agree through it, and adapts the size "
            "of its triangles to what the photos "
            "resolve. Regions that would get worse keep their input; at the end faces that are not "
            "needed are saved. Any PLY mesh in the "
            "coordinates of the workspace will do, "
            "COLMAP's too. Writes a triangle mesh with vertex colours.",
            {"lsmvs mesh_refiner --workspace_path project/dense/0 --input_path "
             "project/dense/0/meshed-visibility.ply "
             "--output_path project/dense/0/meshed-refined.ply"},
            {"workspace_path", "input_path", "output_path"},
            "workspace_path"};
  }

  void Describe(OptionSet* options) override {
    stage_.DescribeWorkspace(options);
    options->Add("input_path", &input_path_, "The mesh to refine (PLY).");
    options->Add("output_path", &output_path_, "The mesh to write (PLY).");
    stage_.DescribeMeshStage(options);
    options_.refinement.Describe(options);
  }

  void Run(const CommandContext& context) override {
    stage_.Apply(&options_);
    const DenseWorkspace workspace = stage_.Workspace();
    const auto reconstruction = OpenReconstruction(workspace, stage_, options_, context);
    Task task = MakeRefinementTask(reconstruction, input_path_, output_path_);
    RenameForOutput(workspace.RefinedMeshPath(), &task);
    RunPlanned(workspace, *reconstruction, {task}, stage_, context);
  }

 private:
  StageOptions stage_;
  std::string input_path_, output_path_;
  ReconstructionOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeMeshRefinerCommand() { return std::make_unique<MeshRefinerCommand>(); }

}  // namespace lsmvs
