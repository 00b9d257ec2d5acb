#include "lsmvs/merging/mesh_merger.h"

namespace lsmvs {

void MeshMergerOptions::Describe(OptionSet* options) {
  options->AddEnum("MeshMerging.method", &method,
                   "How overlaps become one surface: surface keeps each place of one mesh and zips "
                   "them along a seam; tetrahedra makes a new surface through both meshes' "
                   "vertices; auto: surface where the meshes agree, tetrahedra elsewhere.",
                   {{"auto", MergingMethod::kAuto},
                    {"tetrahedra", MergingMethod::kTetrahedra},
                    {"surface", MergingMethod::kSurface}});
  options->AddEnum(
      "MeshMerging.conflict_winner", &conflict_winner,
      "Which mesh is right where they contradict each other, such as a car that drove "
      "away: the one that more photos see (without views the finer one), or the one "
      "whose file is newer.",
      {{"better_seen", ConflictWinner::kBetterSeen}, {"newer", ConflictWinner::kNewer}});
  options->Add("MeshMerging.max_offset", &max_offset,
               "Largest median distance between two meshes where they overlap, in edge lengths of "
               "the coarser; up to here it is absorbed around the seam, beyond it the meshes are "
               "refused.",
               {0.0, 20.0});
  options->Add("MeshMerging.inset", &inset,
               "Edge lengths that a seam keeps from where a mesh ends, if the overlap is wide "
               "enough.",
               {0.0, 50.0});
}

}  // namespace lsmvs
