#pragma once

#include <cstddef>

#include "lsmvs/texturing/labels/view_labels.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct ExpansionOptions {
  // Faces that are moved together; more need more memory (about 60 bytes per face and thread) and
  // give slightly better seams.
  size_t faces_per_block = 1 << 16;
  // Sweeps over all blocks and photos; ends earlier when nothing changes. Blocks are shifted by
  // half a block in every second one.
  int num_cycles = 3;
};

// Lowers the energy of a labelling by expansion moves: for one photo after the other, all faces of
// a block that the photo shows may switch to it; the best such move is a minimum cut.
//   Y. Boykov, O. Veksler, R. Zabih: Fast approximate energy minimization via graph cuts, PAMI
//   2001.
// The result is within a factor of 2 max V / min V of the optimum for a single block. Blocks are
// faces that lie together in space; blocks that touch are not moved at the same time: the energy
// never grows, and neither threads nor memory change the result. Throws CancelledError.
void ExpandLabels(const LabelEnergy& energy, const ExpansionOptions& options, ViewSlots* slots,
                  const RunContext& context);

}  // namespace lsmvs
