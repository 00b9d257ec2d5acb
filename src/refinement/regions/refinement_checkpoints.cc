#include "lsmvs/refinement/regions/refinement_checkpoints.h"

#include <fmt/format.h>

#include <type_traits>

namespace lsmvs {

namespace {

static_assert(std::is_trivially_copyable_v<RefinementCounts>);
using Counts = std::vector<RefinementCounts>;  // of one

std::string StepName(int number) { return fmt::format("level_{}", number); }
std::string FileName(const char* what, int number) {
  return fmt::format("{}_{}", what, number % 2);
}

}  // namespace

int RefinementCheckpoints::NumLevels(int num_levels) const {
  for (int number = num_levels; number-- > 0;) {
    if (folder_.HasFinished(StepName(number))) return number + 1;
  }
  return 0;
}

void RefinementCheckpoints::WriteLevel(int number, const RefinementState& state) const {
  if (!folder_.is_on()) return;
  folder_.Write(FileName("vertices", number), state.mesh->vertices);
  folder_.Write(FileName("faces", number), state.mesh->faces);
  folder_.Write(FileName("input", number), *state.input);
  folder_.Write(FileName("pairs", number), state.pairs->pairs);
  folder_.Write(FileName("pairs_of_face", number), state.pairs->of_face);
  folder_.Write(FileName("counts", number), Counts(1, *state.result));
  folder_.FinishStep(StepName(number));
}

void RefinementCheckpoints::ReadLevel(int number, const RefinementState& state) const {
  folder_.Read(FileName("vertices", number), &state.mesh->vertices);
  folder_.Read(FileName("faces", number), &state.mesh->faces);
  folder_.Read(FileName("input", number), state.input);
  folder_.Read(FileName("pairs", number), &state.pairs->pairs);
  folder_.Read(FileName("pairs_of_face", number), &state.pairs->of_face);
  state.pairs->per_face = static_cast<int>(state.pairs->of_face.size() / state.mesh->faces.size());
  Counts counts;
  folder_.Read(FileName("counts", number), &counts);
  static_cast<RefinementCounts&>(*state.result) = counts.at(0);
}

void RefinementCheckpoints::WriteJudged(const RefinementResult& result) const {
  if (!folder_.is_on()) return;
  folder_.Write("judged_vertices", result.mesh.vertices);
  folder_.Write("judged_faces", result.mesh.faces);
  folder_.Write("judged_quality", result.mesh.vertex_quality);
  folder_.Write("judged_counts", Counts(1, result));
  folder_.FinishStep("judged");
}

void RefinementCheckpoints::ReadJudged(RefinementResult* result) const {
  folder_.Read("judged_vertices", &result->mesh.vertices);
  folder_.Read("judged_faces", &result->mesh.faces);
  folder_.Read("judged_quality", &result->mesh.vertex_quality);
  Counts counts;
  folder_.Read("judged_counts", &counts);
  static_cast<RefinementCounts&>(*result) = counts.at(0);
}

size_t RefinementCheckpoints::Bytes(size_t num_faces, int pairs_per_face) {
  constexpr size_t kVertex = sizeof(Eigen::Vector3d), kFace = sizeof(Eigen::Vector3i);
  const size_t level = kVertex + kFace + sizeof(int32_t) * static_cast<size_t>(pairs_per_face);
  const size_t judged = kVertex / 2 + sizeof(float) / 2 + kFace;
  return num_faces * (2 * level + judged);
}

}  // namespace lsmvs
