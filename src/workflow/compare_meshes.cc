#include "lsmvs/workflow/compare_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/program/version.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/valid_options.h"
#include "lsmvs/workflow/comparison/colmap_meshers.h"
#include "lsmvs/workflow/comparison/run_history.h"
#include "lsmvs/workflow/files/mesh_memory.h"
#include "lsmvs/workflow/files/scene_input.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

// As the evaluator, and what is simplified of it for the page; photos, pictures and the page.
constexpr MeshMemoryModel kMemory = {.all = 220, .in_memory = 100, .fixed = 110 << 20};

// A mesh, or a cloud of PMVS, that is compared.
using Candidate = ReportSource;

std::vector<Candidate> FindMeshes(const DenseWorkspace& workspace,
                                  const std::vector<std::string>& further) {
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
  for (const std::string& path : further) {
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
    if (!inner.empty()) inner.insert(0, "/");
    inner.insert(0, path.filename().string());
    path = path.parent_path();
  }
  const std::string name = path.filename().string();
  return inner.empty() ? name : name + ", " + inner;
}

// Of meshes of which one after the other is held.
fs::path Largest(const std::vector<Candidate>& candidates) {
  const auto size = [](const Candidate& candidate) {
    std::error_code error;
    const auto bytes = fs::file_size(candidate.path, error);
    return error ? 0 : bytes;
  };
  return std::max_element(candidates.begin(), candidates.end(),
                          [&](const auto& a, const auto& b) { return size(a) < size(b); })
      ->path;
}

class Comparison {
 public:
  Comparison(const MeshComparisonOptions& options, const CommandContext& context)
      : options_(options),
        context_(context),
        workspace_(FindWorkspaceToEvaluate(options.workspace_path)),
        folder_(options.output_path.empty() ? workspace_.ReportFolder()
                                            : fs::path(options.output_path)),
        scene_(LoadScene(workspace_)) {}

  fs::path Run() {
    const std::vector<std::pair<std::string, std::string>> missing = MissingMeshes();
    const std::vector<Candidate> candidates = FindMeshes(workspace_, options_.input_paths);
    if (candidates.empty()) {
      throw InputError(workspace_.folder.string(), "holds no mesh to compare",
                       "run lsmvs-mesher first, or give --run_colmap or --input_paths");
    }
    const MeshMemory memory("mesh_comparer", {Largest(candidates), options_.ground_truth_path},
                            kMemory, options_.scratch_path, context_);
    ReportOptions report_options = options_.report;
    report_options.view_idxs = FindViews(scene_, options_.view_names);
    ReportBuilder builder(scene_, report_options, folder_, context_.run);
    if (!options_.ground_truth_path.empty()) {
      builder.SetTruth(
          ReadMeshPly(options_.ground_truth_path, scene_.world_offset, NotFinite::kKeep));
    }
    for (const Candidate& candidate : candidates) Add(candidate, &builder);
    builder.report().missing = missing;
    DescribeRun(&builder.report());
    builder.AddViews();
    return Write(builder.report());
  }

 private:
  fs::path UsagePath() const { return folder_ / "colmap-meshers.json"; }

  // Meshes of COLMAP that are not there, and why; those that it can make are made if asked for.
  std::vector<std::pair<std::string, std::string>> MissingMeshes() const {
    if (options_.run_colmap) return RunMissingMeshers(workspace_, UsagePath(), context_);
    std::vector<std::pair<std::string, std::string>> missing;
    for (const ColmapMesher& mesher : ColmapMeshers()) {
      if (fs::exists(workspace_.folder / mesher.file)) continue;
      missing.emplace_back(mesher.title,
                           mesher.file + " is not there; --run_colmap makes it where COLMAP can");
    }
    return missing;
  }

