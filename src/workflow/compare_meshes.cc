#include "lsmvs/cli/commands/comparison.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include "lsmvs/cli/commands/colmap_meshers.h"
#include "lsmvs/cli/commands/evaluation_input.h"
#include "lsmvs/cli/mesh_memory.h"
#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/evaluation/error_colors.h"
#include "lsmvs/evaluation/viewpoints.h"
#include "lsmvs/execution/run_record.h"
#include "lsmvs/exporting/texture_transfer.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/program/version.h"
#include "lsmvs/report/report.h"
#include "lsmvs/texturing/vertex_colors.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

// As the evaluator, and what is simplified of it for the page; photos, pictures and the page.
constexpr MeshMemoryModel kMemory = {.all = 220, .in_memory = 100, .fixed = 110 << 20};
constexpr int kPhotoQuality = 82;
constexpr double kMaxTexels = 6e6;  // of a texture on the page

// A mesh, or a cloud of PMVS, that is compared.
struct Candidate {
  fs::path path;
  std::string title, origin;
};

std::vector<Candidate> FindMeshes(const DenseWorkspace& workspace, const std::string& further) {
  std::vector<Candidate> candidates = {
      {workspace.RefinedMeshPath(), "lsmvs refined", "visibility surface, refined on the photos"},
      {workspace.VisibilityMeshPath(), "lsmvs visibility", "visibility-consistent surface"}};
  for (const ColmapMesher& mesher : ColmapMeshers()) {
    candidates.push_back(
        {workspace.folder / mesher.file, mesher.title, "colmap " + mesher.command});
  }
  candidates.push_back({workspace.folder / "textured" / "mesh.ply", "textured", "mesh_texturer"});
  std::erase_if(candidates, [](const Candidate& c) { return !fs::exists(c.path); });
  const fs::path pmvs = workspace.folder / "pmvs";
  if (IsPmvsFolder(pmvs) && HasPmvsFiles(pmvs)) candidates.push_back({pmvs, "PMVS", "pmvs2"});
  std::istringstream stream(further);
  for (std::string path; std::getline(stream, path, ',');) {
    const std::string title = IsPmvsFolder(path) ? "PMVS" : fs::path(path).stem().string();
    candidates.push_back({path, title, "given"});
  }
  return candidates;
}

// "project, dense/0": a workspace says what it is about only together with its project.
std::string WorkspaceTitle(const fs::path& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  std::string inner;
  const auto is_number = [](const std::string& name) {
    return !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
  };
  while ((path.filename() == "dense" || is_number(path.filename().string())) &&
         path.has_relative_path() && path.parent_path().has_filename()) {
    inner = inner.empty() ? path.filename().string() : path.filename().string() + "/" + inner;
    path = path.parent_path();
  }
  const std::string name = path.filename().string();
  return inner.empty() ? name : name + ", " + inner;
}

std::string FileStem(const Candidate& candidate) { return candidate.path.stem().string(); }

// The runs that made our meshes, from the run's record.
class RunHistory {
 public:
  explicit RunHistory(const DenseWorkspace& workspace) {
    const fs::path path = workspace.RunRecordPath();
    if (!fs::exists(path)) return;
    const RunRecord record = ReadRunRecord(path, workspace.folder);
    for (const auto& [name, task] : record.tasks) Add(task);
  }

  // In the order in which they finished.
  std::vector<ReportStage> Stages() const {
    std::vector<std::pair<std::string, ReportStage>> sorted;
    for (const auto& [name, stage] : stages_) sorted.emplace_back(finished_.at(name), stage);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<ReportStage> stages;
    for (auto& [time, stage] : sorted) stages.push_back(std::move(stage));
    return stages;
  }
  const std::map<std::string, std::string>& options() const { return options_; }

  // Adds what the tasks that made the files took; a refined mesh also needs the one it began with.
  void AddCost(const std::vector<std::string>& files, ReportMesh* mesh) const {
    for (const std::string& file : files) {
      const auto found = by_output_.find(file);
      if (found == by_output_.end()) return;
      mesh->seconds = mesh->seconds.value_or(0) + found->second.seconds;
      mesh->peak_bytes = std::max(mesh->peak_bytes.value_or(0), found->second.peak_bytes);
    }
  }

