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
constexpr std::string_view kLittleTiff("II*\0", 4), kBigTiff("MM\0*", 4);
constexpr std::string_view kStartOfJpeg = "\xff\xd8";
constexpr std::string_view kEndOfJpeg = "\xff\xd9";

class Inspector {
 public:
  explicit Inspector(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    if (!file_) throw InputError(path, "cannot be opened", "check that it exists and is readable");
    file_.seekg(0, std::ios::end);
    size_ = file_.tellg();
  }

  std::optional<ImageFileInfo> Run() {
    const std::string signature = BytesAt(0, kPngSignature.size());
    if (signature == kPngSignature) return Png();
    if (signature.starts_with(kStartOfJpeg)) return Jpeg();
    if (signature.starts_with(kLittleTiff)) return Tiff(true);
    if (signature.starts_with(kBigTiff)) return Tiff(false);
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

  // `count` bytes, four at most, as one number; PNG and JPEG are big endian.
  int NumberAt(std::streamoff position, size_t count, bool little_endian = false) {
    std::string bytes = BytesAt(position, count);
    if (bytes.size() < count) FailCutOff();
    if (little_endian) std::reverse(bytes.begin(), bytes.end());
    uint32_t number = 0;
    for (const char byte : bytes) number = (number << 8) | static_cast<unsigned char>(byte);
    return static_cast<int>(number);
  }

  bool ContainsFrom(std::streamoff position, std::string_view text) {
    const auto count = static_cast<size_t>(std::max<std::streamoff>(0, size_ - position));
    return BytesAt(position, count).find(text) != std::string::npos;
  }

  ImageFileInfo Png() {
    ImageFileInfo info;
    info.size = {NumberAt(16, 4), NumberAt(20, 4)};
    const std::streamoff tail = std::max<std::streamoff>(24, size_ - kTailBytes);
    if (!ContainsFrom(tail, kEndOfPng) && !ContainsFrom(24, kEndOfPng)) FailCutOff();
    info.bits_per_channel = NumberAt(24, 1);
    constexpr int kAlphaBit = 4;
    info.has_alpha = (NumberAt(25, 1) & kAlphaBit) != 0 || HasTransparentPalette();
    return info;
  }

  // Whether a tRNS chunk lies between the header and the pixels.
  bool HasTransparentPalette() {
    constexpr std::streamoff kFirstChunk = 33, kChunkFrame = 12;
    for (std::streamoff position = kFirstChunk; position + kChunkFrame < size_;) {
      const std::string type = BytesAt(position + 4, 4);
      if (type == "tRNS") return true;
      if (type == "IDAT" || type == kEndOfPng) return false;
      position += kChunkFrame + static_cast<uint32_t>(NumberAt(position, 4));
    }
    return false;
  }

  // The entries of the first directory: tag, type (3: 16 bits, 4: 32 bits), count, value or its
  // position.
  std::optional<ImageFileInfo> Tiff(bool little_endian) {
    constexpr int kWidth = 256, kHeight = 257, kBitsPerSample = 258, kPhotometric = 262,
                  kSamplesPerPixel = 277, kExtraSamples = 338;
    constexpr uint32_t kRgb = 2, kUnspecified = 0;
    constexpr std::streamoff kEntryBytes = 12;
    const auto number = [&](std::streamoff position, size_t count) {
      return static_cast<uint32_t>(NumberAt(position, count, little_endian));
    };
    ImageFileInfo info;
    uint32_t photometric = 0, num_samples = 1;
    std::optional<uint32_t> extra_sample;
    const std::streamoff directory = number(4, 4);
    const int num_entries = static_cast<int>(number(directory, 2));
    for (int i = 0; i < num_entries; ++i) {
      const std::streamoff entry = directory + 2 + i * kEntryBytes;
      const int tag = static_cast<int>(number(entry, 2));
      const size_t bytes = number(entry + 2, 2) == 3 ? 2 : 4;
      const bool is_inline = number(entry + 4, 4) * bytes <= 4;
      const std::streamoff value = is_inline ? entry + 8 : number(entry + 8, 4);
      if (tag == kWidth) info.size.x() = static_cast<int>(number(value, bytes));
      if (tag == kHeight) info.size.y() = static_cast<int>(number(value, bytes));
      if (tag == kBitsPerSample) info.bits_per_channel = static_cast<int>(number(value, bytes));
      if (tag == kPhotometric) photometric = number(value, bytes);
      if (tag == kSamplesPerPixel) num_samples = number(value, bytes);
      if (tag == kExtraSamples) extra_sample = number(value, bytes);
    }
    info.has_alpha =
        extra_sample ? *extra_sample != kUnspecified : num_samples == 4 && photometric == kRgb;
    if ((info.size.array() <= 0).any()) return std::nullopt;
    return info;
  }

  // Walks over the segments (marker, length, content) up to the start of the pixels.
  std::optional<ImageFileInfo> Jpeg() {
    std::optional<ImageFileInfo> info;
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
      if (is_frame) {
        info.emplace().size = {NumberAt(position + 7, 2), NumberAt(position + 5, 2)};
        info->bits_per_channel = NumberAt(position + 4, 1);
      }
      position += 2 + std::max(2, length);
      if (marker == 0xffda) break;
    }
    // In the pixels a byte ff is always followed by 00 or a restart marker.
    const std::streamoff tail = std::max(position, size_ - kTailBytes);
    if (!ContainsFrom(tail, kEndOfJpeg) && !ContainsFrom(position, kEndOfJpeg)) FailCutOff();
    return info;
  }

  const std::string& path_;
  std::ifstream file_;
  std::streamoff size_ = 0;
};

}  // namespace

std::optional<ImageFileInfo> InspectImageFile(const std::string& path) {
  return Inspector(path).Run();
}

}  // namespace lsmvs
