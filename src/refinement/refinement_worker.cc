#include "lsmvs/refinement/refinement_worker.h"

#include <optional>
#include <utility>

#include "lsmvs/refinement/photo/photo_evaluation.h"
#include "lsmvs/refinement/sharing/loop_states.h"
#include "lsmvs/refinement/step/level_optimizer.h"

namespace lsmvs {

namespace {

class RefinementWorker : public LoopWorker {
 public:
  RefinementWorker(const Scene& scene, const ImageStore& images, const MeshRefinerOptions& options,
                   const RunContext& context)
      : scene_(scene), images_(images), options_(options), context_(context) {}

  void SetState(int key, std::string bytes) override {
    evaluation_.reset();  // refers to the states
    selection_.reset();
    if (key == kFacesState) mesh_.faces = DecodeFaces(bytes);
    if (key == kVerticesState) mesh_.vertices = DecodeVertices(bytes);
    if (key == kPairsState) pairs_ = DecodePairs(bytes);
    if (key == kEvaluationState) evaluation_state_ = DecodeEvaluation(bytes);
    if (key == kSelectionState) selection_state_ = DecodeSelection(bytes);
    if (key == kUsedPairsState) used_ = DecodePairs(bytes);
  }

  void Begin(int kind) override {
    if (kind == kPhotoTermsLoop) BeginEvaluation();
    if (kind == kPairSelectionLoop) BeginSelection();
  }

  std::string Compute(int kind, size_t item) override {
    if (kind == kPhotoTermsLoop) return EncodeContribution(evaluation_->Evaluate(item));
    return EncodeBlockPairs(selection_->Select(item));
  }

 private:
  void BeginEvaluation() {
    const int level = evaluation_state_.level;
    if (level != level_) {
      images_.Trim(0);
      level_ = level;
      views_ = MakeLevelViews(scene_, images_, level);
    }
    energy_options_ = MakePhotoEnergyOptions(options_, level, context_);
    evaluation_.emplace(images_, views_, mesh_, evaluation_state_.directions, pairs_,
                        evaluation_state_.active, energy_options_, context_);
  }

  void BeginSelection() {
    selection_state_.options.map_budget_bytes = context_.memory_budget_bytes / 4;
    selection_.emplace(selection_state_.views, selection_state_.candidates, mesh_,
                       selection_state_.regions, selection_state_.has_used ? &used_ : nullptr,
                       selection_state_.options, context_);
  }

  const Scene& scene_;
  const ImageStore& images_;
  const MeshRefinerOptions& options_;
  const RunContext& context_;
  TriangleMesh mesh_;
  FacePairs pairs_, used_;
  EvaluationState evaluation_state_;
  SelectionState selection_state_;
  PhotoEnergyOptions energy_options_;
  int level_ = -1;
  std::vector<PosedCamera> views_;
  std::optional<PhotoEvaluation> evaluation_;
  std::optional<PairSelection> selection_;
};

}  // namespace

std::unique_ptr<LoopWorker> MakeRefinementWorker(const Scene& scene, const ImageStore& images,
                                                 const MeshRefinerOptions& options,
                                                 const RunContext& context) {
  return std::make_unique<RefinementWorker>(scene, images, options, context);
}

}  // namespace lsmvs
