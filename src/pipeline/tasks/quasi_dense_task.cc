#include <fmt/format.h>

#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/tasks/expected_sizes.h"
#include "lsmvs/pipeline/tasks/task_inputs.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// Version of the method: a new one makes clouds of older runs stale.
constexpr const char* kQuasiDenseVersion = "3";

[[noreturn]] void ThrowWithoutCloud(const Reconstruction& reconstruction,
                                    const QuasiDenseResult& result) {
  if (result.status == QuasiDenseStatus::kNoDepthRange) {
    throw InputError(reconstruction.files->PointsFile().string(),
                     "holds no points, so that nothing tells how far the scene is",
                     "triangulate points (colmap point_triangulator), or give "
                     "--QuasiDenseMatching.depth_min and --QuasiDenseMatching.depth_max");
  }
  throw InputError(reconstruction.files->CloudFile().string(), "would be empty: " + result.message,
                   EmptyCloudRemedy(reconstruction));
}

TaskCounts RunQuasiDense(const Reconstruction& reconstruction, const TaskRun& run) {
  CheckAnyNeighbors(reconstruction);
  PrepareStage(reconstruction, run.context);
  QuasiDenseOptions options = reconstruction.options.quasi_dense;
  options.bounding_box = reconstruction.options.bounding_box;
  const std::vector<std::vector<Eigen::Vector2f>> keypoints =
      reconstruction.files->ReadKeypoints(reconstruction.scene);
  QuasiDenseResult result;
  reconstruction.files->WriteCloud(reconstruction.scene, run.outputs, [&](const CloudSink& sink) {
    result = MatchQuasiDense(reconstruction.scene, *reconstruction.images, reconstruction.neighbors,
                             keypoints, options, sink, run.context);
    if (result.num_points == 0) ThrowWithoutCloud(reconstruction, result);
  });
  return {{"points", static_cast<double>(result.num_points)},
          {"observations", static_cast<double>(result.num_observations)},
          {"interest_points", static_cast<double>(result.counters.num_interest_points)},
          {"joined_keypoints", static_cast<double>(result.counters.num_joined_keypoints)}};
}

}  // namespace

Task MakeQuasiDenseTask(const ReconstructionPtr& reconstruction,
                        const std::filesystem::path& cloud) {
  const ReconstructionOptions& options = reconstruction->options;
  Task task;
  task.stage = task.name = kQuasiDenseStage;
  task.version = kQuasiDenseVersion;
  task.options = TaskOptionsText(*reconstruction, options.view_selection, options.quasi_dense) +
                 fmt::format("bounding_box={}\n", BoxText(options.bounding_box));
  AddModelInputs(*reconstruction, &task);
  AddAllPhotoInputs(*reconstruction, &task);
  const std::filesystem::path keypoints = reconstruction->files->KeypointFile();
  if (!keypoints.empty()) task.inputs.push_back(keypoints);
  task.outputs = reconstruction->files->CloudFiles(cloud);
  task.foreign_outputs = ForeignOutputs::kUse;
  task.cost =
      EstimateQuasiDenseCost(reconstruction->scene, *reconstruction->images, options.quasi_dense);
  task.output_bytes =
      ExpectedCloudBytes(*reconstruction, ExpectedPoints(*reconstruction, std::filesystem::path()));
  task.run = [=](const TaskRun& run) { return RunQuasiDense(*reconstruction, run); };
  return task;
}

}  // namespace lsmvs