  void Add(Candidate candidate, ReportBuilder* builder) const {
    const fs::path& path = candidate.path;
    context_.console->Begin("Measuring " + path.filename().string());
    if (IsPmvsResult(path)) {
      const PmvsCloud cloud = ReadPmvsCloud(path, scene_.world_offset);
      for (const fs::path& file : cloud.files) candidate.file_bytes += fs::file_size(file);
      builder->AddCloud(cloud.points, cloud.num_views, cloud.scores, candidate);
    } else {
      const TexturedMesh textured = ReadTexturedPly(path, scene_.world_offset, NotFinite::kKeep);
      candidate.file_bytes = fs::file_size(path);
      if (textured.mesh.faces.empty()) {
        builder->AddCloud(textured.mesh, {}, {}, candidate);
      } else {
        builder->AddMesh(textured, candidate);
        SetCost(path, &builder->report().meshes.back());
      }
    }
    context_.console->End();
  }

  void SetCost(const fs::path& path, ReportMesh* entry) const {
    const std::map<std::string, ToolUsage> usage = ReadMesherUsage(workspace_, UsagePath());
    if (const auto found = usage.find(entry->file); found != usage.end()) {
      entry->seconds = found->second.seconds;
      entry->peak_bytes = found->second.peak_bytes;
      return;
    }
    // A refined mesh also needs the one it began with.
    const std::string first = workspace_.VisibilityMeshPath().filename().string();
    if (path == workspace_.VisibilityMeshPath()) history_.AddCost({first}, entry);
    if (path == workspace_.RefinedMeshPath()) history_.AddCost({first, entry->file}, entry);
  }

  void DescribeRun(Report* report) const {
    report->program = VersionLine();
    report->workspace = workspace_.folder.string();
    report->title =
        options_.title.empty() ? "Meshes of " + WorkspaceTitle(workspace_.folder) : options_.title;
    report->stages = history_.Stages();
    for (const auto& [name, value] : history_.options()) report->options.emplace_back(name, value);
    if (report->meshes.empty()) {
      throw InputError(workspace_.folder.string(), "holds no mesh with faces",
                       "give --input_paths");
    }
    if (!options_.view_names.empty()) {
      report->notes.push_back(
          fmt::format("The photos were compared in {} only.", fmt::join(options_.view_names, ",")));
    }
  }

  fs::path Write(const Report& report) const {
    WriteFileAtomically(folder_ / "report.json", MakeReportJson(report));
    if (!HasReportPage()) return folder_ / "report.json";
    WriteFileAtomically(folder_ / "index.html", MakeReportPage(report));
    return folder_ / "index.html";
  }

  const MeshComparisonOptions& options_;
  const CommandContext& context_;
  const DenseWorkspace workspace_;
  const fs::path folder_;
  const Scene scene_;
  const RunHistory history_{workspace_};
};

}  // namespace

void MeshComparisonOptions::Describe(OptionSet* options) {
  options->Add("workspace_path", &workspace_path, "Workspace with the photos and the meshes.");
  options->Add("ground_truth_path", &ground_truth_path, "True mesh or cloud (PLY).");
  options->AddCommaList(
      "input_paths", &input_paths,
      "Further meshes or clouds, separated by commas; also of PMVS: .patch, .ply or its folder.");
  options->Add("output_path", &output_path,
               "Folder of the report; empty: lsmvs/report in the workspace.");
  options->Add("title", &title, "Title of the page.");
  options->AddCommaList(
      "view_names", &view_names,
      "Photos that the photometric score is measured on, separated by commas; empty: all.");
  options->Add("run_colmap", &run_colmap,
               "Run those of COLMAP's meshers that the installed colmap has and whose mesh is "
               "missing; the meshes stay in the workspace.");
  DescribeMeshScratch(&scratch_path, options);
  report.Describe(options);
}

bool MeshComparisonOptions::Check(std::string* error) const {
  return report.Check(error) && CheckOptions(*this, error);
}

void CompareMeshes(const MeshComparisonOptions& options, const CommandContext& context) {
  RequireValid(options);
  context.console->Print(Comparison(options, context).Run().string() + "\n");
}

}  // namespace lsmvs
