#include "lsmvs/workflow/evaluate_mesh.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/evaluation/error_colors.h"
#include "lsmvs/evaluation/measure_mesh.h"
#include "lsmvs/evaluation/viewpoints.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/valid_options.h"
#include "lsmvs/workflow/files/mesh_memory.h"
#include "lsmvs/workflow/files/output_check.h"
#include "lsmvs/workflow/files/scene_input.h"

namespace lsmvs {

namespace {

class MeshEvaluation {
 public:
  MeshEvaluation(const MeshEvaluationOptions& options, const CommandContext& context)
      : options_(options), context_(context) {
    if (options_.workspace_path.empty() && IsPmvsFolder(options_.input_path)) {
      options_.workspace_path = options_.input_path;
    }
    CheckOptions();
  }

  void Run() {
    const MeshMemory memory("mesh_evaluator", {options_.input_path, options_.ground_truth_path},
                            kTracedMeshMemory, options_.scratch_path, context_);
    scene_ = LoadSceneIfGiven(options_.workspace_path, Photometric() || options_.texture);
    CheckOutputs();
    offset_ = WorldOffset(scene_);
    if (scene_) views_ = scene_->views;
    ReadInput();
    figures_.name = options_.input_path;
    if (mesh_.faces.empty()) {
      MeasurePoints();
    } else {
      figures_.inspection = Inspect(mesh_);
      tracer_ = std::make_unique<MeshTracer>(mesh_, context_.run);
    }
    if (tracer_ && scene_) {
      figures_.silhouettes = MeasureSilhouettes(*tracer_, mesh_, views_, context_.run);
    }
    // Before errors take the place of the mesh's colours.
    if (options_.texture) ScoreTexture();
    if (!options_.ground_truth_path.empty()) CompareWithTruth();
    if (Photometric() && (options_.photometric || !figures_.cloud)) CompareWithPhotos();
    WriteResults();
  }

 private:
  bool Photometric() const {
    return options_.photometric || (options_.ground_truth_path.empty() && !options_.texture);
  }

  void CheckOptions() const {
    RequireValid(options_);
    if (!options_.workspace_path.empty()) return;
    if (options_.texture) throw UsageError("--texture needs --workspace_path");
    if (options_.ground_truth_path.empty()) {
      throw UsageError("give --ground_truth_path, --workspace_path or both; see --help");
    }
    if (options_.photometric) throw UsageError("--photometric needs --workspace_path");
  }

  void CheckOutputs() const {
    std::vector<std::string> inputs = {options_.ground_truth_path,
                                       scene_ ? scene_->image_folder : std::string()};
    for (const auto& file : PmvsFiles(options_.input_path)) inputs.push_back(file.string());
    for (const std::string& output : {options_.json_path, options_.error_path}) {
      RefuseToReplaceInputs(output, inputs);
    }
  }

  // The texture is only looked for where it is asked for.
  void ReadInput() {
    const std::string& path = options_.input_path;
    if (IsPmvsResult(path)) {
      if (options_.texture) {
        throw InputError(path, "holds points of PMVS", "--texture needs a mesh");
      }
      PmvsCloud cloud = ReadPmvsCloud(path, offset_);
      mesh_ = std::move(cloud.points);
      num_views_ = std::move(cloud.num_views);
      scores_ = std::move(cloud.scores);
      return;
    }
    if (!options_.texture) {
      mesh_ = ReadMeshPly(path, offset_, NotFinite::kKeep);
      return;
    }
    textured_ = ReadTexturedPly(path, offset_, NotFinite::kKeep);
    if (mesh_.faces.empty()) throw InputError(path, "has no faces", "--texture needs a mesh");
    if (!textured_.has_texture() && mesh_.vertex_colors.empty()) {
      throw InputError(path, "has neither texture nor vertex colours",
                       "give a mesh with one of them, or leave out --texture");
    }
  }

  void MeasurePoints() {
    if (mesh_.vertices.empty() && options_.ground_truth_path.empty()) {
      throw InputError(options_.input_path, "has no points", "give a mesh or a cloud");
    }
    figures_.cloud = MeasureCloud(mesh_.vertices, num_views_, scores_, views_, context_.run);
  }

  std::vector<int> ScoredViews() const {
    const std::vector<int> named = FindViews(*scene_, options_.view_names);
    if (!named.empty() || options_.view_step == 1) return named;
    const std::vector<int> order = ViewsByName(views_);
    std::vector<int> scored;
    for (size_t i = 0; i < order.size(); i += static_cast<size_t>(options_.view_step)) {
      scored.push_back(order[i]);
    }
    return scored;
  }

