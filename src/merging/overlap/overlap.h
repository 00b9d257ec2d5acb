#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lsmvs/merging/overlap/mesh_band.h"
#include "lsmvs/merging/overlap/surface_index.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// One of two meshes that are merged, with what is known of its surface.
struct BandSurface {
  // Computes topology and frames of the band, and an index of its faces.
  explicit BandSurface(const MeshBand& band);

  const MeshBand* band;
  SurfaceTopology topology;
  VertexFrames frames;
  SurfaceIndex index;

  const TriangleMesh& mesh() const { return band->mesh; }
  // Mean of the edge lengths at a face's corners.
  double EdgeLengthAt(int32_t face) const;
  // Unit normal of the smoothed surface at a face.
  Eigen::Vector3d NormalAt(int32_t face) const;
  // Whether a point of a face lies on the border of the surface.
  bool IsAtBorder(int32_t face, const Eigen::Vector3d& point) const;
};

// The place of a surface that is the same as a vertex of the other.
struct SurfaceMatch {
  int32_t face = -1;       // of the other surface; -1: there is none
  bool at_border = false;  // the vertex lies beside the other surface, not over it
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double distance = 0;
};

// For each vertex of a surface the nearest place of another whose smoothed normal differs by less
// than 60 degrees, within `max_edges` edge lengths (of the coarser of both there). O(#V log #F).
std::vector<SurfaceMatch> MatchVertices(const BandSurface& surface, const BandSurface& other,
                                        double max_edges, const RunContext& context);

// Border vertices (#V) beyond which the other surface goes on: `num_edges` edge lengths (of the
// coarser) straight out from the border it is still there, within `max_edges`.
std::vector<uint8_t> FindEnds(const BandSurface& surface, const std::vector<SurfaceMatch>& matches,
                              const BandSurface& other, double num_edges, double max_edges,
                              const RunContext& context);

// Faces of `mesh` (#F) within about `reach` (between it and three times as far) of a face of
// `other`. O(#F); 8 bytes per face of `other` and cell of a grid of that size.
std::vector<uint8_t> FacesNear(const TriangleMesh& mesh, const TriangleMesh& other, double reach);

// How two overlapping surfaces lie to each other.
struct Registration {
  size_t num_over = 0;        // sampled vertices that lie over the inside of the other surface
  double offset = 0;          // median distance there
  double offset_edges = 0;    // the same in edge lengths (of the coarser of both there)
  double share_opposite = 0;  // of them, with the normal the other way round
  double least_distance = 0;  // of all samples; infinite where nothing is within reach
};

// Of vertices within `reach` of the other surface, up to some thousands.
Registration MeasureRegistration(const BandSurface& surface, const BandSurface& other, double reach,
                                 const RunContext& context);

}  // namespace lsmvs
