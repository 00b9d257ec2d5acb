#include "lsmvs/refinement/sharing/loop_states.h"

#include <algorithm>

#include "lsmvs/util/byte_string.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

LoopState State(RefinementStateKey key, ByteWriter* writer) {
  return {key, std::make_shared<const std::string>(writer->Take())};
}

LoopState FacesState(const TriangleMesh& mesh) {
  return State(kFacesState, &ByteWriter().PutAll(mesh.faces));
}

LoopState VerticesState(const TriangleMesh& mesh) {
  return State(kVerticesState, &ByteWriter().PutAll(mesh.vertices));
}

LoopState PairsState(RefinementStateKey key, const FacePairs& pairs) {
  return State(key, &ByteWriter().Put(pairs.per_face).PutAll(pairs.pairs).PutAll(pairs.of_face));
}

}  // namespace

std::vector<LoopState> PhotoTermsStates(const TriangleMesh& mesh,
                                        const std::vector<Eigen::Vector3d>& directions,
                                        const FacePairs& pairs, const std::vector<uint8_t>& active,
                                        int level) {
  return {FacesState(mesh), VerticesState(mesh), PairsState(kPairsState, pairs),
          State(kEvaluationState, &ByteWriter().Put(level).PutAll(directions).PutAll(active))};
}

std::string EncodeContribution(const ViewContribution& view) {
  return ByteWriter().PutAll(view.faces).PutAll(view.sums).Take();
}

ViewContribution DecodeContribution(std::string_view bytes, size_t num_faces) {
  ByteReader reader(bytes);
  ViewContribution view;
  view.faces = reader.GetAll<int32_t>();
  view.sums = reader.GetAll<FaceSums>();
  const bool fits = view.sums.size() == view.faces.size() &&
                    std::all_of(view.faces.begin(), view.faces.end(), [num_faces](int32_t face) {
                      return face >= 0 && static_cast<size_t>(face) < num_faces;
                    });
  if (!fits)
    throw Error(ExitCode::kInternal, "a helper tells of faces that the mesh does not have");
  return view;
}

std::vector<LoopState> PairSelectionStates(const std::vector<PosedCamera>& views,
                                           const std::vector<ViewPair>& candidates,
                                           const TriangleMesh& mesh, const FaceRegions& regions,
                                           const FacePairs* used,
                                           const PairSelectionOptions& options) {
  ByteWriter selection;
  selection.Put(options).PutAll(views).PutAll(candidates);
  selection.Put(regions.count).PutAll(regions.of_face).Put(used != nullptr);
  std::vector<LoopState> states = {FacesState(mesh), VerticesState(mesh),
                                   State(kSelectionState, &selection)};
  if (used != nullptr) states.push_back(PairsState(kUsedPairsState, *used));
  return states;
}

std::string EncodeBlockPairs(const BlockPairs& block) {
  return ByteWriter().PutAll(block.of_face).PutAll(block.pixel_size).PutAll(block.area_px).Take();
}

BlockPairs DecodeBlockPairs(std::string_view bytes) {
  ByteReader reader(bytes);
  BlockPairs block;
  block.of_face = reader.GetAll<int32_t>();
  block.pixel_size = reader.GetAll<float>();
  block.area_px = reader.GetAll<float>();
  return block;
}

std::vector<Eigen::Vector3i> DecodeFaces(std::string_view bytes) {
  return ByteReader(bytes).GetAll<Eigen::Vector3i>();
}

std::vector<Eigen::Vector3d> DecodeVertices(std::string_view bytes) {
  return ByteReader(bytes).GetAll<Eigen::Vector3d>();
}

FacePairs DecodePairs(std::string_view bytes) {
  ByteReader reader(bytes);
  FacePairs pairs;
  pairs.per_face = reader.Get<int>();
  pairs.pairs = reader.GetAll<ViewPair>();
  pairs.of_face = reader.GetAll<int32_t>();
  return pairs;
}

EvaluationState DecodeEvaluation(std::string_view bytes) {
  ByteReader reader(bytes);
  EvaluationState state;
  state.level = reader.Get<int>();
  state.directions = reader.GetAll<Eigen::Vector3d>();
  state.active = reader.GetAll<uint8_t>();
  return state;
}

SelectionState DecodeSelection(std::string_view bytes) {
  ByteReader reader(bytes);
  SelectionState state;
  state.options = reader.Get<PairSelectionOptions>();
  state.views = reader.GetAll<PosedCamera>();
  state.candidates = reader.GetAll<ViewPair>();
  state.regions.count = reader.Get<int>();
  state.regions.of_face = reader.GetAll<int32_t>();
  state.has_used = reader.Get<bool>();
  return state;
}

}  // namespace lsmvs
