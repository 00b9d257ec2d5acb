#include "lsmvs/mesh/texture_pages.h"

#include <algorithm>
#include <cmath>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

size_t BytesOf(const ColorImage& image) { return image.size() * sizeof(Color); }

}  // namespace

TexturePages::TexturePages(const TexturedMesh& textured, size_t budget_bytes)
    : textured_(textured), budget_bytes_(budget_bytes), entries_(textured.pages.size()) {}

std::shared_ptr<const ColorImage> TexturePages::Page(size_t page) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return Hold(page);
}

Eigen::Vector2i TexturePages::PageSize(size_t page) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (entries_[page].size.x() == 0) Hold(page);
  return entries_[page].size;
}

void TexturePages::CopyBlock(size_t page, const Eigen::Vector2i& corner,
                             const Eigen::Vector2i& size, const Eigen::Vector2i& target,
                             ColorImage* out) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Entry& entry = entries_[page];
  if (!entry.image && !entry.offset) Hold(page);
  const auto width = static_cast<size_t>(size.x());
  for (int row = 0; row < size.y(); ++row) {
    Color* to = out->Row(target.y() + row) + target.x();
    const int y = corner.y() + row;
    if (entry.image) {
      std::copy_n(entry.image->Row(y) + corner.x(), width, to);
    } else {
      const auto index = static_cast<uint64_t>(y) * static_cast<uint64_t>(entry.size.x()) +
                         static_cast<uint64_t>(corner.x());
      file_->Read(*entry.offset + index * sizeof(Color), to, width * sizeof(Color));
    }
  }
}

std::shared_ptr<const ColorImage> TexturePages::Hold(size_t page) const {
  Entry& entry = entries_[page];
  if (!entry.image) {
    entry.image = std::make_shared<const ColorImage>(Load(entry, page));
    entry.size = {entry.image->width, entry.image->height};
    held_bytes_ += BytesOf(*entry.image);
    Evict(page);
  }
  entry.last_use = ++clock_;
  return entry.image;
}

ColorImage TexturePages::Load(const Entry& entry, size_t page) const {
  if (!entry.offset) {
    ++num_decoded_;
    return ReadColors(textured_.pages[page]);
  }
  ColorImage image(entry.size.x(), entry.size.y());
  file_->Read(*entry.offset, image.pixels.data(), BytesOf(image));
  return image;
}

void TexturePages::Evict(size_t kept) const {
  while (held_bytes_ > budget_bytes_) {
    Entry* oldest = nullptr;
    for (size_t p = 0; p < entries_.size(); ++p) {
      if (p == kept || !entries_[p].image) continue;
      if (oldest == nullptr || entries_[p].last_use < oldest->last_use) oldest = &entries_[p];
    }
    if (oldest == nullptr) return;
    PutAside(oldest);
    held_bytes_ -= BytesOf(*oldest->image);
    oldest->image.reset();
  }
}

void TexturePages::PutAside(Entry* entry) const {
  if (entry->offset || has_no_room_) return;
  try {
    if (!file_) file_ = std::make_unique<UnnamedFile>(FolderForTemporaryFiles());
    file_->Write(file_end_, entry->image->pixels.data(), BytesOf(*entry->image));
  } catch (const FileSystemError&) {
    has_no_room_ = true;
    return;
  }
  entry->offset = file_end_;
  file_end_ += BytesOf(*entry->image);
}

Eigen::Vector2f TexturePages::FilePixel(size_t face, const Eigen::Vector2f& barycentric,
                                        const ColorImage& page) const {
  const std::array<Eigen::Vector2f, 3>& corners = textured_.texcoords[face];
  const Eigen::Vector2f x = corners[0] + barycentric[0] * (corners[1] - corners[0]) +
                            barycentric[1] * (corners[2] - corners[0]);
  const Eigen::Vector2f stretch(
      static_cast<float>(page.width) / static_cast<float>(textured_.page_width),
      static_cast<float>(page.height) / static_cast<float>(textured_.page_height));
  return x.cwiseProduct(stretch);
}

Eigen::Vector3f TexturePages::Sample(size_t face, const Eigen::Vector2f& barycentric) const {
  const std::shared_ptr<const ColorImage> page = Page(textured_.page_idx[face]);
  return SampleColor(*page, FilePixel(face, barycentric, *page));
}

Eigen::Vector3f SampleColor(const ColorImage& image, const Eigen::Vector2f& x_px) {
  const float x = std::clamp(x_px.x() - 0.5f, 0.0f, static_cast<float>(image.width - 1));
  const float y = std::clamp(x_px.y() - 0.5f, 0.0f, static_cast<float>(image.height - 1));
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, image.width - 1);
  const int bottom = std::min(top + 1, image.height - 1);
  const float a = x - static_cast<float>(left), b = y - static_cast<float>(top);
  const auto at = [&](int column, int row) -> Eigen::Vector3f {
    return image(column, row).cast<float>();
  };
  return (1 - b) * ((1 - a) * at(left, top) + a * at(right, top)) +
         b * ((1 - a) * at(left, bottom) + a * at(right, bottom));
}

}  // namespace lsmvs
