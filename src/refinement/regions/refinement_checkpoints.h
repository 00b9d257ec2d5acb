#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/util/checkpoint_folder.h"

namespace lsmvs {

// What the refinement is left with after a level.
struct RefinementState {
  TriangleMesh* mesh;                   // vertices and faces
  std::vector<Eigen::Vector3d>* input;  // #V: where each vertex lies on the input surface
  FacePairs* pairs;                     // pairs of each face, but not their sizes
  RefinementResult* result;             // counts
};

// Finished steps of a refinement: the levels 0, 1, ... in the order in which they are worked on,
// then the judged mesh. Levels take turns in two sets of files, so that the last one that was
// finished is whole while the next is written.
class RefinementCheckpoints {
 public:
  explicit RefinementCheckpoints(const CheckpointFolder& folder) : folder_(folder) {}

  // How many levels of `num_levels` an earlier run had finished.
  int NumLevels(int num_levels) const;
  void WriteLevel(int number, const RefinementState& state) const;
  void ReadLevel(int number, const RefinementState& state) const;

  // The mesh with its quality, and what the guard counted.
  bool HasJudged() const { return folder_.HasFinished("judged"); }
  void WriteJudged(const RefinementResult& result) const;
  void ReadJudged(RefinementResult* result) const;

  // Bytes on disk for a mesh of so many faces with so many pairs a face.
  static size_t Bytes(size_t num_faces, int pairs_per_face);

 private:
  const CheckpointFolder& folder_;
};

}  // namespace lsmvs
