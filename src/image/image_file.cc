#include "lsmvs/image/image_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <vector>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr const char* kRemedy = "copy the image again or remove it from the model";
// Where the end of the image is looked for before the whole file is: some cameras append data to a
// JPEG.
constexpr std::streamoff kTailBytes = 1 << 16;
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kEndOfPng = "IEND";
constexpr std::string_view kStartOfJpeg = "\xff\xd8";
constexpr std::string_view kEndOfJpeg = "\xff\xd9";

class Inspector {
 public:
  explicit Inspector(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    if (!file_) throw InputError(path, "cannot be opened", "check that it exists and is readable");
    file_.seekg(0, std::ios::end);
    size_ = file_.tellg();
  }

  std::optional<Eigen::Vector2i> Run() {
    const std::string signature = BytesAt(0, kPngSignature.size());
    if (signature == kPngSignature) return Png();
    if (signature.starts_with(kStartOfJpeg)) return Jpeg();
    return std::nullopt;
  }

 private:
  [[noreturn]] void FailCutOff() const { throw InputError(path_, "is cut off", kRemedy); }

  // Fewer bytes at the end of the file.
  std::string BytesAt(std::streamoff position, size_t count) {
    std::string bytes(count, '\0');
    file_.clear();
    file_.seekg(position);
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    bytes.resize(static_cast<size_t>(std::max<std::streamsize>(0, file_.gcount())));
    return bytes;
  }

  // `count` bytes as one big-endian number.
  int NumberAt(std::streamoff position, size_t count) {
    const std::string bytes = BytesAt(position, count);
    if (bytes.size() < count) FailCutOff();
    uint32_t number = 0;
    for (const char byte : bytes) number = (number << 8) | static_cast<unsigned char>(byte);
    return static_cast<int>(number);
  }

  bool ContainsFrom(std::streamoff position, std::string_view text) {
    const auto count = static_cast<size_t>(std::max<std::streamoff>(0, size_ - position));
    return BytesAt(position, count).find(text) != std::string::npos;
  }

  Eigen::Vector2i Png() {
    const Eigen::Vector2i size(NumberAt(16, 4), NumberAt(20, 4));
    const std::streamoff tail = std::max<std::streamoff>(24, size_ - kTailBytes);
    if (!ContainsFrom(tail, kEndOfPng) && !ContainsFrom(24, kEndOfPng)) FailCutOff();
    return size;
  }

  // Walks over the segments (marker, length, content) up to the start of the pixels.
  std::optional<Eigen::Vector2i> Jpeg() {
    std::optional<Eigen::Vector2i> size;
    std::streamoff position = 2;
    while (true) {
      const int marker = NumberAt(position, 2);
      if (marker == 0xffff) {  // padding
        ++position;
        continue;
      }
      if ((marker & 0xff00) != 0xff00) return std::nullopt;
      const int length = NumberAt(position + 2, 2);
      const bool is_frame = marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 &&
                            marker != 0xffc8 && marker != 0xffcc;
      if (is_frame) size = Eigen::Vector2i(NumberAt(position + 7, 2), NumberAt(position + 5, 2));
      position += 2 + std::max(2, length);
      if (marker == 0xffda) break;
    }
    // In the pixels a byte ff is always followed by 00 or a restart marker.
    const std::streamoff tail = std::max(position, size_ - kTailBytes);
    if (!ContainsFrom(tail, kEndOfJpeg) && !ContainsFrom(position, kEndOfJpeg)) FailCutOff();
    return size;
  }

  const std::string& path_;
  std::ifstream file_;
  std::streamoff size_ = 0;
};

}  // namespace

std::optional<Eigen::Vector2i> InspectImageFile(const std::string& path) {
  return Inspector(path).Run();
}

}  // namespace lsmvs
