#include "lsmvs/evaluation/mesh_renderer.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/commands/evaluation_input.h"
#include "lsmvs/cli/mesh_memory.h"
#include "lsmvs/cli/output_check.h"
#include "lsmvs/evaluation/viewpoints.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr MeshMemoryModel kMemory = {.all = 150, .in_memory = 100};

class MeshRendererCommand : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info;
    info.name = "mesh_renderer";
    info.summary = "Draw a mesh as PNG, from the pose of a photo or on a turntable";
    info.details =
        "Needs no display and no graphics card. With --workspace_path and without --view_name or "
        "--turntable the mesh is drawn from the photo that shows most sparse points; without a "
        "workspace it stands on a turntable.\n"
        "--num_frames above 1 turns the turntable: <output>-000.png and so on are written.";
    info.examples = {
        "lsmvs mesh_renderer --input_path mesh.ply --output_path mesh.png --workspace_path dense",
        "lsmvs mesh_renderer --input_path mesh.ply --output_path mesh.png --azimuth 30 --elevation "
        "25",
        "lsmvs mesh_renderer --input_path mesh.ply --output_path turn.png --num_frames 36 --style "
        "lit"};
    info.required = {"input_path", "output_path"};
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &input_path_, "Mesh to draw (PLY, with or without texture)");
    options->Add("output_path", &output_path_, "Picture to write (PNG); replaced if it is there");
    options->Add("workspace_path", &workspace_path_, "Workspace with the poses of the photos");
    options->Add("view_name", &view_name_, "Photo whose pose is taken");
    options->Add("turntable", &turntable_, "Use the turntable although there is a workspace");
    options->Add("azimuth", &azimuth_, "Angle of the turntable in degrees; 0 faces the photos",
                 {-3600.0, 3600.0});
    options->Add("elevation", &elevation_, "Height of the turntable's camera in degrees",
                 {-90.0, 90.0});
    options->Add("up", &up_, "Axis of the turntable as x,y,z; empty: up in the photos, or 0,-1,0");
    options->Add(
        "fit_share", &fit_share_,
        "Share of the vertices that the turntable's picture must hold; less ignores outliers",
        {0.01, 1.0});
    options->Add("num_frames", &num_frames_, "Pictures of a full turn", {1, 10000});
    options->Add("width", &width_, "Of the picture in pixels", {1, 16384});
    options->Add("height", &height_, "Of a turntable's picture in pixels", {1, 16384});
    DescribeMeshScratch(&scratch_path_, options);
    render_.Describe(options);
  }

  void Run(const CommandContext& context) override {
    const MeshMemory memory("mesh_renderer", {input_path_}, kMemory, scratch_path_, context);
    if (!workspace_path_.empty()) scene_ = LoadSceneToEvaluate(workspace_path_, false);
    if (!scene_ && !view_name_.empty()) throw UsageError("--view_name needs --workspace_path");
    CheckOutput();
    const Eigen::Vector3d offset = scene_ ? scene_->world_offset : Eigen::Vector3d::Zero();
    const TexturedMesh textured = ReadTexturedPly(input_path_, offset, NotFinite::kKeep);
    const TriangleMesh& mesh = textured.mesh;
    if (mesh.faces.empty()) {
      throw InputError(input_path_, "has no faces", "clouds cannot be drawn; give a mesh");
    }
    context.console->Begin("Drawing");
    const MeshTracer tracer(mesh, context.run);
    std::optional<TexturePages> texture;
    if (textured.has_texture()) texture.emplace(textured, context.run.memory_budget_bytes / 2);
    const std::vector<PosedCamera> viewpoints = Viewpoints(mesh);
    for (size_t i = 0; i < viewpoints.size(); ++i) {
      const std::string path = FramePath(i, viewpoints.size());
      WritePng(path, RenderMesh(mesh, tracer, viewpoints[i], render_, context.run,
                                texture ? &*texture : nullptr));
      context.run.Report(static_cast<double>(i + 1) / static_cast<double>(viewpoints.size()));
    }
    context.console->End();
    fmt::print("{}\n", FramePath(0, viewpoints.size()));
  }

 private:
  std::vector<PosedCamera> Viewpoints(const TriangleMesh& mesh) const {
    if (scene_ && !turntable_ && num_frames_ == 1) {
      const std::vector<int> named = FindViews(*scene_, view_name_);
      return {ViewpointOf(scene_->views[named.empty() ? MostRevealingView(*scene_) : named[0]],
                          width_)};
    }
    const std::vector<Eigen::Vector3d> points = CentralVertices(mesh, scene_ ? *scene_ : Scene());
    TurntableOptions options =
        TurntableBefore(points, scene_ ? scene_->views : std::vector<View>());
    if (!up_.empty()) options.up = ParseDirection("up", up_);
    options.elevation_deg = elevation_;
    options.fit_share = fit_share_;
    options.width = width_;
    options.height = height_;
    std::vector<PosedCamera> viewpoints;
    for (int i = 0; i < num_frames_; ++i) {
      options.azimuth_deg = azimuth_ + 360.0 * i / num_frames_;
      viewpoints.push_back(TurntableViewpoint(points, options));
    }
    return viewpoints;
  }

  void CheckOutput() const {
    if (std::filesystem::path(output_path_).extension() != ".png") {
      throw UsageError("--output_path " + output_path_ + ": pictures are PNG; give a name in .png");
    }
    for (int i = 0; i < num_frames_; ++i) {
      RefuseToReplaceInputs(FramePath(static_cast<size_t>(i), static_cast<size_t>(num_frames_)),
                            {input_path_, scene_ ? scene_->image_folder : std::string()});
    }
  }

  std::string FramePath(size_t frame, size_t num_frames) const {
    if (num_frames == 1) return output_path_;
    std::filesystem::path path(output_path_);
    path.replace_filename(
        fmt::format("{}-{:03}{}", path.stem().string(), frame, path.extension().string()));
    return path.string();
  }

  std::string scratch_path_, input_path_, output_path_, workspace_path_, view_name_, up_;
  bool turntable_ = false;
  double azimuth_ = 0, elevation_ = 20, fit_share_ = 0.98;
  int num_frames_ = 1, width_ = 1280, height_ = 960;
  RenderOptions render_;

  std::optional<Scene> scene_;
};

}  // namespace

std::unique_ptr<Command> MakeMeshRenderer() { return std::make_unique<MeshRendererCommand>(); }

}  // namespace lsmvs
