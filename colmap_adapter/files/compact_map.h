#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "lsmvs/image/raster.h"

namespace lsmvs::internal {

// Compact depth and normal maps.
//
// A file is a line "lsmvs-map KIND WIDTH HEIGHT SMALLEST LARGEST BYTES", KIND being depth or
// normal, padded with blanks to 96 bytes, and so many bytes of zstd.
//   depth   16 bits per pixel: 0 unknown, else 1 + round(65534 log(depth / SMALLEST) / log(LARGEST
//   /
//           SMALLEST)); each less the pixel to its left, modulo 2^16; all low bytes, then all high
//   normal  8 bits u, 8 bits v: 0 unknown, else 1 + round(127 (1 + x + y)), 1 + round(127 (1 + x -
//           y)) of the normal over |x| + |y| + |z|, z < 0 (octahedral mapping of the half sphere);
//           each less the pixel to its left, modulo 2^8; all u, then all v

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
