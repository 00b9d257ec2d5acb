#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/scene/workspace_files.h"

namespace lsmvs {

// The files of a dense workspace in COLMAP's formats, for the pipeline. `database` holds features
// that may join interest points; empty: none. `sources` lists source images as patch-match.cfg
// does; empty: the workspace's, if it is there.
std::shared_ptr<const WorkspaceFiles> MakeColmapWorkspaceFiles(
    const DenseWorkspace& workspace, const std::filesystem::path& database,
    const std::filesystem::path& sources = {});

// A cloud with its visibility, and the workspace with the cameras that see it.
struct CloudInput {
  DenseWorkspace workspace;
  std::filesystem::path cloud;
};

// The files of several workspaces in one frame, for the surface stage: models and clouds are those
// of all inputs, whatever cloud is asked for, with the views of the inputs one after the other.
// Results go to `output`. `parts` are the scenes of the inputs (JoinedScene).
std::shared_ptr<const WorkspaceFiles> MakeJoinedWorkspaceFiles(const DenseWorkspace& output,
                                                               std::vector<CloudInput> inputs,
                                                               std::vector<Scene> parts);

}  // namespace lsmvs
