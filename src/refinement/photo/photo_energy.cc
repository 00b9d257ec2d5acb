#include "lsmvs/refinement/photo/photo_energy.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "lsmvs/refinement/photo/photo_evaluation.h"
#include "lsmvs/refinement/sharing/loop_states.h"
#include "lsmvs/util/ordered_merge.h"
#include "lsmvs/util/shared_loop.h"

namespace lsmvs {

namespace {

void Add(const TriangleMesh& mesh, const ViewContribution& view, PhotoTerms* terms) {
  for (size_t k = 0; k < view.faces.size(); ++k) {
    const size_t f = static_cast<size_t>(view.faces[k]);
    const FaceSums& sums = view.sums[k];
    terms->error[f] += sums.error;
    terms->mass[f] += sums.mass;
    terms->pixels[f] += sums.pixels;
    if (terms->gradient.empty()) continue;
    for (int c = 0; c < 3; ++c) {
      const size_t v = static_cast<size_t>(mesh.faces[f][c]);
      terms->gradient[v] += sums.slope[c];
      terms->curvature[v] += sums.curvature[c];
    }
  }
}

// Views that follow each other share depth maps; what is found of them waits for its turn in the
// memory that depth maps may take, too.
size_t LongestRow(const std::vector<PosedCamera>& views, const TriangleMesh& mesh,
                  const PhotoEnergyOptions& options) {
  constexpr size_t kMost = 64, kPixelsOfFace = 4;
  size_t largest = 1;
  for (const PosedCamera& view : views) {
    largest = std::max(
        largest, static_cast<size_t>(view.camera.width) * static_cast<size_t>(view.camera.height));
  }
  const size_t faces = std::min(mesh.faces.size(), largest / kPixelsOfFace);
  const size_t bytes = std::max<size_t>(1, faces * (sizeof(int32_t) + sizeof(FaceSums)));
  return std::clamp<size_t>(options.map_budget_bytes / 2 / bytes, 1, kMost);
}

}  // namespace

double PhotoTerms::TotalError() const { return std::accumulate(error.begin(), error.end(), 0.0); }
double PhotoTerms::TotalMass() const { return std::accumulate(mass.begin(), mass.end(), 0.0); }

PhotoTerms EvaluatePhotoTerms(const ImageStore& images, const std::vector<PosedCamera>& views,
                              const TriangleMesh& mesh,
                              const std::vector<Eigen::Vector3d>& directions,
                              const FacePairs& pairs, const std::vector<uint8_t>& active,
                              const PhotoEnergyOptions& options, const RunContext& context) {
  PhotoTerms terms;
  terms.error.assign(mesh.faces.size(), 0.0f);
  terms.mass.assign(mesh.faces.size(), 0.0f);
  terms.pixels.assign(mesh.faces.size(), 0.0f);
  if (!directions.empty()) {
    terms.gradient.assign(mesh.vertices.size(), 0.0);
    terms.curvature.assign(mesh.vertices.size(), 0.0);
  }
  PhotoEvaluation evaluation(images, views, mesh, directions, pairs, active, options, context);
  OrderedMerge<ViewContribution> merge(
      [&](size_t, ViewContribution&& view) { Add(mesh, view, &terms); });
  SharedLoop loop;
  loop.kind = kPhotoTermsLoop;
  loop.count = evaluation.num_items();
  loop.longest_row = LongestRow(views, mesh, options);
  loop.states = [&] { return PhotoTermsStates(mesh, directions, pairs, active, options.level); };
  loop.compute = [&](size_t item, const std::function<bool()>& is_first) {
    ViewContribution view = evaluation.Evaluate(item);
    if (!is_first()) return;
    evaluation.End(item);
    merge.Add(item, std::move(view));
  };
  loop.keep = [&](size_t item, std::string_view bytes) {
    evaluation.End(item);
    merge.Add(item, DecodeContribution(bytes, mesh.faces.size()));
  };
  RunSharedLoop(loop, context);
  return terms;
}

}  // namespace lsmvs
