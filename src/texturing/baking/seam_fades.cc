#include "lsmvs/texturing/baking/seam_fades.h"

#include <algorithm>
#include <queue>
#include <tuple>

#include "lsmvs/mesh/by_vertex.h"

namespace lsmvs {

namespace {

constexpr float kMaxDifference = 16;  // grey levels
// Of the width, where photos differ more.
constexpr float kNarrow = 0.25f;
// A photo takes part where its quality is at least this part of that of the face's own.
constexpr float kLeastQuality = 0.15f;

// A photo at a vertex, at a distance from its own faces.
struct Reach {
  float distance_px;
  uint32_t vertex;
  int32_t view_idx;
  Eigen::Vector3f offset;

  bool operator>(const Reach& other) const {
    return std::tie(distance_px, vertex, view_idx) >
           std::tie(other.distance_px, other.vertex, other.view_idx);
  }
};

class FadeFinder {
 public:
  FadeFinder(const LabelEnergy& energy, const LabelNodes& nodes,
             const std::vector<Eigen::Vector3f>& offsets, double width_px)
      : energy_(energy),
        nodes_(nodes),
        offsets_(offsets),
        width_px_(static_cast<float>(width_px)),
        nodes_of_(energy.mesh().vertices.size(), nodes.size(),
                  [&](size_t n) { return static_cast<size_t>(nodes.vertex[n]); }),
        corners_of_(CornersByVertex(energy.mesh().vertices.size(), energy.mesh().faces)),
        shares_(energy.mesh().vertices.size()) {}

  SeamFades Run() {
    BeginAtSeams();
    Spread();
    SeamFades fades;
    fades.begin.push_back(0);
    for (size_t v = 0; v < shares_.size(); ++v) {
      Finish(v, &shares_[v]);
      fades.shares.insert(fades.shares.end(), shares_[v].begin(), shares_[v].end());
      fades.begin.push_back(static_cast<uint32_t>(fades.shares.size()));
    }
    return fades;
  }

 private:
  struct Fit {
    bool is_seen, agrees;
  };

  size_t VertexOf(size_t corner) const {
    return static_cast<size_t>(energy_.mesh().faces[corner / 3][static_cast<int>(corner % 3)]);
  }
  bool HasLabel(size_t face) const { return nodes_.of_face[face][0] >= 0; }

  void BeginAtSeams() {
    for (size_t v = 0; v < shares_.size(); ++v) {
      const auto nodes = nodes_of_.Of(v);
      if (nodes.size() < 2) continue;
      for (const uint32_t n : nodes) {
        queue_.push({0, static_cast<uint32_t>(v), nodes_.label[n], offsets_[n]});
      }
    }
  }

  // The nearest first.
  void Spread() {
    while (!queue_.empty()) {
      const Reach reach = queue_.top();
      queue_.pop();
      if (HasShare(reach)) continue;
      const Fit fit = FitAt(reach);
      if (!fit.is_seen) continue;
      const float width_px = fit.agrees ? width_px_ : kNarrow * width_px_;
      if (reach.distance_px >= width_px) continue;
      shares_[reach.vertex].push_back(
          {reach.view_idx, 1 - reach.distance_px / width_px, reach.offset});
      for (const uint32_t c : corners_of_.Of(reach.vertex)) Step(reach, c);
    }
  }

  // Along the two edges of a face.
  void Step(const Reach& from, size_t corner) {
    const size_t f = corner / 3;
    if (!HasLabel(f)) return;
    for (const size_t turn : {1, 2}) {
      const size_t there = (corner % 3 + turn) % 3;
      const size_t side = turn == 1 ? corner % 3 : there;
      Reach next = from;
      next.vertex = static_cast<uint32_t>(VertexOf(3 * f + there));
      next.distance_px += static_cast<float>(energy_.LengthPx(f, static_cast<int>(side)));
      if (next.distance_px < width_px_ && !IsOwn(next)) queue_.push(next);
    }
  }

  bool HasShare(const Reach& reach) const {
    const auto& shares = shares_[reach.vertex];
    return std::any_of(shares.begin(), shares.end(),
                       [&](const PhotoShare& s) { return s.view_idx == reach.view_idx; });
  }

  // Whether a face at the vertex has this label.
  bool IsOwn(const Reach& reach) const {
    const auto nodes = nodes_of_.Of(reach.vertex);
    return std::any_of(nodes.begin(), nodes.end(),
                       [&](uint32_t n) { return nodes_.label[n] == reach.view_idx; });
  }

  Fit FitAt(const Reach& reach) const {
    Fit fit = {true, true};
    for (const uint32_t c : corners_of_.Of(reach.vertex)) {
      const size_t f = c / 3;
      if (!HasLabel(f)) continue;
      const auto node = static_cast<size_t>(nodes_.of_face[f][c % 3]);
      if (nodes_.label[node] == reach.view_idx) continue;
      const Candidate* other = energy_.candidates().Find(f, reach.view_idx);
      const Candidate* own = energy_.candidates().Find(f, nodes_.label[node]);
      if (other == nullptr || other->quality < kLeastQuality * own->quality) return {false, false};
      const Eigen::Vector3f difference =
          own->color.cast<float>() + offsets_[node] - other->color.cast<float>() - reach.offset;
      fit.agrees &= difference.cwiseAbs().maxCoeff() <= kMaxDifference;
    }
    return fit;
  }

  void Finish(size_t v, std::vector<PhotoShare>* shares) const {
    if (shares->empty()) return;
    const auto nodes = nodes_of_.Of(v);
    if (nodes.size() == 1) {
      shares->push_back({nodes_.label[nodes[0]], 1, offsets_[nodes[0]]});
    } else if (std::none_of(shares->begin(), shares->end(),
                            [](const PhotoShare& s) { return s.weight == 1; })) {
      shares->clear();  // no photo sees to all sides
    }
    float sum = 0;
    for (const PhotoShare& s : *shares) sum += s.weight;
    for (PhotoShare& s : *shares) s.weight /= sum;
    std::sort(shares->begin(), shares->end(),
              [](const PhotoShare& a, const PhotoShare& b) { return a.view_idx < b.view_idx; });
  }

  const LabelEnergy& energy_;
  const LabelNodes& nodes_;
  const std::vector<Eigen::Vector3f>& offsets_;
  float width_px_;
  ByVertex nodes_of_, corners_of_;
  std::vector<std::vector<PhotoShare>> shares_;
  std::priority_queue<Reach, std::vector<Reach>, std::greater<>> queue_;
};

}  // namespace

SeamFades FindSeamFades(const LabelEnergy& energy, const LabelNodes& nodes,
                        const std::vector<Eigen::Vector3f>& offsets, double width_px) {
  if (!(width_px > 0)) {
    return {std::vector<uint32_t>(energy.mesh().vertices.size() + 1, 0), {}};
  }
  return FadeFinder(energy, nodes, offsets, width_px).Run();
}

}  // namespace lsmvs
