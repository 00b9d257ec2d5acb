#pragma once

#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/sparse_model.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Models in one frame as one model: the images of the first in their registered order, then those
// of the second, and so on. Cameras, images and points are numbered anew; image a/b.jpg of the
// first model becomes 1/a/b.jpg. A photo that two models have is two images. Rigs and frames are
// dropped.
SparseModel JoinSparseModels(const std::vector<SparseModel>& models);

// The scene of several workspaces in one frame.
struct JoinedScene {
  Scene whole;
  // For each workspace its views under their own names, with the poses and the world_offset that
  // they have in the whole; without points.
  std::vector<Scene> parts;
};

// The scene of the joined model, as MakeScene makes it, without looking at photos. Throws what
// ReadSparseModel and MakeScene throw.
JoinedScene LoadJoinedScene(const std::vector<DenseWorkspace>& workspaces, bool ignore_distortion);

}  // namespace lsmvs
