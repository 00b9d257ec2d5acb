#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "lsmvs/pipeline/reconstruction.h"

namespace lsmvs {

// What jobs for depth maps need of the sparse model, in one file that the driver of a run writes:
// views, neighbours, depth ranges, and the points that each view sees. A job reads the points of
// its own views, and looks at no photo but those; the sparse model of thousands of photos takes
// longer to read than their depth maps take to make. The tasks made from it are those of the whole
// reconstruction, and what they give has the same bytes.

// About 24 bytes a point and 4 an observation. Written whole or not at all.
void WriteJobScene(const std::filesystem::path& path, const Reconstruction& reconstruction);

// As MakeReconstruction(), with points for the depth maps of the views of these names only. Throws
// InputError if the file is not whole, and UsageError for options out of range.
ReconstructionPtr ReadJobScene(const std::filesystem::path& path,
                               const std::set<std::string>& view_names,
                               std::shared_ptr<const WorkspaceFiles> files,
                               const ReconstructionOptions& options, const RunContext& context);

// Where a run in `root` keeps it.
std::filesystem::path JobScenePath(const std::filesystem::path& root);

// The names of the views if these are tasks for depth maps and nothing else; empty otherwise.
std::set<std::string> ViewsOfStereoTasks(const std::vector<std::string>& task_names);

}  // namespace lsmvs
