#include "lsmvs/workflow/render_mesh.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "lsmvs/evaluation/viewpoints.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/error.h"
#include "lsmvs/workflow/files/mesh_memory.h"
#include "lsmvs/workflow/files/output_check.h"
#include "lsmvs/workflow/files/scene_input.h"

namespace lsmvs {

namespace {

class MeshPicture {
 public:
  MeshPicture(const MeshPictureOptions& options, const CommandContext& context)
      : options_(options), context_(context) {}

  void Run() {
    const MeshMemory memory("mesh_renderer", {options_.input_path}, kTracedMeshMemory,
                            options_.scratch_path, context_);
    scene_ = LoadSceneIfGiven(options_.workspace_path, false);
    if (!scene_ && !options_.view_name.empty())
      throw UsageError("--view_name needs --workspace_path");
    CheckOutput();
    const TexturedMesh textured =
        ReadTexturedPly(options_.input_path, WorldOffset(scene_), NotFinite::kKeep);
    const TriangleMesh& mesh = textured.mesh;
    if (mesh.faces.empty()) {
      throw InputError(options_.input_path, "has no faces", "clouds cannot be drawn; give a mesh");
    }
    context_.console->Begin("Drawing");
    const MeshTracer tracer(mesh, context_.run);
    std::optional<TexturePages> texture;
    if (textured.has_texture()) texture.emplace(textured, context_.run.memory_budget_bytes / 2);
    const std::vector<PosedCamera> viewpoints = Viewpoints(mesh);
    for (size_t i = 0; i < viewpoints.size(); ++i) {
      const std::string path = FramePath(i, viewpoints.size());
      WritePng(path, RenderMesh(mesh, tracer, viewpoints[i], options_.render, context_.run,
                                texture ? &*texture : nullptr));
      context_.run.Report(static_cast<double>(i + 1) / static_cast<double>(viewpoints.size()));
    }
    context_.console->End();
    context_.console->Print(FramePath(0, viewpoints.size()) + "\n");
  }

 private:
  std::vector<PosedCamera> Viewpoints(const TriangleMesh& mesh) const {
    if (scene_ && !options_.turntable && options_.num_frames == 1) {
      const int view_idx = options_.view_name.empty()
                               ? MostRevealingView(*scene_)
                               : FindViews(*scene_, {options_.view_name}).front();
      return {ViewpointOf(scene_->views[view_idx], options_.width)};
    }
    const std::vector<Eigen::Vector3d> points = CentralVertices(mesh, scene_ ? *scene_ : Scene());
    TurntableOptions turntable =
        TurntableBefore(points, scene_ ? scene_->views : std::vector<View>());
    if (!options_.up.empty()) turntable.up = ParseDirection("up", options_.up);
    turntable.elevation_deg = options_.elevation;
    turntable.fit_share = options_.fit_share;
    turntable.width = options_.width;
    turntable.height = options_.height;
    std::vector<PosedCamera> viewpoints;
    for (int i = 0; i < options_.num_frames; ++i) {
      turntable.azimuth_deg = options_.azimuth + 360.0 * i / options_.num_frames;
      viewpoints.push_back(TurntableViewpoint(points, turntable));
    }
    return viewpoints;
  }

  void CheckOutput() const {
    if (std::filesystem::path(options_.output_path).extension() != ".png") {
      throw UsageError("--output_path " + options_.output_path +
                       ": pictures are PNG; give a name in .png");
    }
    for (int i = 0; i < options_.num_frames; ++i) {
      RefuseToReplaceInputs(
          FramePath(static_cast<size_t>(i), static_cast<size_t>(options_.num_frames)),
          {options_.input_path, scene_ ? scene_->image_folder : std::string()});
    }
  }

  std::string FramePath(size_t frame, size_t num_frames) const {
    if (num_frames == 1) return options_.output_path;
    std::filesystem::path path(options_.output_path);
    path.replace_filename(
        fmt::format("{}-{:03}{}", path.stem().string(), frame, path.extension().string()));
    return path.string();
  }

  const MeshPictureOptions& options_;
  const CommandContext& context_;
  std::optional<Scene> scene_;
};

}  // namespace

void MeshPictureOptions::Describe(OptionSet* options) {
  options->Add("input_path", &input_path, "Mesh to draw (PLY, with or without texture)");
  options->Add("output_path", &output_path, "Picture to write (PNG); replaced if it is there");
  options->Add("workspace_path", &workspace_path, "Workspace with the poses of the photos");
  options->Add("view_name", &view_name, "Photo whose pose is taken");
  options->Add("turntable", &turntable, "Use the turntable even with --workspace_path");
  options->Add("azimuth", &azimuth, "Angle of the turntable in degrees; 0 faces the photos",
               {-3600.0, 3600.0});
  options->Add("elevation", &elevation, "Height of the turntable's camera in degrees",
               {-90.0, 90.0});
  options->Add("up", &up,
               "Axis of the turntable as x,y,z; without it what is up in the photos, or 0,-1,0");
  options->Add(
      "fit_share", &fit_share,
      "Share of the vertices that a turntable picture must show; lower values ignore outliers",
      {0.01, 1.0});
  options->Add("num_frames", &num_frames, "Number of pictures of a full turn", {1, 10000});
  options->Add("width", &width, "Width of the picture in pixels", {1, 16384});
  options->Add(
      "height", &height,
      "Height of a turntable picture in pixels; for the pose of a photo it follows from its camera",
      {1, 16384});
  DescribeMeshScratch(&scratch_path, options);
  render.Describe(options);
}

void DrawMesh(const MeshPictureOptions& options, const CommandContext& context) {
  MeshPicture(options, context).Run();
}

}  // namespace lsmvs
