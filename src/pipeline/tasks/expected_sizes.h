#pragma once

#include <cstdint>
#include <filesystem>

#include "lsmvs/pipeline/reconstruction.h"

namespace lsmvs {

// What stages make, for the plan: from the files where they are there, else from the photos' pixels
// and the tracks of the sparse model.

// Points of a cloud.
size_t ExpectedPoints(const Reconstruction& reconstruction, const std::filesystem::path& cloud);
// Clouds that are to be made are ours.
PointSpacing ExpectedSpacing(const std::filesystem::path& cloud);
// Views that see a point of a cloud of ours, in the mean.
double ExpectedViewsPerPoint(const Reconstruction& reconstruction);
// Faces of a mesh that the surface stage makes from the workspace's cloud.
size_t ExpectedFaces(const Reconstruction& reconstruction, const std::filesystem::path& mesh);

// Faces of the refined mesh, which simplification leaves few of.
size_t ExpectedRefinedFaces(const Reconstruction& reconstruction,
                            const std::filesystem::path& mesh);

// Memory below which a task that may work with a scratch file had better not start: every chunk
// would come and go too often.
size_t LeastBytes(size_t needed_bytes);

// On disk: a cloud with its visibility; a visibility mesh of so many Delaunay vertices with its
// own; a refined mesh.
uint64_t ExpectedCloudBytes(const Reconstruction& reconstruction, size_t num_points);
uint64_t ExpectedSurfaceBytes(const Reconstruction& reconstruction, size_t num_vertices);
uint64_t ExpectedRefinedBytes(size_t num_input_faces);
// A textured mesh with its pages.
uint64_t ExpectedTexturedBytes(const Reconstruction& reconstruction, size_t num_faces);

}  // namespace lsmvs
