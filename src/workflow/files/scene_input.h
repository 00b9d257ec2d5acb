#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// The workspace that `path` stands for: a dense workspace, the only one that a project holds, or a
// project whose photos have no distortion. Throws UsageError if there are several.
DenseWorkspace FindWorkspaceToEvaluate(const std::filesystem::path& path);
// Its scene, or that of a folder prepared for PMVS (LoadPmvsScene). Throws InputError.
Scene LoadSceneToEvaluate(const std::filesystem::path& path, bool check_images);
// The same, or nothing for an empty path.
std::optional<Scene> LoadSceneIfGiven(const std::string& path, bool check_images);
// The offset that is subtracted from the files' coordinates; zero without a scene.
Eigen::Vector3d WorldOffset(const std::optional<Scene>& scene);

// Positions of the views of these names, ascending. Throws UsageError that names the nearest name.
std::vector<int> FindViews(const Scene& scene, const std::vector<std::string>& names);

// A direction of unit length from text such as "0,0,1". Throws UsageError that names `option`.
Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text);

}  // namespace lsmvs
