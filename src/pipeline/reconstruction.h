#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "lsmvs/execution/task.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/pipeline/reconstruction_options.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/scene/workspace_files.h"

namespace lsmvs {

// What all tasks of one workspace share. Tasks made from it keep it alive. Nothing in it changes
// what a task gives: results that one stage hands to the next go through files, so that a run that
// was killed and restarted gives the same bytes.
struct Reconstruction {
  Scene scene;
  std::shared_ptr<const WorkspaceFiles> files;
  ReconstructionOptions options;
  size_t memory_budget_bytes = 0;
  int num_threads = 1;  // for estimates

  std::unique_ptr<ImageStore> images;  // reduced to options.max_image_size
  // By options.view_selection and the files' rules of sources.
  std::vector<std::vector<Neighbor>> neighbors;
  bool has_source_rules = false;  // that change something
  std::vector<DepthRange> depth_ranges;
};

// For work within the context's budget of memory. Throws UsageError for options out of range.
std::shared_ptr<const Reconstruction> MakeReconstruction(
    Scene scene, std::shared_ptr<const WorkspaceFiles> files, const ReconstructionOptions& options,
    const RunContext& context);

// How its photos are held.
ImageStoreOptions ImageOptionsOf(const ReconstructionOptions& options, const RunContext& context);

using ReconstructionPtr = std::shared_ptr<const Reconstruction>;

// Depth maps of every view: one task a view and pass (photometric, then geometric if the options
// ask for it). Those of the last pass are wanted. Maps that COLMAP made are used where they are
// complete. Throws InputError if nothing tells the range of depths: no sparse points and no
// depth_min and depth_max.
std::vector<Task> MakeStereoTasks(const ReconstructionPtr& reconstruction);

enum class MapsToFuse {
  kAll,      // of every view: earlier tasks make them
  kPresent,  // those that are there now
};

// Depth maps of the kind -> cloud with views: a task per group of up to 10 consecutive views, and
// one that joins their parts of the cloud; a single task where there is one group. The last task
// writes the cloud. Throws InputError if no map is there that should be.
std::vector<Task> MakeFusionTasks(const ReconstructionPtr& reconstruction, DepthMapKind kind,
                                  MapsToFuse maps, const std::filesystem::path& cloud);

// Photos -> cloud with views, by interest points.
Task MakeQuasiDenseTask(const ReconstructionPtr& reconstruction,
                        const std::filesystem::path& cloud);

// Cloud -> visibility-consistent mesh. Throws InputError (when it runs) if the cloud supports no
// surface.
// `filtered_cloud`, unless empty, is written, too: the cloud without the points that the surface
// leaves in free space.
Task MakeSurfaceTask(const ReconstructionPtr& reconstruction, const std::filesystem::path& cloud,
                     const std::filesystem::path& mesh,
                     const std::filesystem::path& filtered_cloud = {});
// The same from the sparse model's points.
Task MakeSparseSurfaceTask(const ReconstructionPtr& reconstruction,
                           const std::filesystem::path& mesh);

// Mesh -> photometrically refined mesh with vertex colours.
Task MakeRefinementTask(const ReconstructionPtr& reconstruction,
                        const std::filesystem::path& input_mesh,
                        const std::filesystem::path& output_mesh);

// Mesh -> textured mesh, with its pages beside it: texture.png, texture_1.png, ...
Task MakeTexturingTask(const ReconstructionPtr& reconstruction,
                       const std::filesystem::path& input_mesh,
                       const std::filesystem::path& output_mesh);

// The stages of the options' point source from `from` to `to`, on the workspace's own files. What
// stages before `from` make must be there. Throws what CheckStages throws.
std::vector<Task> MakeReconstructionTasks(const ReconstructionPtr& reconstruction,
                                          ReconstructionStage from, ReconstructionStage to);

// At the start of a stage: lets go of what the stage before has left (decoded photos, and memory
// that was freed but is still held for this process), and gives photos their part of the memory
// that `context` allows.
void PrepareStage(const Reconstruction& reconstruction, const RunContext& context);

// Kind of the maps that the options' last pass makes, which fusion takes.
DepthMapKind FinalDepthMaps(const ReconstructionOptions& options);

// Photos' pixels after reduction to max_image_size, summed over the views.
double NumPixels(const Reconstruction& reconstruction);

}  // namespace lsmvs
