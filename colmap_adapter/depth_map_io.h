#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// COLMAP's depth and normal maps, and the one place where the half pixel is dealt with.
//
// A DepthMap's sample (column, row) lies on the ray through the pixel's centre (column + 0.5, row +
// 0.5). COLMAP's stereo and fusion take the sample as lying on the ray through (column, row). So
// every sample is moved along its own tangent plane; reading undoes what writing does, up to the
// rounding of a float. Samples without normal, or seen at less than 5 degrees from their plane,
// keep their depth.
//
// That reads every map as COLMAP's own fusion does, and corrects nothing in maps that its
// patch_match_stereo made.

// The formats that maps are written in. Both have the same names; which one a file has is seen from
// its beginning.
//   kColmap   COLMAP's: floats, 4 bytes per pixel for depth, 12 for the normal
//   kCompact  ours, 1.2 to 2 bytes per pixel for both: the depth within a 40th of a pixel's size,
//             the normal within a third of a degree (see files/compact_map.h)
enum class MapFormat { kColmap, kCompact };

// Width x height of the map, or nothing if it is missing or not complete (a killed run leaves
// cut-off files). Reads the header only and compares with the file's size.
std::optional<Eigen::Vector2i> CompleteMapSize(const std::filesystem::path& path, int channels);

// Whether the view has a complete depth map of the type, and a normal map of the same size or none.
bool HasDepthMap(const DenseWorkspace& workspace, const View& view, DepthMapKind type);

// The maps of one view; a map smaller than the image has the camera view.camera.Resized(width,
// height). The normal map may be missing: normals are derived from the depths then. Depths that
// are not finite or not positive become 0, normals that are not finite or point away from the
// camera become zero, the others get unit length. Throws InputError if the depth map is missing,
// either is truncated or malformed, their sizes differ, or they are larger than the image.
DepthMap ReadDepthMap(const DenseWorkspace& workspace, const View& view, DepthMapKind type);

// Writes both maps, atomically, the depth map last. Throws FileSystemError.
void WriteDepthMap(const DenseWorkspace& workspace, const View& view, DepthMapKind type,
                   const DepthMap& map, MapFormat format = MapFormat::kColmap);

// Writes the maps of a view in `to` in another format; `from` may be the same folder. False if they
// have it already, or are not there. Throws InputError and FileSystemError.
bool ConvertDepthMap(const DenseWorkspace& from, const View& view, DepthMapKind type,
                     MapFormat format, const DenseWorkspace& to);

// The maps of a workspace, read when they are asked for; keeps the most recently used ones, packed,
// up to `budget_bytes`, and gives them as PackedDepthMap keeps them. Views without complete maps
// give null. Thread-safe. `scene` must outlive the
// source.
std::unique_ptr<DepthMapSource> MakeDepthMapSource(const DenseWorkspace& workspace,
                                                   const Scene& scene, DepthMapKind type,
                                                   size_t budget_bytes);

// Moves all samples from the rays through pixel centres to those through their top-left corners, or
// back.
void MoveSamplesToPixelCorners(const PinholeCamera& full_size_camera, DepthMap* map);
void MoveSamplesToPixelCenters(const PinholeCamera& full_size_camera, DepthMap* map);

}  // namespace lsmvs
