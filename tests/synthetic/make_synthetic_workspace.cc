// Renders photos of a shape that is known exactly and writes them, with the truth, as a COLMAP
// workspace.

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/synthetic/generator.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {
namespace {

struct ProgramOptions {
  SyntheticSceneOptions scene;
  PhotoOptions photo;
  std::string output;
  WorkspaceFormat format = WorkspaceFormat::kDense;
  int seed = 0;
  bool overwrite = false;

  void Describe(OptionSet* options) {
    options->Add("output", &output, "folder to write; it is made if it is missing");
    options->AddEnum("format", &format, "photos only, what mapper leaves, or a dense workspace",
                     {{"photos", WorkspaceFormat::kPhotos},
                      {"project", WorkspaceFormat::kProject},
                      {"dense", WorkspaceFormat::kDense}});
    options->Add("seed", &seed, "of all that is random; the same seed gives the same files",
                 {0, 1000000000});
    options->Add("overwrite", &overwrite, "write into a folder that holds something already");
    scene.Describe(options);
    photo.Describe(options);
  }
};

constexpr const char* kUsage =
    "usage: make_synthetic_workspace --output FOLDER [--option value]...\n"
    "Renders photos of a shape that is known exactly. FOLDER gets images/, gt_mesh.ply,\n"
    "camera_centers.txt (name x y z) and, by format, COLMAP's sparse model.\n";

bool HoldsSomething(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::exists(folder) && !std::filesystem::is_empty(folder, error);
}

void Run(ProgramOptions options) {
  if (options.output.empty()) throw UsageError("--output is missing; see --help");
  if (!options.overwrite && HoldsSomething(options.output)) {
    throw Error(ExitCode::kOverwrite,
                options.output + ": is not empty; give another --output, or --overwrite 1");
  }
  options.scene.seed = static_cast<uint64_t>(options.seed);
  const RunContext context;
  SyntheticScene scene = MakeScene(options.scene, context);
  // The texture's wavelengths and the seeds come from the scene.
  const PhotoOptions suited = scene.photo;
  scene.photo = options.photo;
  scene.photo.seed = suited.seed;
  scene.photo.texture = suited.texture;
  scene.photo.texture.contrast = options.photo.texture.contrast;
  scene.photo.texture.weak_fraction = options.photo.texture.weak_fraction;
  WriteWorkspace(options.output, options.format, &scene, context);
  fmt::print("{}: {} photos of {} x {}, one pixel is {:.6f} on the surface\n", options.output,
             scene.scene.num_views(), options.scene.width, options.scene.height, scene.gsd);
}

int Main(const std::vector<std::string>& arguments) { return RunGenerator(kUsage, arguments, Run); }

}  // namespace
}  // namespace lsmvs

int main(int argc, char** argv) { return lsmvs::Main({argv + 1, argv + argc}); }
