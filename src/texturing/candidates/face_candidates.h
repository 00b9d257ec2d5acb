#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// A photo that shows a face.
struct Candidate {
  int32_t view_idx = -1;
  // Pixels of the photo per world unit in the direction in which the photo shows the face smallest,
  // times factors in (0, 1] for what speaks against the photo. > 0.
  float quality = 0;
  Color color = Color::Zero();  // mean of the face in the photo
  uint8_t sharpness = 0;        // see SharpnessMap
};

// The best photos of each face, best first; of equally good ones the one that was added first.
class FaceCandidates {
 public:
  FaceCandidates(size_t num_faces, int max_per_face)
      : max_per_face_(static_cast<size_t>(max_per_face)),
        counts_(num_faces, 0),
        density_(num_faces, 0.0f),
        candidates_(num_faces * max_per_face_) {}

  size_t num_faces() const { return counts_.size(); }

  // `density`: pixels per world unit, without factors.
  void Add(size_t face, Candidate candidate, float density);

  std::span<const Candidate> Of(size_t face) const { return {Begin(face), counts_[face]}; }
  std::span<Candidate> Of(size_t face) { return {Begin(face), counts_[face]}; }
  // The face's candidate of a view, or null.
  const Candidate* Find(size_t face, int view_idx) const;
  // Highest density that any photo has of the face, pixels per world unit; 0 if none shows it.
  float density(size_t face) const { return density_[face]; }

  // Position of the face's first candidate among those of all faces; after Compact().
  size_t FirstIndex(size_t face) const { return begin_[face]; }
  size_t num_candidates() const { return candidates_.size(); }

  // Drops the candidates of a face of which `is_kept(k)` does not hold.
  template <class IsKept>
  void Filter(size_t face, const IsKept& is_kept) {
    Candidate* begin = Begin(face);
    uint8_t count = 0;
    for (uint8_t k = 0; k < counts_[face]; ++k) {
      if (is_kept(size_t{k})) begin[count++] = begin[k];
    }
    counts_[face] = count;
  }

  // Orders the candidates of a face anew after their qualities have changed.
  void Sort(size_t face);
  // Lets go of the memory of places that are not used. No Add() afterwards.
  void Compact();

 private:
  size_t Place(size_t face) const { return begin_.empty() ? face * max_per_face_ : begin_[face]; }
  const Candidate* Begin(size_t face) const { return candidates_.data() + Place(face); }
  Candidate* Begin(size_t face) { return candidates_.data() + Place(face); }

  size_t max_per_face_;
  std::vector<uint8_t> counts_;
  std::vector<float> density_;
  std::vector<Candidate> candidates_;
  std::vector<uint32_t> begin_;  // after Compact()
};

}  // namespace lsmvs