 private:
  void Add(const TaskRecord& task) {
    ReportStage& stage = stages_[task.stage];
    stage.name = task.stage;
    stage.seconds += task.seconds;
    stage.peak_bytes = std::max(stage.peak_bytes.value_or(0), task.peak_bytes);
    finished_[task.stage] = std::max(finished_[task.stage], task.finished);
    for (const std::string& output : task.outputs) {
      by_output_[fs::path(output).filename().string()] = task;
    }
    std::istringstream lines(task.options);
    for (std::string line; std::getline(lines, line);) {
      const size_t split = line.find('=');
      if (split != std::string::npos) options_[line.substr(0, split)] = line.substr(split + 1);
    }
  }

  std::map<std::string, ReportStage> stages_;
  std::map<std::string, std::string> finished_, options_;
  std::map<std::string, TaskRecord> by_output_;
};

class Comparison {
 public:
  Comparison(const ComparisonOptions& options, const CommandContext& context)
      : options_(options),
        context_(context),
        workspace_(FindWorkspaceToEvaluate(options.workspace_path)),
        folder_(options.output_path.empty() ? workspace_.ReportFolder()
                                            : fs::path(options.output_path)),
        scene_(LoadScene(workspace_)) {}

  fs::path Run() {
    if (options_.run_colmap) {
      report_.missing = RunMissingMeshers(workspace_, UsagePath(), context_);
    } else {
      NoteMissingMeshers();
    }
    const std::vector<Candidate> candidates = FindMeshes(workspace_, options_.input_paths);
    if (candidates.empty()) {
      throw InputError(workspace_.folder.string(), "holds no mesh to compare",
                       "run lsmvs-mesher first, or give --run_colmap or --input_paths");
    }
    const MeshMemory memory("mesh_comparer", {Largest(candidates), options_.ground_truth_path},
                            kMemory, options_.scratch_path, context_);
    LoadTruth();
    images_ = MakeImageStore(scene_, {});
    key_photo_ = MostRevealingView(scene_);
    for (const Candidate& candidate : candidates) Add(candidate);
    DescribeRun();
    AddPhotos();
    return Write();
  }

 private:
  fs::path UsagePath() const { return folder_ / "colmap-meshers.json"; }

  void NoteMissingMeshers() {
    for (const ColmapMesher& mesher : ColmapMeshers()) {
      if (fs::exists(workspace_.folder / mesher.file)) continue;
      report_.missing.emplace_back(
          mesher.title, mesher.file + " is not there; --run_colmap makes it where COLMAP can");
    }
  }

  // One mesh after the other is held.
  static fs::path Largest(const std::vector<Candidate>& candidates) {
    const auto size = [](const Candidate& candidate) {
      std::error_code error;
      const auto bytes = fs::file_size(candidate.path, error);
      return error ? 0 : bytes;
    };
    return std::max_element(candidates.begin(), candidates.end(),
                            [&](const auto& a, const auto& b) { return size(a) < size(b); })
        ->path;
  }

  void LoadTruth() {
    report_.error_caption = "1 - correlation of the photos|0|1";
    if (options_.ground_truth_path.empty()) return;
    const TriangleMesh truth =
        ReadMeshPly(options_.ground_truth_path, scene_.world_offset, NotFinite::kKeep);
    evaluator_ =
        std::make_unique<SurfaceEvaluator>(truth, scene_.views, options_.surface, context_.run);
  }

  void Add(const Candidate& candidate) {
    context_.console->Begin("Measuring " + candidate.path.filename().string());
    if (IsPmvsResult(candidate.path)) {
      AddCloud(ReadPmvsCloud(candidate.path, scene_.world_offset), candidate);
    } else {
      const TexturedMesh textured =
          ReadTexturedPly(candidate.path, scene_.world_offset, NotFinite::kKeep);
      if (textured.mesh.faces.empty()) {
        AddCloud({{candidate.path}, textured.mesh, {}, {}}, candidate);
      } else {
        AddMesh(textured, candidate);
      }
    }
    context_.console->End();
  }

