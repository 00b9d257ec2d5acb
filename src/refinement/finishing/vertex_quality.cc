#include "lsmvs/refinement/finishing/vertex_quality.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr double kViewSigma = 1.5;
// Quality where texture tells nothing.
constexpr double kUntold = 0.5;
// No more photos than this make a difference.
constexpr size_t kMaxViews = 8;

// Different views, as many as make a difference.
class ViewSet {
 public:
  void Add(int view_idx) {
    const auto end = views_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (count_ < kMaxViews && std::find(views_.begin(), end, view_idx) == end) {
      views_[count_++] = view_idx;
    }
  }
  size_t size() const { return count_; }

 private:
  std::array<int, kMaxViews> views_;
  size_t count_ = 0;
};

struct Evidence {
  double error = 0, mass = 0, pixels = 0;
  ViewSet views;
};

double Likeness(const Evidence& e) {
  if (!(e.mass > 0) || !(e.pixels > 0)) return kUntold;
  const double told = std::min(1.0, e.mass / (kFullMassShare * e.pixels));
  const double likeness = std::clamp(1.0 - e.error / (e.mass * kUnlikePhotoError), 0.0, 1.0);
  return told * likeness + (1 - told) * kUntold;
}

void AddViews(const FacePairs& pairs, size_t face, ViewSet* views) {
  const auto per_face = static_cast<size_t>(pairs.per_face);
  for (size_t k = 0; k < per_face; ++k) {
    const int32_t pair = pairs.of_face[face * per_face + k];
    if (pair < 0) return;
    views->Add(pairs.pairs[static_cast<size_t>(pair)].i);
    views->Add(pairs.pairs[static_cast<size_t>(pair)].j);
  }
}

}  // namespace

std::vector<float> VertexQuality(const TriangleMesh& mesh, const FacePairs& pairs,
                                 const PhotoTerms& terms) {
  LSMVS_CHECK_EQ(terms.error.size(), mesh.faces.size());
  std::vector<Evidence> evidence(mesh.vertices.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      Evidence& e = evidence[static_cast<size_t>(v)];
      e.error += terms.error[f];
      e.mass += terms.mass[f];
      e.pixels += terms.pixels[f];
      AddViews(pairs, f, &e.views);
    }
  }
  std::vector<float> quality;
  quality.reserve(evidence.size());
  for (const Evidence& e : evidence) {
    const double n = static_cast<double>(e.views.size()) / kViewSigma;
    quality.push_back(static_cast<float>(-std::expm1(-0.5 * n * n) * Likeness(e)));
  }
  return quality;
}

}  // namespace lsmvs
