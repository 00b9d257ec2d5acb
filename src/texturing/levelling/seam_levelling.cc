#include "lsmvs/texturing/levelling/seam_levelling.h"

#include <algorithm>
#include <tuple>

#include "lsmvs/mesh/by_vertex.h"
#include "lsmvs/texturing/levelling/conjugate_gradients.h"

namespace lsmvs {

namespace {

constexpr float kMaxOffset = 64;  // grey levels

std::vector<SeamPair> PairsOfSeamEdges(const LabelEnergy& energy, const LabelNodes& nodes) {
  std::vector<SeamPair> pairs;
  const auto& faces = energy.mesh().faces;
  for (size_t f = 0; f < faces.size(); ++f) {
    for (int side = 0; side < 3; ++side) {
      const int32_t other = energy.neighbors()[f][static_cast<size_t>(side)];
      if (other < static_cast<int32_t>(f)) continue;
      const auto g = static_cast<size_t>(other);
      const auto half = static_cast<float>(0.5 * energy.LengthPx(f, side));
      for (const int corner : {side, (side + 1) % 3}) {
        const int32_t a = nodes.of_face[f][static_cast<size_t>(corner)];
        const int32_t b = nodes.At(faces[g], g, faces[f][corner]);
        if (a < 0 || b < 0 || a == b) continue;
        pairs.push_back({std::min(a, b), std::max(a, b), half, Eigen::Vector3f::Zero(), false});
      }
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const SeamPair& a, const SeamPair& b) {
    return std::tie(a.first, a.second) < std::tie(b.first, b.second);
  });
  return pairs;
}

// Joins equal ones.
void Merge(std::vector<SeamPair>* pairs) {
  size_t count = 0;
  for (const SeamPair& pair : *pairs) {
    if (count > 0 && (*pairs)[count - 1].first == pair.first &&
        (*pairs)[count - 1].second == pair.second) {
      (*pairs)[count - 1].length_px += pair.length_px;
    } else {
      (*pairs)[count++] = pair;
    }
  }
  pairs->resize(count);
}

// The differences of the pairs from the faces around.
void MeasureDifferences(const LabelEnergy& energy, const LabelNodes& nodes,
                        std::vector<SeamPair>* pairs) {
  const TriangleMesh& mesh = energy.mesh();
  const ByVertex pairs_of(mesh.vertices.size(), pairs->size(), [&](size_t i) {
    return static_cast<size_t>(nodes.vertex[static_cast<size_t>((*pairs)[i].first)]);
  });
  std::vector<float> weights(pairs->size(), 0.0f);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      for (const uint32_t i : pairs_of.Of(static_cast<size_t>(v))) {
        SeamPair& pair = (*pairs)[i];
        const Candidate* a =
            energy.candidates().Find(f, nodes.label[static_cast<size_t>(pair.first)]);
        const Candidate* b =
            energy.candidates().Find(f, nodes.label[static_cast<size_t>(pair.second)]);
        if (a == nullptr || b == nullptr) continue;
        pair.difference += a->color.cast<float>() - b->color.cast<float>();
        weights[i] += 1;
      }
    }
  }
  for (size_t i = 0; i < pairs->size(); ++i) {
    if (weights[i] == 0) continue;
    (*pairs)[i].difference /= weights[i];
    (*pairs)[i].is_known = true;
  }
}

Eigen::Vector3f MeanColor(std::span<const Candidate> candidates) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float total = 0;
  for (const Candidate& c : candidates) {
    sum += c.quality * c.color.cast<float>();
    total += c.quality;
  }
  return sum / total;
}

