#include "lsmvs/texturing/unseen/fill_colors.h"

#include "lsmvs/texturing/levelling/conjugate_gradients.h"

namespace lsmvs {

namespace {

constexpr float kMidGrey = 128;
constexpr float kPullToGrey = 1e-6f;  // against the neighbours' weight of 1

class HarmonicFiller {
 public:
  HarmonicFiller(const LabelEnergy& energy, std::span<const int32_t> views)
      : mesh_(energy.mesh()),
        candidates_(energy.candidates()),
        views_(views),
        unknown_(mesh_.vertices.size(), -1),
        colors_(mesh_.vertices.size(), Eigen::Vector3f::Zero()) {}

  std::vector<Eigen::Vector3f> Run(const LabelNodes& nodes,
                                   const std::vector<Eigen::Vector3f>& offsets) {
    const std::vector<int> num_seen = AverageSeenFaces(nodes, offsets);
    NumberUnknowns(num_seen);
    if (num_unknowns_ > 0) SolveUnknowns();
    return std::move(colors_);
  }

 private:
  // Number of seen faces at each vertex.
  std::vector<int> AverageSeenFaces(const LabelNodes& nodes,
                                    const std::vector<Eigen::Vector3f>& offsets) {
    std::vector<int> counts(mesh_.vertices.size(), 0);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (views_[f] < 0) continue;
      const Candidate* own = candidates_.Find(f, views_[f]);
      for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<size_t>(mesh_.faces[f][k]);
        const auto node = static_cast<size_t>(nodes.of_face[f][static_cast<size_t>(k)]);
        colors_[v] += own->color.cast<float>() + offsets[node];
        ++counts[v];
      }
    }
    for (size_t v = 0; v < counts.size(); ++v) {
      if (counts[v] > 0) colors_[v] /= static_cast<float>(counts[v]);
    }
    return counts;
  }

  void NumberUnknowns(const std::vector<int>& num_seen) {
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (views_[f] >= 0) continue;
      for (const int v : mesh_.faces[f]) {
        if (num_seen[v] == 0 && unknown_[v] < 0) unknown_[v] = num_unknowns_++;
      }
    }
  }

  // Calls visit(u, v) for both directions of the edges of unseen faces.
  template <class Visit>
  void ForEdgesOfUnseen(const Visit& visit) const {
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (views_[f] >= 0) continue;
      for (int k = 0; k < 3; ++k) {
        const auto u = static_cast<size_t>(mesh_.faces[f][k]);
        const auto v = static_cast<size_t>(mesh_.faces[f][(k + 1) % 3]);
        visit(u, v);
        visit(v, u);
      }
    }
  }

  void SolveUnknowns() {
    Eigen::VectorXf diagonal = Eigen::VectorXf::Constant(num_unknowns_, kPullToGrey);
    Channels right = Channels::Constant(num_unknowns_, 3, kPullToGrey * kMidGrey);
    ForEdgesOfUnseen([&](size_t u, size_t v) {
      if (unknown_[u] < 0) return;
      diagonal[unknown_[u]] += 1;
      if (unknown_[v] < 0) right.row(unknown_[u]) += colors_[v].transpose();
    });
    const auto apply = [&](const Channels& x, Channels* y) {
      *y = x.array().colwise() * diagonal.array();
      ForEdgesOfUnseen([&](size_t u, size_t v) {
        if (unknown_[u] >= 0 && unknown_[v] >= 0) y->row(unknown_[u]) -= x.row(unknown_[v]);
      });
    };
    Channels x = Channels::Constant(num_unknowns_, 3, kMidGrey);
    SolveConjugateGradients(apply, diagonal, right, {.tolerance = 1e-6, .max_num_iterations = 2000},
                            &x);
    for (size_t v = 0; v < colors_.size(); ++v) {
      if (unknown_[v] >= 0) colors_[v] = x.row(unknown_[v]).transpose();
    }
  }

  const TriangleMesh& mesh_;
  const FaceCandidates& candidates_;
  std::span<const int32_t> views_;
  std::vector<int32_t> unknown_;  // of each vertex, -1: known or of no unseen face
  int32_t num_unknowns_ = 0;
  std::vector<Eigen::Vector3f> colors_;
};

}  // namespace

std::vector<Eigen::Vector3f> HarmonicFillColors(const LabelEnergy& energy,
                                                std::span<const int32_t> views,
                                                const LabelNodes& nodes,
                                                const std::vector<Eigen::Vector3f>& offsets) {
  return HarmonicFiller(energy, views).Run(nodes, offsets);
}

}  // namespace lsmvs
