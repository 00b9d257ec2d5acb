// Makes the cloud of a town seen from the air, of any number of points, with the views that see
// each of them: a dense COLMAP workspace without photos, to test and to plan large surfaces.

#include <fmt/format.h>

#include <string>
#include <vector>

#include "lsmvs/synthetic/generator.h"
#include "lsmvs/synthetic/town.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {
namespace {

struct ProgramOptions {
  TownOptions town;
  std::string output;
  int truth_lots = 20;
  int seed = 0;

  void Describe(OptionSet* options) {
    options->Add("output", &output, "folder to write; it is made if it is missing");
    options->Add("truth_lots", &truth_lots,
                 "lots per side, in the middle, that gt_mesh.ply holds; 20 m each", {1, 100000});
    options->Add("seed", &seed, "of all that is random; the same seed gives the same files",
                 {0, 1000000000});
    town.Describe(options);
  }
};

constexpr const char* kUsage =
    "usage: make_large_cloud --output FOLDER [--option value]...\n"
    "Samples a town seen from the air. FOLDER gets fused.ply, fused.ply.vis, COLMAP's sparse\n"
    "model without points, and gt_mesh.ply, the truth in the middle of the town. Memory does not\n"
    "grow with the cloud.\n";

void Run(ProgramOptions options) {
  if (options.output.empty()) throw UsageError("--output is missing; see --help");
  options.town.seed = static_cast<uint64_t>(options.seed);
  const RunContext context;
  const Town town(options.town);
  const TownWorkspace written = WriteTown(options.output, town, options.truth_lots, context);
  fmt::print("{}: {} points, {} views, {:.0f} m wide, {} m per pixel; truth of [{}, {}] m\n",
             options.output, written.num_points, written.num_views, town.side(), options.town.gsd,
             Town::kLot * written.truth_begin, Town::kLot * written.truth_end);
}

int Main(const std::vector<std::string>& arguments) { return RunGenerator(kUsage, arguments, Run); }

}  // namespace
}  // namespace lsmvs

int main(int argc, char** argv) { return lsmvs::Main({argv + 1, argv + argc}); }
