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
  size_t model_idx = 0;  // of several inputs: which of their different models this one's is
};

// Of each model, one workspace that has it, by model_idx.
std::vector<DenseWorkspace> WorkspacesOfModels(const std::vector<CloudInput>& inputs);

// The files of several workspaces in one frame, for the surface stage: models and clouds are those
// of all inputs, whatever cloud is asked for, with the views of the models one after the other.
// Inputs with one model_idx have the same views. Results go to `output`. `parts` are the scenes of
// the models (JoinedScene).
std::shared_ptr<const WorkspaceFiles> MakeJoinedWorkspaceFiles(const DenseWorkspace& output,
                                                               std::vector<CloudInput> inputs,
                                                               std::vector<Scene> parts);

}  // namespace lsmvs
