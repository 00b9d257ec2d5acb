#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lsmvs/refinement/photo/pair_selection.h"
#include "lsmvs/refinement/photo/photo_evaluation.h"
#include "lsmvs/util/shared_loop.h"

namespace lsmvs {

// The refinement's loops that helpers take part in, and what they are sent for them. Scene, photos
// and options a helper has itself.
enum RefinementLoop : int { kPairSelectionLoop = 1, kPhotoTermsLoop };

enum RefinementStateKey : int {
  kFacesState = 1,
  kVerticesState,
  kPairsState,       // of the photo terms
  kEvaluationState,  // level, directions, what is active
  kSelectionState,   // options, views, candidates, regions
  kUsedPairsState,   // pairs that come last, if any
};

// What EvaluatePhotoTerms is called with.
struct EvaluationState {
  int level = 0;
  std::vector<Eigen::Vector3d> directions;
  std::vector<uint8_t> active;
};
std::vector<LoopState> PhotoTermsStates(const TriangleMesh& mesh,
                                        const std::vector<Eigen::Vector3d>& directions,
                                        const FacePairs& pairs, const std::vector<uint8_t>& active,
                                        int level);
std::string EncodeContribution(const ViewContribution& view);
// Throws Error(kInternal) if it is about other faces than the mesh has.
ViewContribution DecodeContribution(std::string_view bytes, size_t num_faces);

// What a PairSelection is made with, but for the mesh and the pairs that come last.
struct SelectionState {
  PairSelectionOptions options;
  std::vector<PosedCamera> views;
  std::vector<ViewPair> candidates;
  FaceRegions regions;
  bool has_used = false;
};
std::vector<LoopState> PairSelectionStates(const std::vector<PosedCamera>& views,
                                           const std::vector<ViewPair>& candidates,
                                           const TriangleMesh& mesh, const FaceRegions& regions,
                                           const FacePairs* used,
                                           const PairSelectionOptions& options);
std::string EncodeBlockPairs(const BlockPairs& block);
BlockPairs DecodeBlockPairs(std::string_view bytes);

// What the states' bytes say.
std::vector<Eigen::Vector3i> DecodeFaces(std::string_view bytes);
std::vector<Eigen::Vector3d> DecodeVertices(std::string_view bytes);
// Without pixel_size and area_px, which the loops do not need.
FacePairs DecodePairs(std::string_view bytes);
EvaluationState DecodeEvaluation(std::string_view bytes);
SelectionState DecodeSelection(std::string_view bytes);

}  // namespace lsmvs
