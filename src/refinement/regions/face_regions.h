#pragma once

#include <cstdint>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// Connected patches of faces of about equal size: the units that a step is accepted or rejected in.
struct FaceRegions {
  int count = 0;
  std::vector<int32_t> of_face;  // #F
};

// Grows patches of up to `faces_per_region` faces breadth first over shared edges, from the lowest
// face that is left. Patches of less than a quarter of that join the neighbour with the lowest
// number, if there is one. O(#F).
FaceRegions GrowFaceRegions(const TriangleMesh& mesh, int faces_per_region);

// #V: the region of the first face of each vertex; -1 at vertices without faces. O(#F).
std::vector<int32_t> RegionsOfVertices(const TriangleMesh& mesh, const FaceRegions& regions);

// Puts the faces in the order of a space-filling curve, and the vertices (with their places in
// `rest`, #V) in the order in which faces first use them; vertices without faces are dropped. What
// works through the mesh then finds near to it what it needs. O(#V + #F).
void OrderAlongCurve(TriangleMesh* mesh, std::vector<Eigen::Vector3d>* rest);

// The same in the order of the regions; faces of a region keep theirs.
void OrderByRegions(const FaceRegions& regions, TriangleMesh* mesh,
                    std::vector<Eigen::Vector3d>* rest);

}  // namespace lsmvs
