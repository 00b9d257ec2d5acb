#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace lsmvs {

// Width and height that a file's header declares. JPEG and PNG are looked at without decoding them:
// header and end. Empty for other formats and for what is none. Throws InputError if the file
// cannot be opened or was cut off: decoders fill what is missing with grey and say nothing.
std::optional<Eigen::Vector2i> InspectImageFile(const std::string& path);

}  // namespace lsmvs
