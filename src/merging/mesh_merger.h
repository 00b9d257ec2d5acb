#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

enum class MergingMethod {
  kAuto,        // the surface cut where the meshes agree, tetrahedra elsewhere
  kTetrahedra,  // a new surface through both meshes' vertices in the whole overlap
  kSurface,     // the surface cut everywhere
};

enum class ConflictWinner {
  kBetterSeen,  // the mesh whose vertices more photos see; without views the finer one
  kNewer,       // the mesh whose file was modified last
};

struct MeshMergerOptions {
  MergingMethod method = MergingMethod::kAuto;
  // Which mesh is right where they contradict each other: one stands in space that the other's
  // views saw empty, or a patch of one parts from the other, which goes on.
  ConflictWinner conflict_winner = ConflictWinner::kBetterSeen;
  // Largest median distance between two meshes where they overlap, in edge lengths of the coarser.
  // Up to here it is absorbed in a band around the seam; beyond, the meshes are refused.
  double max_offset = 4;
  // Width of the zone along the ends of a mesh, in edge lengths, in which the other one is
  // preferred: reconstructions are worst at their ends. Where the overlap is narrower, the seam
  // runs in its middle.
  double inset = 3;

  // "MeshMerging.<field>".
  void Describe(OptionSet* options);
  bool Check(std::string* error) const { return CheckOptions(*this, error); }
};

struct MergingInput {
  std::string name;  // for messages: its path
  TriangleMesh mesh;
  // Views that see vertex v, positions in the scene's views: view_idxs[view_begin[v] ..
  // view_begin[v+1]). Both empty: not known.
  std::vector<uint64_t> view_begin;
  std::vector<uint32_t> view_idxs;
  int64_t modification_time = 0;
};

struct MeshMergerCounters {
  size_t num_dropped_faces = 0;    // of the inputs, of their overlaps
  size_t num_new_faces = 0;        // that fill gaps between the inputs
  size_t num_moved_vertices = 0;   // of the inputs
  size_t num_conflict_faces = 0;   // of the inputs, that contradicted another mesh
  size_t num_repaired_faces = 0;   // of the inputs: degenerate or duplicate, dropped
  size_t num_split_vertices = 0;   // of the inputs: copies made to have manifolds
  size_t num_open_seam_edges = 0;  // edges along seams that found no partner
  size_t num_seam_crossings = 0;   // pairs of faces at seams that cross
  double max_offset = 0;           // largest median distance between two meshes, world units
  double max_offset_edges = 0;     // the same in edge lengths
};

struct MergedMesh {
  // Normals and quality if all inputs have them, colours if one has: vertices of the others are
  // grey. Normals of changed vertices are new.
  TriangleMesh mesh;
  // As in MergingInput; empty unless all inputs have views.
  std::vector<uint64_t> view_begin;
  std::vector<uint32_t> view_idxs;
  MeshMergerCounters counters;
  std::vector<std::string> messages;  // what the user should know, one sentence each
};

// One mesh of several that overlap, in one frame, whatever made them: each place is shown by one of
// them, the finer one where several are, and they are joined along seams. Manifold and oriented
// (inputs that are not are repaired: vertices are split); no double surface in the overlap; closed
// where the inputs cover a closed surface together. Vertices away from seams keep their position
// bit for bit, and their order. Holes of one mesh that another covers are filled. `views`: those
// that the inputs' views are about; may be empty.
//   H.-H. Vu: Large-scale and high-quality multi-view stereo, PhD thesis, 2011, chapter 5.2.
// The result has the same bytes for any order of the inputs and any number of threads.
//
// Throws InputError, with what was measured, for a mesh without faces, faces that are not oriented
// alike, meshes that do not overlap, that are inside out to each other, or that are farther apart
// than options.max_offset; UsageError for options out of range or fewer than two inputs;
// CancelledError. Memory: the inputs and the result, and about 600 bytes per face near overlaps; 20
// microseconds a face there.
MergedMesh MergeMeshes(std::vector<MergingInput> inputs, const std::vector<View>& views,
                       const MeshMergerOptions& options, const RunContext& context);

}  // namespace lsmvs
