#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Features of the scene's photos in image coordinates, one list per view, found by the image's
// name. Those of a view are left out if its sparse points are not among them: the database is then
// about other photos, usually the distorted ones that these were made from. Throws InputError as
// ColmapDatabase does.
std::vector<std::vector<Eigen::Vector2f>> ReadSceneKeypoints(const std::filesystem::path& database,
                                                             const Scene& scene);

// database.db in the workspace or, for <project>/dense/N, in the project. Empty if there is none.
std::filesystem::path FindDatabase(const DenseWorkspace& workspace);

}  // namespace lsmvs
