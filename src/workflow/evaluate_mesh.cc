#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/commands/evaluation_input.h"
#include "lsmvs/cli/mesh_memory.h"
#include "lsmvs/cli/output_check.h"
#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/evaluation/error_colors.h"
#include "lsmvs/evaluation/evaluation_text.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr MeshMemoryModel kMemory = {.all = 150, .in_memory = 100};

class MeshEvaluator : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info;
    info.name = "mesh_evaluator";
    info.summary = "Score a mesh or a cloud against ground truth, or against the photos";
    info.details =
        "With --ground_truth_path: accuracy (share of the reconstruction near the truth), "
        "completeness (share of the truth near the reconstruction) and F1 at the thresholds, on "
        "points "
        "uniform over the area, and with --workspace_path only where at least two photos see the "
        "surface; then also the histogram of depth errors in every photo.\n"
        "Without ground truth, or with --photometric: every photo is compared with its neighbours "
        "warped through the mesh. Give --view_names with photos that the reconstruction has not "
        "seen "
        "for an honest score.\n"
        "With --texture: the mesh is drawn with its texture (or vertex colours) from the photos' "
        "poses and compared with the photos, after fitting a gain and a bias per photo: PSNR, "
        "SSIM, 1 - NCC. Of a texture also its seams and how well its pages are used. Compare "
        "textures on the same mesh, on photos that they were not made from: --view_names or "
        "--view_step.\n"
        "With --workspace_path also how torn the mesh looks from the photos' poses: holes, ragged "
        "rims, lumps.\n"
        "A file without faces is taken as a cloud; of clouds the number of points and the share of "
        "the photos that they cover are measured, too. Results of PMVS-2 are taken as it writes "
        "them: a .patch file (with its photos and scores), a .ply, or the folder pmvs/ that "
        "`colmap image_undistorter --output_type PMVS` prepared, whose cameras and photos then "
        "serve in "
        "place of a workspace. Nothing of the workspace is changed.";
    info.examples = {
        "lsmvs mesh_evaluator --input_path mesh.ply --ground_truth_path truth.ply --workspace_path "
        "dense",
        "lsmvs mesh_evaluator --input_path mesh.ply --workspace_path dense --json_path score.json",
        "lsmvs mesh_evaluator --input_path textured/mesh.ply --workspace_path dense --texture "
        "--view_step 8",
        "lsmvs mesh_evaluator --input_path pmvs --ground_truth_path truth.ply"};
    info.required = {"input_path"};
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &input_path_,
                 "Mesh or cloud to score (PLY; PMVS: .patch, or its folder)");
    options->Add("ground_truth_path", &ground_truth_path_, "True mesh or cloud (PLY)");
    options->Add("workspace_path", &workspace_path_,
                 "Workspace with the cameras and the photos; a folder of PMVS will do");
    options->Add("photometric", &photometric_, "Compare with the photos although there is a truth");
    options->Add(
        "view_names", &view_names_,
        "Photos that are scored, separated by commas; empty: all, or every --view_step-th");
    options->Add("view_step", &view_step_,
                 "Without --view_names: every how many photos, in the order of their names, one is "
                 "scored; the first is",
                 {1, 1000000});
    options->Add("texture", &texture_,
                 "Score texture or vertex colours on the photos, and the texture itself");
    options->Add("json_path", &json_path_, "Write the figures as JSON; '-' prints them instead");
    options->Add(
        "error_path", &error_path_,
        "Write the mesh with its errors as vertex colours, dark right, yellow wrong (PLY)");
    DescribeMeshScratch(&scratch_path_, options);
    surface_.Describe(options);
    depth_.Describe(options);
    photo_.Describe(options);
    texture_score_.Describe(options);
  }

  void Run(const CommandContext& context) override {
    if (workspace_path_.empty() && IsPmvsFolder(input_path_)) workspace_path_ = input_path_;
    CheckOptions();
    const MeshMemory memory("mesh_evaluator", {input_path_, ground_truth_path_}, kMemory,
                            scratch_path_, context);
    if (!workspace_path_.empty()) {
      scene_ = LoadSceneToEvaluate(workspace_path_, Photometric() || texture_);
    }
    std::vector<std::string> inputs = {ground_truth_path_,
                                       scene_ ? scene_->image_folder : std::string()};
    for (const fs::path& file : PmvsFiles(input_path_)) inputs.push_back(file.string());
    for (const std::string& output : {json_path_, error_path_}) {
      RefuseToReplaceInputs(output, inputs);
    }
    const Eigen::Vector3d offset = scene_ ? scene_->world_offset : Eigen::Vector3d::Zero();
    ReadInput(offset);
    figures_.name = input_path_;
    if (mesh_.faces.empty()) {
      if (mesh_.vertices.empty() && ground_truth_path_.empty()) {
        throw InputError(input_path_, "has no points", "give a mesh or a cloud");
      }
      const std::vector<View> views = scene_ ? scene_->views : std::vector<View>();
      figures_.cloud = MeasureCloud(mesh_.vertices, num_views_, scores_, views, context.run);
    }
    if (!mesh_.faces.empty()) figures_.inspection = Inspect(mesh_);
    if (!mesh_.faces.empty()) tracer_ = std::make_unique<MeshTracer>(mesh_, context.run);
    if (tracer_ && scene_) {
      figures_.silhouettes = MeasureSilhouettes(*tracer_, mesh_, scene_->views, context.run);
    }
    // Before errors take the place of the mesh's colours.
    if (texture_) ScoreTexture(context);
    if (!ground_truth_path_.empty()) {
      CompareWithTruth(ReadMeshPly(ground_truth_path_, offset, NotFinite::kKeep), context);
    }
    if (Photometric() && (photometric_ || !figures_.cloud)) CompareWithPhotos(context);
    WriteResults(offset);
  }

 private:
  bool Photometric() const { return photometric_ || (ground_truth_path_.empty() && !texture_); }

  // The texture is only looked for where it is asked for.
  void ReadInput(const Eigen::Vector3d& offset) {
    if (IsPmvsResult(input_path_)) {
      if (texture_) {
        throw InputError(input_path_, "holds points of PMVS", "--texture needs a mesh");
      }
      PmvsCloud cloud = ReadPmvsCloud(input_path_, offset);
      mesh_ = std::move(cloud.points);
      num_views_ = std::move(cloud.num_views);
      scores_ = std::move(cloud.scores);
      return;
    }
    if (!texture_) {
      mesh_ = ReadMeshPly(input_path_, offset, NotFinite::kKeep);
      return;
    }
    textured_ = ReadTexturedPly(input_path_, offset, NotFinite::kKeep);
    if (mesh_.faces.empty()) {
      throw InputError(input_path_, "has no faces", "--texture needs a mesh");
    }
    if (!textured_.has_texture() && mesh_.vertex_colors.empty()) {
      throw InputError(input_path_, "has neither texture nor vertex colours",
                       "give a mesh with one of them, or leave out --texture");
    }
  }

  std::vector<int> ScoredViews() const {
    const std::vector<int> named = FindViews(*scene_, view_names_);
    if (!named.empty() || view_step_ == 1) return named;
    std::vector<int> order(scene_->views.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      return scene_->views[static_cast<size_t>(a)].name <
             scene_->views[static_cast<size_t>(b)].name;
    });
    std::vector<int> scored;
    for (size_t i = 0; i < order.size(); i += static_cast<size_t>(view_step_)) {
      scored.push_back(order[i]);
    }
    return scored;
  }

  void CheckOptions() const {
    std::string error;
    if (!surface_.Check(&error) || !photo_.Check(&error) || !texture_score_.Check(&error)) {
      throw UsageError("--" + error);
    }
    if (texture_ && workspace_path_.empty()) {
      throw UsageError("--texture needs --workspace_path");
    }
    if (ground_truth_path_.empty() && workspace_path_.empty()) {
      throw UsageError("give --ground_truth_path, --workspace_path or both; see --help");
    }
    if (Photometric() && workspace_path_.empty()) {
      throw UsageError("--photometric needs --workspace_path");
    }
  }

  void CompareWithTruth(const TriangleMesh& truth, const CommandContext& context) {
    if (truth.vertices.empty()) {
      throw InputError(ground_truth_path_, "has no points", "give a mesh or a cloud");
    }
    context.console->Begin("Comparing with the ground truth");
    const std::vector<View> views = scene_ ? scene_->views : std::vector<View>();
    const SurfaceEvaluator evaluator(truth, views, surface_, context.run);
    const bool with_depth = tracer_ && evaluator.truth_tracer() != nullptr && !views.empty();
    figures_.surface =
        evaluator.Evaluate(mesh_, context.run.Part(0.2, with_depth ? 0.6 : 1), tracer_.get());
    if (with_depth) {
      figures_.depth_errors = MeasureDepthErrors(*tracer_, *evaluator.truth_tracer(), views, depth_,
                                                 context.run.Part(0.6, 1));
    }
    if (!error_path_.empty()) ColorByDistance(evaluator, context.run);
    context.console->End();
  }

  void CompareWithPhotos(const CommandContext& context) {
    if (!tracer_) {
      throw InputError(input_path_, "has no faces, and photos are only seen through a mesh",
                       "give a mesh, or compare a cloud with --ground_truth_path");
    }
    context.console->Begin("Comparing with the photos");
    const std::unique_ptr<ImageStore> images = MakeImageStore(*scene_, {});
    const bool color = !error_path_.empty() && ground_truth_path_.empty();
    figures_.photometric = MeasurePhotometricScore(*tracer_, mesh_, *scene_, *images, ScoredViews(),
                                                   color, photo_, context.run);
    if (color) ColorByCorrelation(figures_.photometric->vertex_zncc);
    context.console->End();
  }

  void ScoreTexture(const CommandContext& context) {
    context.console->Begin("Comparing colours with the photos");
    const std::unique_ptr<ImageStore> images = MakeImageStore(*scene_, {});
    std::optional<TexturePages> pages;
    if (textured_.has_texture()) {
      pages.emplace(textured_, context.run.memory_budget_bytes / 4);
      const SeamPhotos photos = {*tracer_, *scene_, *images};
      figures_.atlas = MeasureAtlas(*pages, &photos, context.run);
    }
    figures_.texture = MeasureTextureScore(*tracer_, mesh_, pages ? &*pages : nullptr, *scene_,
                                           *images, ScoredViews(), texture_score_, context.run);
    context.console->End();
  }

  // Yellow is the largest threshold.
  void ColorByDistance(const SurfaceEvaluator& evaluator, const RunContext& run) {
    std::vector<double> distances(mesh_.vertices.size());
    ParallelFor(run, distances.size(), 1024, [&](size_t v) {
      const Eigen::Vector3d& x = mesh_.vertices[v];
      distances[v] = x.allFinite() ? evaluator.DistanceToTruth(x) : NAN;
    });
    const double largest = figures_.surface->thresholds.back() * evaluator.unit_in_world();
    mesh_.vertex_colors = ErrorColors(distances, largest);
  }

  // Yellow is no correlation.
  void ColorByCorrelation(const std::vector<float>& zncc) {
    std::vector<double> errors(zncc.size());
    std::transform(zncc.begin(), zncc.end(), errors.begin(), [](float z) { return 1.0 - z; });
    mesh_.vertex_colors = ErrorColors(errors, 1);
  }

  void WriteResults(const Eigen::Vector3d& offset) const {
    if (!error_path_.empty()) WriteMeshPly(error_path_, mesh_, offset);
    if (json_path_ == "-") {
      fmt::print("{}", ToJson(figures_));
      return;
    }
    if (!json_path_.empty()) WriteFileAtomically(json_path_, ToJson(figures_));
    fmt::print("{}", ToTable(figures_));
  }

  std::string scratch_path_, input_path_, ground_truth_path_, workspace_path_, view_names_,
      json_path_, error_path_;
  bool photometric_ = false, texture_ = false;
  int view_step_ = 1;
  SurfaceEvaluationOptions surface_;
  DepthErrorOptions depth_;
  PhotometricOptions photo_;
  TextureScoreOptions texture_score_;

  std::optional<Scene> scene_;
  TexturedMesh textured_;  // its texture only with --texture
  TriangleMesh& mesh_ = textured_.mesh;
  // Of the points of a cloud of PMVS.
  std::vector<int> num_views_;
  std::vector<float> scores_;
  std::unique_ptr<MeshTracer> tracer_;
  MeshFigures figures_;
};

}  // namespace

std::unique_ptr<Command> MakeMeshEvaluator() { return std::make_unique<MeshEvaluator>(); }

}  // namespace lsmvs
