#include "lsmvs/texturing/baking/seam_fades.h"

#include <limits>

namespace lsmvs {

namespace {

constexpr float kMaxDifference = 16;  // grey levels

class FadeFinder {
 public:
  FadeFinder(const LabelEnergy& energy, const LabelNodes& nodes,
             const std::vector<Eigen::Vector3f>& offsets, double width_px)
      : energy_(energy),
        nodes_(nodes),
        offsets_(offsets),
        width_px_(static_cast<float>(width_px)),
        distance_px_(nodes.size(), std::numeric_limits<float>::infinity()),
        fades_(nodes.size()) {}

  std::vector<SeamFade> Run(const std::vector<SeamPair>& pairs) {
    Begin(pairs);
    while (Spread()) {
    }
    for (size_t n = 0; n < fades_.size(); ++n) {
      if (fades_[n].view_idx >= 0) fades_[n].weight = 0.5f * (1 - distance_px_[n] / width_px_);
    }
    StopWherePhotosDiffer();
    return std::move(fades_);
  }

 private:
  // Where three photos meet, the one with the longest seam counts.
  void Begin(const std::vector<SeamPair>& pairs) {
    std::vector<float> longest(nodes_.size(), 0.0f);
    const auto begin = [&](int32_t node, int32_t beyond, float length_px) {
      const auto n = static_cast<size_t>(node), other = static_cast<size_t>(beyond);
      if (length_px <= longest[n]) return;
      longest[n] = length_px;
      distance_px_[n] = 0;
      fades_[n] = {nodes_.label[other], 0, offsets_[other]};
    };
    for (const SeamPair& pair : pairs) {
      begin(pair.first, pair.second, pair.length_px);
      begin(pair.second, pair.first, pair.length_px);
    }
  }

  // Along the edges of all faces; false when nothing comes nearer.
  bool Spread() {
    bool any = false;
    for (size_t f = 0; f < nodes_.of_face.size(); ++f) {
      const auto& n = nodes_.of_face[f];
      if (n[0] < 0) continue;
      for (int side = 0; side < 3; ++side) {
        const auto a = static_cast<size_t>(n[static_cast<size_t>(side)]);
        const auto b = static_cast<size_t>(n[static_cast<size_t>((side + 1) % 3)]);
        if (std::min(distance_px_[a], distance_px_[b]) >= width_px_) continue;
        const auto length_px = static_cast<float>(energy_.LengthPx(f, side));
        any |= Step(a, b, length_px);
        any |= Step(b, a, length_px);
      }
    }
    return any;
  }

  bool Step(size_t from, size_t to, float length_px) {
    const float distance_px = distance_px_[from] + length_px;
    if (distance_px >= width_px_ || distance_px >= distance_px_[to]) return false;
    distance_px_[to] = distance_px;
    fades_[to] = fades_[from];
    return true;
  }

  void StopWherePhotosDiffer() {
    for (size_t f = 0; f < nodes_.of_face.size(); ++f) {
      for (const int32_t node : nodes_.of_face[f]) {
        if (node < 0) continue;
        SeamFade& fade = fades_[static_cast<size_t>(node)];
        if (fade.view_idx >= 0 && !Agrees(f, static_cast<size_t>(node), fade)) fade.weight = 0;
      }
    }
  }

  bool Agrees(size_t f, size_t node, const SeamFade& fade) const {
    const Candidate* own = energy_.candidates().Find(f, nodes_.label[node]);
    const Candidate* beyond = energy_.candidates().Find(f, fade.view_idx);
    if (beyond == nullptr) return false;
    const Eigen::Vector3f difference =
        own->color.cast<float>() + offsets_[node] - beyond->color.cast<float>() - fade.offset;
    return difference.cwiseAbs().maxCoeff() <= kMaxDifference;
  }

  const LabelEnergy& energy_;
  const LabelNodes& nodes_;
  const std::vector<Eigen::Vector3f>& offsets_;
  float width_px_;
  std::vector<float> distance_px_;
  std::vector<SeamFade> fades_;
};

}  // namespace

std::vector<SeamFade> FindSeamFades(const LabelEnergy& energy, const LabelNodes& nodes,
                                    const std::vector<SeamPair>& pairs,
                                    const std::vector<Eigen::Vector3f>& offsets, double width_px) {
  if (!(width_px > 0)) return std::vector<SeamFade>(nodes.size());
  return FadeFinder(energy, nodes, offsets, width_px).Run(pairs);
}

}  // namespace lsmvs
