#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace lsmvs {

// What an image file's header declares.
struct ImageFileInfo {
  Eigen::Vector2i size = Eigen::Vector2i::Zero();  // width, height
  int bits_per_channel = 8;
  bool has_alpha = false;
};

// JPEG, PNG and TIFF are looked at without decoding them: header and, where the format tells, the
// end. Empty for other formats (also BigTIFF) and for what is none. Throws InputError if the file
// cannot be opened or was cut off: decoders fill what is missing with grey and say nothing.
std::optional<ImageFileInfo> InspectImageFile(const std::string& path);

}  // namespace lsmvs
