#pragma once

#include <string>
#include <vector>

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/surface_extraction.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/util/checkpoint_folder.h"

namespace lsmvs::internal {

// What the mesher keeps of its steps. While merged points are kept, their arrays need not be in
// memory: each step asks for what it needs.
class MesherCheckpoints {
 public:
  explicit MesherCheckpoints(const CheckpointFolder& folder) : folder_(folder) {}

  bool HasMerged() const { return folder_.HasFinished(kMerged); }
  bool HasLabels() const { return folder_.HasFinished(kLabels); }
  bool HasSurface() const { return folder_.HasFinished(kSurface); }

  // Leaves `positions` and the frame of the merged cloud and lets go of the rest.
  void WriteMerged(const VisibilityMesherCounters& counters, MergedCloud* cloud) const;
  // The same from an earlier run. `counters`: as they were when that step ended.
  void ReadMerged(VisibilityMesherCounters* counters, MergedCloud* cloud) const;
  // Parts of the merged cloud, if they were let go of.
  void LoadSights(MergedCloud* cloud) const;
  void LoadVertexOfPoint(MergedCloud* cloud) const;
  void LoadLooks(MergedCloud* cloud) const;  // normals and colours
  void DropSights(MergedCloud* cloud) const;

  // After the cut: which cells are on the source's side.
  void WriteLabels(const VisibilityMesherCounters& counters,
                   const Tetrahedralization& complex) const;
  void ReadLabels(VisibilityMesherCounters* counters, Tetrahedralization* complex) const;

  void WriteSurface(const VisibilityMesherCounters& counters, const ExtractedSurface& surface,
                    const std::vector<uint8_t>& point_is_free) const;
  void ReadSurface(VisibilityMesherCounters* counters, ExtractedSurface* surface,
                   std::vector<uint8_t>* point_is_free) const;

 private:
  static constexpr const char *kMerged = "merged", *kLabels = "labels", *kSurface = "surface";

  void WriteCounters(const char* step, const VisibilityMesherCounters& counters) const;
  void ReadCounters(const char* step, VisibilityMesherCounters* counters) const;

  const CheckpointFolder& folder_;
};

}  // namespace lsmvs::internal
