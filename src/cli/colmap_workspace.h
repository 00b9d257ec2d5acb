#pragma once

#include <filesystem>
#include <memory>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/pipeline/workspace_files.h"

namespace lsmvs {

// The files of a dense workspace in COLMAP's formats, for the pipeline. `database` holds features
// that may join interest points; empty: none. `sources` lists source images as patch-match.cfg
// does; empty: the workspace's, if it is there.
std::shared_ptr<const WorkspaceFiles> MakeColmapWorkspaceFiles(
    const DenseWorkspace& workspace, const std::filesystem::path& database,
    const std::filesystem::path& sources = {});

}  // namespace lsmvs