  void AddCloud(const PmvsCloud& cloud, const Candidate& candidate) {
    ReportCloud entry;
    entry.title = candidate.title;
    entry.origin = candidate.origin;
    entry.file = candidate.path.filename().string();
    for (const fs::path& file : cloud.files) entry.file_bytes += fs::file_size(file);
    entry.figures.name = entry.file;
    entry.figures.cloud = MeasureCloud(cloud.points.vertices, cloud.num_views, cloud.scores,
                                       scene_.views, context_.run);
    if (evaluator_) entry.figures.surface = evaluator_->Evaluate(cloud.points, context_.run);
    report_.clouds.push_back(std::move(entry));
  }

  void AddMesh(const TexturedMesh& textured, const Candidate& candidate) {
    ReportMesh entry;
    entry.title = candidate.title;
    entry.origin = candidate.origin;
    entry.file = candidate.path.filename().string();
    entry.file_bytes = fs::file_size(candidate.path);
    Measure(textured, candidate, &entry);
    SetCost(candidate, &entry);
    report_.meshes.push_back(std::move(entry));
  }

  void Measure(const TexturedMesh& textured, const Candidate& candidate, ReportMesh* entry) {
    const RunContext& run = context_.run;
    const TriangleMesh& mesh = textured.mesh;
    const MeshTracer tracer(mesh, run);
    entry->figures.name = entry->file;
    entry->figures.inspection = Inspect(mesh);
    entry->figures.silhouettes = MeasureSilhouettes(tracer, mesh, scene_.views, run.Part(0, 0.05));
    if (evaluator_) {
      entry->figures.surface = evaluator_->Evaluate(mesh, run.Part(0.05, 0.2), &tracer);
      if (const MeshTracer* truth = evaluator_->truth_tracer()) {
        entry->figures.depth_errors =
            MeasureDepthErrors(tracer, *truth, scene_.views, options_.depth, run.Part(0.2, 0.3));
      }
    }
    entry->figures.photometric = MeasurePhotometricScore(
        tracer, mesh, scene_, *images_, FindViews(scene_, options_.view_names),
        evaluator_ == nullptr, options_.photo, run.Part(0.3, 0.5));
    std::optional<TexturePages> pages;
    if (textured.has_texture()) pages.emplace(textured, run.memory_budget_bytes / 4);
    ScoreColors(mesh, tracer, pages ? &*pages : nullptr, run.Part(0.5, 0.6), entry);
    const SimplifiedMesh simplified =
        SimplifyMesh(mesh, static_cast<size_t>(options_.max_num_faces), run.Part(0.6, 0.75));
    entry->errors = Errors(simplified, *entry);
    entry->figures.photometric->vertex_zncc = {};
    entry->shown = simplified.mesh;
    if (pages) {
      ShowTexture(*pages, tracer, run, entry);
    } else if (entry->shown.vertex_colors.empty()) {
      ColorFromPhotos(run.Part(0.75, 0.8), entry);
    }
    entry->picture = FileStem(candidate) + ".png";
    WritePictures(mesh, tracer, pages ? &*pages : nullptr, *entry);
  }

  // How well texture or vertex colours show the photos.
  void ScoreColors(const TriangleMesh& mesh, const MeshTracer& tracer, const TexturePages* pages,
                   const RunContext& run, ReportMesh* entry) {
    if (pages != nullptr) {
      const SeamPhotos photos = {tracer, scene_, *images_};
      entry->figures.atlas = MeasureAtlas(*pages, &photos, run);
    }
    if (pages == nullptr && mesh.vertex_colors.empty()) return;
    TextureScoreOptions options;
    options.level = options_.photo.level;
    entry->figures.texture =
        MeasureTextureScore(tracer, mesh, pages, scene_, *images_,
                            FindViews(scene_, options_.view_names), options, run);
  }

  // The texture on the simplified mesh, on one page.
  void ShowTexture(const TexturePages& pages, const MeshTracer& tracer, const RunContext& run,
                   ReportMesh* entry) {
    TransferredTexture texture =
        TransferTexture(pages, tracer, entry->shown, kMaxTexels, run.Part(0.75, 0.8));
    entry->texcoords = std::move(texture.texcoords);
    entry->texture_size = {texture.page.width, texture.page.height};
    entry->texture_jpeg = EncodeJpeg(texture.page, kPhotoQuality);
    entry->shown.vertex_colors.clear();
  }

