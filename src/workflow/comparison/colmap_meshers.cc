#include "lsmvs/workflow/comparison/colmap_meshers.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

Json ReadJsonOrEmpty(const fs::path& path) {
  std::ifstream file(path);
  const Json json = Json::parse(file, nullptr, false);
  return json.is_object() ? json : Json::object();
}

void KeepUsage(const fs::path& usage_path, const fs::path& mesh_path, const ToolUsage& usage) {
  Json json = ReadJsonOrEmpty(usage_path);
  json[mesh_path.filename().string()] = {{"file_bytes", fs::file_size(mesh_path)},
                                         {"seconds", usage.seconds},
                                         {"cpu_seconds", usage.cpu_seconds},
                                         {"peak_bytes", usage.peak_bytes}};
  WriteFileAtomically(usage_path, json.dump(2) + "\n");
}

std::string WhyNotRunnable(const ColmapMesher& mesher, const DenseWorkspace& workspace,
                           const ColmapRunner& colmap) {
  if (!colmap.available()) return "the program colmap was not found";
  if (!colmap.HasCommand(mesher.command)) {
    return fmt::format("COLMAP {} has no {}", colmap.Version(), mesher.command);
  }
  if (!fs::exists(workspace.FusedPath())) return "fused.ply is missing";
  return "";
}

ToolUsage RunMesher(const ColmapMesher& mesher, const DenseWorkspace& workspace,
                    const ColmapRunner& colmap, const RunContext& context) {
  const fs::path mesh_path = workspace.folder / mesher.file;
  // COLMAP tells the format by the extension.
  const fs::path temporary = workspace.folder / ("lsmvs-tmp-" + mesher.file);
  const fs::path input = mesher.takes_cloud ? workspace.FusedPath() : workspace.folder;
  try {
    const ToolUsage usage = colmap.Run(
        {mesher.command, "--input_path", input.string(), "--output_path", temporary.string()},
        workspace.LogFolder() / (mesher.command + ".log"), context);
    if (!fs::exists(temporary)) {
      throw ExternalToolError(fmt::format("colmap {} ended without a mesh", mesher.command));
    }
    fs::rename(temporary, mesh_path);
    return usage;
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

}  // namespace

const std::vector<ColmapMesher>& ColmapMeshers() {
  static const std::vector<ColmapMesher> meshers = {
      {"poisson_mesher", "COLMAP Poisson", "meshed-poisson.ply", true},
      {"delaunay_mesher", "COLMAP Delaunay", "meshed-delaunay.ply", false},
      {"advancing_front_mesher", "COLMAP advancing front", "meshed-advancing-front.ply", true},
  };
  return meshers;
}

std::map<std::string, ToolUsage> ReadMesherUsage(const DenseWorkspace& workspace,
                                                 const fs::path& path) {
  std::map<std::string, ToolUsage> result;
  const Json json = ReadJsonOrEmpty(path);
  for (const auto& [file, entry] : json.items()) {
    std::error_code error;
    const uint64_t size = fs::file_size(workspace.folder / file, error);
    if (error || !entry.is_object() || entry.value("file_bytes", uint64_t{0}) != size) continue;
    result[file] = {entry.value("seconds", 0.0), entry.value("cpu_seconds", 0.0),
                    entry.value("peak_bytes", size_t{0})};
  }
  return result;
}

std::vector<std::pair<std::string, std::string>> RunMissingMeshers(const DenseWorkspace& workspace,
                                                                   const fs::path& usage_path,
                                                                   const CommandContext& context) {
  std::vector<std::pair<std::string, std::string>> failed;
  const ColmapRunner colmap;
  for (const ColmapMesher& mesher : ColmapMeshers()) {
    if (fs::exists(workspace.folder / mesher.file)) continue;
    const std::string reason = WhyNotRunnable(mesher, workspace, colmap);
    if (!reason.empty()) {
      failed.emplace_back(mesher.title, reason);
      continue;
    }
    context.console->Begin("Running colmap " + mesher.command);
    try {
      const ToolUsage usage = RunMesher(mesher, workspace, colmap, context.run);
      KeepUsage(usage_path, workspace.folder / mesher.file, usage);
      context.console->End();
    } catch (const ExternalToolError& error) {
      context.console->End("failed");
      failed.emplace_back(mesher.title, error.what());
    }
  }
  return failed;
}

}  // namespace lsmvs
