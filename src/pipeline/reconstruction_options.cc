#include "lsmvs/pipeline/reconstruction_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

// "a, b, c".
std::string NamesOf(const std::vector<ReconstructionStage>& stages) {
  std::string names;
  for (const ReconstructionStage stage : stages) {
    names += (names.empty() ? "" : ", ") + std::string(StageName(stage));
  }
  return names;
}

}  // namespace

const char* StageName(ReconstructionStage stage) {
  switch (stage) {
    case ReconstructionStage::kStereo:
      return kStereoStage;
    case ReconstructionStage::kFusion:
      return kFusionStage;
    case ReconstructionStage::kQuasiDense:
      return kQuasiDenseStage;
    case ReconstructionStage::kSurface:
      return kSurfaceStage;
    case ReconstructionStage::kRefinement:
      return kRefinementStage;
    case ReconstructionStage::kTexturing:
      return kTexturingStage;
  }
  return "";
}

std::vector<ReconstructionStage> StagesOf(PointSource source) {
  using enum ReconstructionStage;
  if (source == PointSource::kQuasiDense) return {kQuasiDense, kSurface, kRefinement, kTexturing};
  return {kStereo, kFusion, kSurface, kRefinement, kTexturing};
}

void CheckStages(PointSource source, ReconstructionStage from, ReconstructionStage to) {
  const std::vector<ReconstructionStage> stages = StagesOf(source);
  for (const ReconstructionStage stage : {from, to}) {
    if (std::find(stages.begin(), stages.end(), stage) != stages.end()) continue;
    throw UsageError(fmt::format(
        "{} is no stage of --point_source {}; its stages are {}", StageName(stage),
        source == PointSource::kQuasiDense ? "quasi_dense" : "patch_match", NamesOf(stages)));
  }
  if (from > to) throw UsageError("--from names a later stage than --to");
}

void ReconstructionOptions::Describe(OptionSet* options) {
  view_selection.Describe(options);
  patch_match.Describe(options);
  fusion.Describe(options);
  quasi_dense.Describe(options);
  surface.Describe(options);
  refinement.Describe(options);
  texturing.Describe(options);
}

void ApplyQuality(Quality quality, ReconstructionOptions* options) {
  static constexpr std::array<int, 4> kSizes = {1000, 1600, 2400, 0};
  static constexpr std::array<double, 4> kIterations = {0.5, 0.75, 1.0, 1.0};
  const auto level = static_cast<size_t>(quality);
  options->max_image_size = kSizes[level];
  options->point_source =
      quality == Quality::kLow ? PointSource::kQuasiDense : PointSource::kPatchMatch;
  const auto scale = [&](int* iterations) {
    *iterations = std::max(1, static_cast<int>(*iterations * kIterations[level]));
  };
  scale(&options->patch_match.num_iterations);
  scale(&options->refinement.max_num_iterations);
}

}  // namespace lsmvs
