#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Photos that seams of a texture are compared with; refers to what it is made of.
struct SeamPhotos {
  const MeshTracer& tracer;  // of the mesh
  const Scene& scene;
  const ImageStore& images;
};

// Two points of a surface close to each other, with the normals there (any length).
struct PointPair {
  Eigen::Vector3d a, b, normal_a, normal_b;  // world
};

// What a photo shows between the two points of each pair: the mean difference of their colours over
// the channels [grey levels], in the photo that shows them largest of those that see both. Empty
// where none does. One photo at a time is asked for. O(pairs * (views + log F)).
std::vector<std::optional<float>> MeasurePhotoSteps(const std::vector<PointPair>& pairs,
                                                    const SeamPhotos& photos,
                                                    const RunContext& context);

}  // namespace lsmvs