  void CompareWithTruth() {
    const TriangleMesh truth = ReadMeshPly(options_.ground_truth_path, offset_, NotFinite::kKeep);
    if (truth.vertices.empty()) {
      throw InputError(options_.ground_truth_path, "has no points", "give a mesh or a cloud");
    }
    context_.console->Begin("Comparing with the ground truth");
    const SurfaceEvaluator evaluator(truth, views_, options_.surface, context_.run);
    MeasureAgainstTruth(evaluator, mesh_, tracer_.get(), views_, options_.depth,
                        context_.run.Part(0.2, 1), &figures_);
    if (!options_.error_path.empty()) {
      // Yellow is the largest threshold.
      const double largest = figures_.surface->thresholds.back() * evaluator.unit_in_world();
      mesh_.vertex_colors =
          ErrorColors(DistancesToTruth(evaluator, mesh_.vertices, context_.run), largest);
    }
    context_.console->End();
  }

  void CompareWithPhotos() {
    if (!tracer_) {
      throw InputError(options_.input_path, "has no faces, and photos are only seen through a mesh",
                       "give a mesh, or compare a cloud with --ground_truth_path");
    }
    context_.console->Begin("Comparing with the photos");
    const std::unique_ptr<ImageStore> images = MakeImageStore(*scene_, {});
    const bool color = !options_.error_path.empty() && options_.ground_truth_path.empty();
    figures_.photometric = MeasurePhotometricScore(*tracer_, mesh_, *scene_, *images, ScoredViews(),
                                                   color, options_.photo, context_.run);
    if (color) ColorByCorrelation(figures_.photometric->vertex_zncc);
    context_.console->End();
  }

  void ScoreTexture() {
    context_.console->Begin("Comparing colours with the photos");
    const std::unique_ptr<ImageStore> images = MakeImageStore(*scene_, {});
    std::optional<TexturePages> pages;
    if (textured_.has_texture()) pages.emplace(textured_, context_.run.memory_budget_bytes / 4);
    MeasureColors(*tracer_, mesh_, pages ? &*pages : nullptr, *scene_, *images, ScoredViews(),
                  options_.texture_score, context_.run, &figures_);
    context_.console->End();
  }

  // Yellow is no correlation.
  void ColorByCorrelation(const std::vector<float>& zncc) {
    std::vector<double> errors(zncc.size());
    std::transform(zncc.begin(), zncc.end(), errors.begin(), [](float z) { return 1.0 - z; });
    mesh_.vertex_colors = ErrorColors(errors, 1);
  }

  void WriteResults() const {
    if (!options_.error_path.empty()) WriteMeshPly(options_.error_path, mesh_, offset_);
    if (options_.json_path == "-") return context_.console->Print(ToJson(figures_));
    if (!options_.json_path.empty()) WriteFileAtomically(options_.json_path, ToJson(figures_));
    context_.console->Print(ToTable(figures_));
  }

  MeshEvaluationOptions options_;
  const CommandContext& context_;
  std::optional<Scene> scene_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  std::vector<View> views_;  // of the scene
  TexturedMesh textured_;    // its texture only with --texture
  TriangleMesh& mesh_ = textured_.mesh;
  // Of the points of a cloud of PMVS.
  std::vector<int> num_views_;
  std::vector<float> scores_;
  std::unique_ptr<MeshTracer> tracer_;
  MeshFigures figures_;
};

}  // namespace

void MeshEvaluationOptions::Describe(OptionSet* options) {
  options->Add("input_path", &input_path,
               "Mesh or cloud to score (PLY; PMVS: .patch, or its folder)");
  options->Add("ground_truth_path", &ground_truth_path, "True mesh or cloud (PLY)");
  options->Add("workspace_path", &workspace_path,
               "Workspace with the cameras and the photos, or a folder of PMVS");
  options->Add("photometric", &photometric, "Compare with the photos although there is a truth");
  options->AddCommaList(
      "view_names", &view_names,
      "Photos that are scored, separated by commas; without it all, or those of --view_step");
  options->Add(
      "view_step", &view_step,
      "Without --view_names: score every n-th photo in the order of their names, beginning "
      "with the first; 1 scores all",
      {1, 1000000});
  options->Add("texture", &texture, "Score the texture, or the vertex colours, against the photos");
  options->Add("json_path", &json_path,
               "File for the figures as JSON; '-' prints JSON in place of tables");
  options->Add(
      "error_path", &error_path,
      "File for the mesh with its errors as vertex colours (PLY): dark is right, yellow wrong");
  DescribeMeshScratch(&scratch_path, options);
  surface.Describe(options);
  depth.Describe(options);
  photo.Describe(options);
  texture_score.Describe(options);
}

bool MeshEvaluationOptions::Check(std::string* error) const {
  return surface.Check(error) && photo.Check(error) && CheckOptions(*this, error);
}

void EvaluateMesh(const MeshEvaluationOptions& options, const CommandContext& context) {
  MeshEvaluation(options, context).Run();
}

}  // namespace lsmvs
