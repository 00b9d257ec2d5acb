#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "lsmvs/image/raster.h"

namespace lsmvs::internal {

// Compact depth and normal maps.
//
// A file is a line "lsmvs-map KIND WIDTH HEIGHT SMALLEST STEP BYTES 2", KIND being depth or normal,
// padded with blanks to 96 bytes, and so many bytes of zstd. In these are: one bit per pixel, the
// first pixel's lowest, set where there is a value; then for each channel the lower bytes of all
// pixels, and the upper ones, of numbers that say how far the pixel's code is from what the pixels
// to the left and above foretell: left + above - their corner, but within left and above; left
// where there is no corner; the one that is there, else 0. Of the two ways round the codes the
// shorter one is taken, and 0, -1, 1, -2, ... are written as 0, 1, 2, 3, ...
//   depth   one channel: 1 + round(log(depth / SMALLEST) / STEP), of 65535 codes. STEP is a 65534th
//           of the range of the map's depths, and at least 0.05 / the longer side: half a step
//           moves a point by less than a 40th of a pixel's size
//   normal  two channels: 1 + round(255 (1 + x + y)), 1 + round(255 (1 + x - y)) of the normal over
//           |x| + |y| + |z|, z < 0 (octahedral mapping of the half sphere), of 511 codes

enum class MapKind { kDepth, kNormal };

// Whether the file begins as a compact map.
bool IsCompactMap(const std::filesystem::path& path);
// Width x height of a map that is whole, by its length.
std::optional<Eigen::Vector2i> CompactMapSize(const std::filesystem::path& path, MapKind kind);

// Throws InputError.
Raster<float> ReadCompactDepths(const std::filesystem::path& path, const std::string& remedy);
Raster<Eigen::Vector3f> ReadCompactNormals(const std::filesystem::path& path,
                                           const std::string& remedy);

// Atomic. Throw FileSystemError. Depths that are not positive and finite are unknown.
void WriteCompactDepths(const std::filesystem::path& path, const Raster<float>& depths);
void WriteCompactNormals(const std::filesystem::path& path, const Raster<Eigen::Vector3f>& normals);

// The normal as it will be read.
Eigen::Vector3f RoundNormal(const Eigen::Vector3f& normal);

}  // namespace lsmvs::internal
