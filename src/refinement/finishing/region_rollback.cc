#include "lsmvs/refinement/finishing/region_rollback.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "lsmvs/mesh/undo_collisions.h"
#include "lsmvs/refinement/step/smoothness.h"

namespace lsmvs {

namespace {

// A rise of the mean error below this part is noise: it is a mean over some thousand windows.
constexpr double kRelativeTolerance = 0.005;
// Smoothness makes up for a rise by this part at most: where photos say nothing, all the error is
// noise, and a plate that is free of them loses the shape of the surface.
constexpr double kMaxGainPart = 0.05;
constexpr double kMinMassKept = 0.4;
constexpr int kFadeRings = 3;
constexpr double kMaxRoundingPart = 0.01;

struct RegionError {
  double error = 0, mass = 0;
  double gain = 0;  // of smoothness, in units of `error`
};

std::vector<RegionError> SumByRegion(const FaceRegions& regions, const PhotoTerms& terms) {
  std::vector<RegionError> sums(static_cast<size_t>(regions.count));
  for (size_t f = 0; f < regions.of_face.size(); ++f) {
    RegionError& sum = sums[static_cast<size_t>(regions.of_face[f])];
    sum.error += terms.error[f];
    sum.mass += terms.mass[f];
  }
  return sums;
}

void AddGain(const TriangleMesh& mesh, const FaceRegions& regions, const SmoothnessGain& gain,
             std::vector<RegionError>* sums) {
  if (gain.of_vertex.empty()) return;
  std::vector<uint8_t> done(mesh.vertices.size(), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      if (std::exchange(done[static_cast<size_t>(v)], uint8_t{1})) continue;
      (*sums)[static_cast<size_t>(regions.of_face[f])].gain +=
          gain.of_vertex[static_cast<size_t>(v)];
    }
  }
}

double MeanError(const std::vector<RegionError>& sums) {
  double error = 0, mass = 0;
  for (const RegionError& sum : sums) {
    error += sum.error;
    mass += sum.mass;
  }
  return mass > 0 ? error / mass : 0.0;
}

bool IsWorse(const RegionError& before, const RegionError& after) {
  if (before.mass == 0) return false;
  if (after.mass < kMinMassKept * before.mass) return true;
  // Compared over as many pixels as before.
  const double error = after.error * before.mass / after.mass;
  const double gain = std::clamp(after.gain, 0.0, kMaxGainPart * before.error);
  return error > (1 + kRelativeTolerance) * before.error + gain;
}

// Terms of the faces that return to their input.
void TakeRestored(const FaceRegions& regions, const std::vector<uint8_t>& is_worse,
                  const PhotoTerms& before, PhotoTerms* terms) {
  for (size_t f = 0; f < regions.of_face.size(); ++f) {
    if (!is_worse[static_cast<size_t>(regions.of_face[f])]) continue;
    terms->error[f] = before.error[f];
    terms->mass[f] = before.mass[f];
    terms->pixels[f] = before.pixels[f];
  }
}

// Share of the refinement that each vertex keeps: 0 in the regions to restore, rising to 1 over a
// few rings.
std::vector<double> KeptShares(const TriangleMesh& mesh, const FaceRegions& regions,
                               const std::vector<uint8_t>& is_worse) {
  std::vector<double> shares(mesh.vertices.size(), 1.0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!is_worse[static_cast<size_t>(regions.of_face[f])]) continue;
    for (const int v : mesh.faces[f]) shares[static_cast<size_t>(v)] = 0.0;
  }
  const VertexRings rings = BuildVertexRings(mesh);
  for (int ring = 0; ring < kFadeRings; ++ring) {
    std::vector<double> faded = shares;
    for (size_t v = 0; v < shares.size(); ++v) {
      for (auto k = rings.begin[v]; k < rings.begin[v + 1]; ++k) {
        const size_t j = static_cast<size_t>(rings.neighbors[static_cast<size_t>(k)]);
        faded[v] = std::min(faded[v], shares[j] + 1.0 / (kFadeRings + 1));
      }
    }
    shares.swap(faded);
  }
  return shares;
}

}  // namespace

RollbackSummary RollBackWorseRegions(const ImageStore& images,
                                     const std::vector<PosedCamera>& views,
                                     const FaceRegions& regions, const FacePairs& pairs,
                                     const std::vector<Eigen::Vector3d>& input,
                                     const SmoothnessGain& gain, const PhotoEnergyOptions& options,
                                     TriangleMesh* mesh, const RunContext& context) {
  TriangleMesh before;
  before.vertices = input;
  before.faces = mesh->faces;
  const auto measure = [&](const TriangleMesh& candidate) {
    return EvaluatePhotoTerms(images, views, candidate, {}, pairs, {}, options, context);
  };
  const PhotoTerms terms_before = measure(before);
  RollbackSummary summary;
  summary.terms = measure(*mesh);
  const std::vector<RegionError> was = SumByRegion(regions, terms_before);
  std::vector<RegionError> is = SumByRegion(regions, summary.terms);
  AddGain(*mesh, regions, gain, &is);
  summary.input_error = MeanError(was);
  std::vector<uint8_t> is_worse(was.size(), 0);
  for (size_t r = 0; r < was.size(); ++r) {
    is_worse[r] = IsWorse(was[r], is[r]);
    summary.num_regions_restored += is_worse[r];
  }
  const std::vector<Eigen::Vector3d> refined = mesh->vertices;
  const std::vector<double> shares = KeptShares(*mesh, regions, is_worse);
  for (size_t v = 0; v < shares.size(); ++v) {
    if (shares[v] == 1.0) continue;
    const Eigen::Vector3d way = mesh->vertices[v] - input[v];
    mesh->vertices[v] =
        shares[v] == 0.0 ? input[v]
                         : RoundToFile(input[v] + shares[v] * way, kMaxRoundingPart * way.norm());
  }
  // Where the restored surface passes through itself, it is left as it was refined.
  if (summary.num_regions_restored > 0) {
    UndoCollisions(mesh->faces, refined, &mesh->vertices, context);
  }
  TakeRestored(regions, is_worse, terms_before, &summary.terms);
  std::vector<RegionError> kept = is;
  for (size_t r = 0; r < kept.size(); ++r) {
    if (is_worse[r]) kept[r] = was[r];
  }
  summary.output_error = MeanError(kept);
  return summary;
}

}  // namespace lsmvs
