#include "lsmvs/merging/seam/rim_smoothing.h"

#include <algorithm>

#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

size_t Index(int32_t i) { return static_cast<size_t>(i); }

class RimSmoother {
 public:
  RimSmoother(const MeshBand& band, std::vector<uint8_t>* kept)
      : band_(band),
        kept_(*kept),
        neighbors_(FindFaceNeighbors(band.mesh.faces, band.mesh.vertices.size())) {}

  void Run(size_t min_num_faces) {
    bool is_changed = true;
    while (is_changed) {
      is_changed = DropTeeth();
      is_changed |= DropTouchingFans();
    }
    DropSmallPieces(min_num_faces);
  }

 private:
  // Sides of a face across which a face was taken out.
  int NumRimSides(size_t f) const {
    int count = 0;
    for (const int32_t other : neighbors_[f]) count += other >= 0 && !kept_[Index(other)];
    return count;
  }

  bool IsFixed(size_t f) const {
    const Eigen::Vector3i& face = band_.mesh.faces[f];
    return std::any_of(face.begin(), face.end(),
                       [&](int v) { return band_.is_fixed[Index(v)] != 0; });
  }

  bool DropTeeth() {
    std::vector<size_t> teeth;
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (kept_[f] && NumRimSides(f) >= 2 && !IsFixed(f)) teeth.push_back(f);
    }
    for (const size_t f : teeth) kept_[f] = 0;
    return !teeth.empty();
  }

  // Kept faces must form one fan at each vertex, unless they did not before.
  bool DropTouchingFans() {
    const size_t num_vertices = band_.mesh.vertices.size();
    std::vector<uint8_t> on_rim(num_vertices, 0);
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f] || NumRimSides(f) == 0) continue;
      for (int k = 0; k < 3; ++k) {
        const int32_t other = neighbors_[f][Index(k)];
        if (other < 0 || kept_[Index(other)]) continue;
        on_rim[Index(band_.mesh.faces[f][k])] = on_rim[Index(band_.mesh.faces[f][(k + 1) % 3])] = 1;
      }
    }
    // Corners that are joined across kept edges.
    DisjointSets fans(3 * kept_.size());
    const auto corner_of = [&](size_t f, int v) {
      const Eigen::Vector3i& face = band_.mesh.faces[f];
      return static_cast<uint32_t>(3 * f + (face[0] == v ? 0 : face[1] == v ? 1 : 2));
    };
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f]) continue;
      for (int k = 0; k < 3; ++k) {
        const int32_t other = neighbors_[f][Index(k)];
        if (other < 0 || !kept_[Index(other)]) continue;
        for (const int v : {band_.mesh.faces[f][k], band_.mesh.faces[f][(k + 1) % 3]}) {
          if (on_rim[Index(v)]) fans.Unite(corner_of(f, v), corner_of(Index(other), v));
        }
      }
    }
    std::vector<uint32_t> first_fan(num_vertices, 0xFFFFFFFFu);
    std::vector<uint8_t> is_touching(num_vertices, 0);
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f]) continue;
      for (int k = 0; k < 3; ++k) {
        const size_t v = Index(band_.mesh.faces[f][k]);
        if (!on_rim[v]) continue;
        const uint32_t fan = fans.Find(static_cast<uint32_t>(3 * f + Index(k)));
        if (first_fan[v] == 0xFFFFFFFFu) first_fan[v] = fan;
        is_touching[v] |= first_fan[v] != fan;
      }
    }
    bool is_changed = false;
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f] || IsFixed(f)) continue;
      const Eigen::Vector3i& face = band_.mesh.faces[f];
      if (std::any_of(face.begin(), face.end(),
                      [&](int v) { return is_touching[Index(v)] != 0; })) {
        kept_[f] = 0;
        is_changed = true;
      }
    }
    return is_changed;
  }

  void DropSmallPieces(size_t min_num_faces) {
    DisjointSets pieces(kept_.size());
    for (size_t f = 0; f < kept_.size(); ++f) {
      for (const int32_t other : neighbors_[f]) {
        if (kept_[f] && other >= 0 && kept_[Index(other)]) {
          pieces.Unite(static_cast<uint32_t>(f), static_cast<uint32_t>(other));
        }
      }
    }
    std::vector<size_t> size(kept_.size(), 0);
    std::vector<uint8_t> has_rim(kept_.size(), 0), is_anchored(kept_.size(), 0);
    for (size_t f = 0; f < kept_.size(); ++f) {
      if (!kept_[f]) continue;
      const uint32_t piece = pieces.Find(static_cast<uint32_t>(f));
      ++size[piece];
      has_rim[piece] |= NumRimSides(f) > 0;
      is_anchored[piece] |= IsFixed(f);
    }
    for (size_t f = 0; f < kept_.size(); ++f) {
      const uint32_t piece = pieces.Find(static_cast<uint32_t>(f));
      if (has_rim[piece] && !is_anchored[piece] && size[piece] < min_num_faces) kept_[f] = 0;
    }
  }

  const MeshBand& band_;
  std::vector<uint8_t>& kept_;
  FaceNeighbors neighbors_;
};

}  // namespace

void SmoothRim(const MeshBand& band, size_t min_num_faces, std::vector<uint8_t>* kept) {
  RimSmoother(band, kept).Run(min_num_faces);
}

}  // namespace lsmvs