  // COLMAP's Delaunay mesher writes no colours; the page shows all meshes alike.
  void ColorFromPhotos(const RunContext& run, ReportMesh* entry) {
    VertexColorOptions coloring;
    coloring.level = 1;
    entry->shown.vertex_colors = ColorVertices(scene_, *images_, entry->shown, coloring, run);
    report_.notes.push_back(entry->file + " has no colours; the page takes them from the photos.");
  }

  // In [0, 1], a vertex of the simplified mesh each.
  std::vector<float> Errors(const SimplifiedMesh& simplified, const ReportMesh& entry) {
    std::vector<float> errors(simplified.mesh.vertices.size());
    if (evaluator_) {
      const SurfaceEvaluation& surface = *entry.figures.surface;
      const double largest = surface.thresholds.back() * surface.unit_in_world;
      report_.error_caption =
          fmt::format("Distance to the ground truth|0|{:g}{}", surface.thresholds.back(),
                      surface.gsd == surface.unit_in_world ? " GSD" : "");
      ParallelFor(context_.run, errors.size(), 1024, [&](size_t v) {
        errors[v] =
            static_cast<float>(evaluator_->DistanceToTruth(simplified.mesh.vertices[v]) / largest);
      });
      return errors;
    }
    const std::vector<float>& zncc = entry.figures.photometric->vertex_zncc;
    for (size_t v = 0; v < errors.size(); ++v) errors[v] = 1 - zncc[simplified.source_vertex[v]];
    return errors;
  }

  void WritePictures(const TriangleMesh& mesh, const MeshTracer& tracer, const TexturePages* pages,
                     const ReportMesh& entry) {
    const PosedCamera viewpoint = ViewpointOf(scene_.views[key_photo_], options_.picture_width);
    RenderOptions render;
    render.antialiasing = 2;
    WritePng(folder_ / entry.picture,
             RenderMesh(mesh, tracer, viewpoint, render, context_.run.Part(0.8, 0.9)));
    if (pages != nullptr) {
      render.style = RenderStyle::kColor;
      WritePng(folder_ / (fs::path(entry.picture).stem().string() + "-texture.png"),
               RenderMesh(mesh, tracer, viewpoint, render, context_.run.Part(0.8, 0.9), pages));
    }
    TriangleMesh colored = entry.shown;
    colored.vertex_colors =
        ErrorColors(std::vector<double>(entry.errors.begin(), entry.errors.end()), 1);
    render.style = RenderStyle::kLit;
    WritePng(folder_ / (fs::path(entry.picture).stem().string() + "-errors.png"),
             RenderMesh(colored, MeshTracer(colored, context_.run), viewpoint, render,
                        context_.run.Part(0.9, 1)));
  }

  void SetCost(const Candidate& candidate, ReportMesh* entry) {
    const std::map<std::string, ToolUsage> usage = ReadMesherUsage(workspace_, UsagePath());
    if (const auto found = usage.find(entry->file); found != usage.end()) {
      entry->seconds = found->second.seconds;
      entry->peak_bytes = found->second.peak_bytes;
      return;
    }
    const std::string first = workspace_.VisibilityMeshPath().filename().string();
    if (candidate.path == workspace_.VisibilityMeshPath()) history_.AddCost({first}, entry);
    if (candidate.path == workspace_.RefinedMeshPath()) {
      history_.AddCost({first, entry->file}, entry);
    }
  }

