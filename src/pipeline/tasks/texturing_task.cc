#include <fmt/format.h>

#include <utility>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/pipeline/tasks/expected_sizes.h"
#include "lsmvs/pipeline/tasks/task_inputs.h"

namespace lsmvs {

namespace {

constexpr const char* kTexturingVersion = "3";

// The first has the name that COLMAP gives its only one.
std::filesystem::path PagePath(const std::filesystem::path& mesh, int page_idx) {
  return mesh.parent_path() /
         (page_idx == 0 ? "texture.png" : fmt::format("texture_{}.png", page_idx));
}

TaskCounts RunTexturing(const Reconstruction& reconstruction, const std::filesystem::path& input,
                        const std::filesystem::path& output, const TaskRun& run) {
  PrepareStage(reconstruction, run.context);
  const Eigen::Vector3d& offset = reconstruction.scene.world_offset;
  const auto write_page = [&](int page_idx, ColorImage&& page) {
    const std::filesystem::path path = PagePath(output, page_idx);
    WritePng(page_idx == 0 ? run.outputs.at(1) : run.add_output(path), page);
    return path;
  };
  const TexturingResult result =
      TextureMesh(reconstruction.scene, *reconstruction.images, ReadMeshPly(input, offset),
                  input.string(), reconstruction.options.texturing, write_page, run.context);
  WriteTexturedPly(run.outputs.at(0), result.textured, offset);
  TaskCounts counts = {
      {"vertices", static_cast<double>(result.textured.mesh.vertices.size())},
      {"faces", static_cast<double>(result.textured.mesh.faces.size())},
      {"faces_unseen", static_cast<double>(result.num_faces_unseen)},
      {"unseen_area_share", result.unseen_area_share},
      {"charts", static_cast<double>(result.num_charts)},
      {"pages", static_cast<double>(result.textured.pages.size())},
      {"page_side", static_cast<double>(result.textured.page_width)},
      {"utilisation", result.utilisation},
      {"ghosts", static_cast<double>(result.num_ghosts)},
      {"gains_used", result.gains_used ? 1.0 : 0.0},
  };
  for (const auto& [phase, seconds] : result.seconds) counts[phase + "_seconds"] = seconds;
  return counts;
}

}  // namespace

Task MakeTexturingTask(const ReconstructionPtr& reconstruction,
                       const std::filesystem::path& input_mesh,
                       const std::filesystem::path& output_mesh) {
  Task task;
  task.stage = task.name = kTexturingStage;
  task.version = kTexturingVersion;
  task.options = TaskOptionsText(*reconstruction, reconstruction->options.texturing);
  AddModelInputs(*reconstruction, &task);
  AddAllPhotoInputs(*reconstruction, &task);
  task.inputs.push_back(input_mesh);
  task.outputs = {output_mesh, PagePath(output_mesh, 0)};
  const size_t num_faces = ExpectedRefinedFaces(*reconstruction, input_mesh);
  task.cost = EstimateTexturingCost(*reconstruction->images, num_faces,
                                    reconstruction->options.texturing, reconstruction->num_threads);
  task.least_bytes = LeastBytes(task.cost.peak_bytes);
  task.output_bytes = ExpectedTexturedBytes(*reconstruction, num_faces);
  task.run = [=](const TaskRun& run) {
    return RunTexturing(*reconstruction, input_mesh, output_mesh, run);
  };
  return task;
}

}  // namespace lsmvs
