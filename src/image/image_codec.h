#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/image/raster.h"

namespace lsmvs {

// Encodes as PNG, 8 bits per channel, without loss.
std::vector<uint8_t> EncodePng(const ColorImage& image);
// Encodes as JPEG of `quality` in [1, 100].
std::vector<uint8_t> EncodeJpeg(const ColorImage& image, int quality);
// Encodes as WebP of `quality` in [1, 100].
std::vector<uint8_t> EncodeWebp(const ColorImage& image, int quality);
// Decodes any format that OpenCV reads. Throws InputError; `name` is for its message.
ColorImage DecodeColors(const std::vector<uint8_t>& bytes, const std::string& name);

// Writes atomically. Throws FileSystemError.
void WritePng(const std::filesystem::path& path, const ColorImage& image);
void WriteJpeg(const std::filesystem::path& path, const ColorImage& image, int quality);
// Throws InputError if the file is missing or cannot be decoded.
ColorImage ReadColors(const std::filesystem::path& path);

// Area-averaged (when smaller) or bicubic (when larger) copy of another size.
ColorImage ResizeColors(const ColorImage& image, int width, int height);

}  // namespace lsmvs