  void DescribeRun() {
    report_.program = VersionLine();
    report_.workspace = workspace_.folder.string();
    report_.title =
        options_.title.empty() ? "Meshes of " + WorkspaceTitle(workspace_.folder) : options_.title;
    report_.stages = history_.Stages();
    for (const auto& [name, value] : history_.options()) report_.options.emplace_back(name, value);
    if (report_.meshes.empty()) {
      throw InputError(workspace_.folder.string(), "holds no mesh with faces",
                       "give --input_paths");
    }
    const TriangleMesh& first = report_.meshes.front().shown;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : CentralVertices(first, scene_)) box.extend(x);
    report_.focus = box.center();
    report_.radius = std::max(0.5 * box.diagonal().norm(), 1e-9);
    report_.up = UpDirection(scene_.views);
    if (!options_.view_names.empty()) {
      report_.notes.push_back("The photos were compared in " + options_.view_names + " only.");
    }
  }

  // All poses, by name; pictures of as many as are wanted, evenly spread.
  void AddPhotos() {
    std::vector<int> order(scene_.views.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return scene_.views[a].name < scene_.views[b].name; });
    const size_t wanted = std::min(order.size(), static_cast<size_t>(options_.max_num_photos));
    for (size_t i = 0; i < order.size(); ++i) {
      const View& view = scene_.views[order[i]];
      ReportPhoto photo{view.name, {view.camera, view.cam_from_world}, {}};
      const bool chosen = (i + 1) * wanted / order.size() > i * wanted / order.size();
      if (order[i] == key_photo_) report_.key_photo = static_cast<int>(i);
      if (chosen || order[i] == key_photo_) photo.jpeg = SmallPhoto(order[i]);
      report_.photos.push_back(std::move(photo));
    }
    if (wanted < order.size()) {
      report_.notes.push_back(fmt::format(
          "The page holds {} of {} photos; the others have poses only.", wanted, order.size()));
    }
  }

  std::vector<uint8_t> SmallPhoto(int view_idx) const {
    const auto image = images_->Colors(view_idx, 0);
    const double scale = std::min(
        1.0, static_cast<double>(options_.max_photo_size) / std::max(image->width, image->height));
    const auto reduced = [&](int size) {
      return std::max(1, static_cast<int>(std::lround(scale * size)));
    };
    return EncodeJpeg(ResizeColors(*image, reduced(image->width), reduced(image->height)),
                      kPhotoQuality);
  }

  fs::path Write() {
    WriteFileAtomically(folder_ / "report.json", MakeReportJson(report_));
    if (!HasReportPage()) return folder_ / "report.json";
    WriteFileAtomically(folder_ / "index.html", MakeReportPage(report_));
    return folder_ / "index.html";
  }

  const ComparisonOptions& options_;
  const CommandContext& context_;
  const DenseWorkspace workspace_;
  const fs::path folder_;
  const Scene scene_;
  const RunHistory history_{workspace_};
  std::unique_ptr<SurfaceEvaluator> evaluator_;
  std::unique_ptr<ImageStore> images_;
  int key_photo_ = -1;
  Report report_;
};

}  // namespace

void ComparisonOptions::Describe(OptionSet* options) {
  options->Add("workspace_path", &workspace_path, "Workspace with the photos and the meshes.");
  options->Add("ground_truth_path", &ground_truth_path, "True mesh or cloud (PLY).");
  options->Add(
      "input_paths", &input_paths,
      "Further meshes or clouds, separated by commas; also of PMVS: .patch, .ply or its folder.");
  options->Add("output_path", &output_path,
               "Folder of the report; empty: lsmvs/report in the workspace.");
  options->Add("title", &title, "Title of the page.");
  options->Add(
      "view_names", &view_names,
      "Photos that the photometric score is measured on, separated by commas; empty: all.");
  options->Add("run_colmap", &run_colmap,
               "Run those of COLMAP's meshers that the installed colmap has and whose mesh is "
               "missing; the meshes stay in the workspace.");
  options->Add("max_num_faces", &max_num_faces,
               "Faces of each mesh on the page; larger meshes are simplified for it.",
               {100, 5000000});
  options->Add("max_num_photos", &max_num_photos, "Photos on the page.", {0, 100000});
  options->Add("max_photo_size", &max_photo_size, "Longer side of the photos on the page, pixels.",
               {16, 16384});
  options->Add("picture_width", &picture_width, "Width of the pictures beside the page, pixels.",
               {16, 16384});
  DescribeMeshScratch(&scratch_path, options);
  surface.Describe(options);
  depth.Describe(options);
  photo.Describe(options);
}

bool ComparisonOptions::Check(std::string* error) const {
  return surface.Check(error) && photo.Check(error) && CheckOptions(*this, error);
}

fs::path WriteComparison(const ComparisonOptions& options, const CommandContext& context) {
  RequireValid(options);
  return Comparison(options, context).Run();
}

}  // namespace lsmvs