class Leveller {
 public:
  Leveller(const LabelEnergy& energy, const LabelNodes& nodes, const std::vector<SeamPair>& pairs,
           const LevellingOptions& options)
      : nodes_(nodes),
        pairs_(pairs),
        seam_width_(static_cast<float>(options.seam_width_px)),
        screen_(Eigen::VectorXf::Constant(static_cast<Eigen::Index>(nodes.size()), 1e-6f)),
        right_(Channels::Zero(static_cast<Eigen::Index>(nodes.size()), 3)) {
    AddScreen(energy, options.screening_px);
    for (const SeamPair& pair : pairs_) {
      right_.row(pair.first) -= Weight(pair) * pair.difference.transpose();
      right_.row(pair.second) += Weight(pair) * pair.difference.transpose();
    }
  }

  std::vector<Eigen::Vector3f> Solve() const {
    Channels offsets = Channels::Zero(right_.rows(), 3);
    SolveConjugateGradients([this](const Channels& x, Channels* y) { Apply(x, y); }, Diagonal(),
                            right_, {.tolerance = 1e-5}, &offsets);
    std::vector<Eigen::Vector3f> result(nodes_.size());
    for (size_t n = 0; n < result.size(); ++n) {
      result[n] = offsets.row(static_cast<Eigen::Index>(n))
                      .cwiseMax(-kMaxOffset)
                      .cwiseMin(kMaxOffset)
                      .transpose();
    }
    return result;
  }

 private:
  float Weight(const SeamPair& pair) const {
    return pair.is_known ? pair.length_px / seam_width_ : 0.0f;
  }

  void AddScreen(const LabelEnergy& energy, double screening_px) {
    for (size_t f = 0; f < nodes_.of_face.size(); ++f) {
      if (nodes_.of_face[f][0] < 0) continue;
      const int view_idx = nodes_.label[static_cast<size_t>(nodes_.of_face[f][0])];
      const Candidate* own = energy.candidates().Find(f, view_idx);
      const Eigen::Vector3f target =
          MeanColor(energy.candidates().Of(f)) - own->color.cast<float>();
      const auto weight = static_cast<float>(energy.AreaPx(f) / (3 * screening_px * screening_px));
      for (const int32_t n : nodes_.of_face[f]) {
        screen_[n] += weight;
        right_.row(n) += weight * target.transpose();
      }
    }
  }

  // Calls visit(i, j, weight) for all differences of two nodes.
  template <class Visit>
  void ForDifferences(const Visit& visit) const {
    for (const auto& n : nodes_.of_face) {
      if (n[0] < 0) continue;
      visit(n[0], n[1], 0.5f);  // the face across has the other half
      visit(n[1], n[2], 0.5f);
      visit(n[2], n[0], 0.5f);
    }
    for (const SeamPair& pair : pairs_) visit(pair.first, pair.second, Weight(pair));
  }

  void Apply(const Channels& x, Channels* y) const {
    *y = x.array().colwise() * screen_.array();
    ForDifferences([&](int32_t i, int32_t j, float weight) {
      const Eigen::RowVector3f flow = weight * (x.row(i) - x.row(j));
      y->row(i) += flow;
      y->row(j) -= flow;
    });
  }

  Eigen::VectorXf Diagonal() const {
    Eigen::VectorXf diagonal = screen_;
    ForDifferences([&](int32_t i, int32_t j, float weight) {
      diagonal[i] += weight;
      diagonal[j] += weight;
    });
    return diagonal;
  }

  const LabelNodes& nodes_;
  const std::vector<SeamPair>& pairs_;
  float seam_width_;
  Eigen::VectorXf screen_;
  Channels right_;
};

}  // namespace

std::vector<SeamPair> FindSeamPairs(const LabelEnergy& energy, const LabelNodes& nodes) {
  std::vector<SeamPair> pairs = PairsOfSeamEdges(energy, nodes);
  Merge(&pairs);
  MeasureDifferences(energy, nodes, &pairs);
  return pairs;
}

std::vector<Eigen::Vector3f> LevelSeams(const LabelEnergy& energy, const LabelNodes& nodes,
                                        const std::vector<SeamPair>& pairs,
                                        const LevellingOptions& options) {
  return Leveller(energy, nodes, pairs, options).Solve();
}

}  // namespace lsmvs
