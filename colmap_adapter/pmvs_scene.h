#pragma once

#include <filesystem>

#include "lsmvs/scene/scene.h"

namespace lsmvs {

// Number of photos of a folder that `colmap image_undistorter --output_type PMVS` prepared: its
// projection matrices txt/00000000.txt, 00000001.txt, ... Throws InputError if there are none or
// one of the row is missing.
int CountPmvsPhotos(const std::filesystem::path& folder);

// The scene of such a folder: cameras from txt/, photos visualize/00000000.jpg and so on, which are
// the views' names, and sparse points with their views from bundle.rd.out if it is there. The world
// is that of the sparse model. Pixels are counted as COLMAP writes the matrices: the centre of the
// top-left pixel is (0.5, 0.5).
//
// Throws InputError if a file is missing, cut off or malformed, if a matrix is none of a camera
// with square corners, or if bundle.rd.out is about another number of photos.
Scene LoadPmvsScene(const std::filesystem::path& folder);

}  // namespace lsmvs
