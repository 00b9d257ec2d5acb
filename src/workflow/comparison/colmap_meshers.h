#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lsmvs/colmap_adapter/colmap_runner.h"
#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/program/command_context.h"

namespace lsmvs {

// A mesher of COLMAP, with the file that it leaves in a workspace.
struct ColmapMesher {
  std::string command;  // of `colmap`
  std::string title;    // "COLMAP Poisson"
  std::string file;     // "meshed-poisson.ply"
  // Whether it reads fused.ply itself, or the folder that holds it.
  bool takes_cloud = false;
};

// All that COLMAP 3.x and 4.x have.
const std::vector<ColmapMesher>& ColmapMeshers();

// What COLMAP's meshers took when we ran them, by the name of the mesh; kept in a file of the
// report. Figures of files that have been replaced since are left out.
std::map<std::string, ToolUsage> ReadMesherUsage(const DenseWorkspace& workspace,
                                                 const std::filesystem::path& path);

// Runs those of COLMAP's meshers whose file is missing, and writes what they took to `usage_path`.
// A mesh appears whole or not at all. Returns title and reason of each that could not run.
std::vector<std::pair<std::string, std::string>> RunMissingMeshers(
    const DenseWorkspace& workspace, const std::filesystem::path& usage_path,
    const CommandContext& context);

}  // namespace lsmvs
