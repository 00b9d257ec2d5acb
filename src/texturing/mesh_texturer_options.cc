#include <fmt/format.h>

#include <sstream>

#include "lsmvs/texturing/mesh_texturer.h"
#include "lsmvs/texturing/unseen/unseen_color.h"

namespace lsmvs {

void MeshTexturerOptions::Describe(OptionSet* options) {
  const auto name = [](const char* field) { return std::string("MeshTextureMapping.") + field; };
  options->Add(name("texture_scale_factor"), &texture_scale_factor,
               "Texels per pixel of the photos; at 1 texels are copied pixels, less gives smaller "
               "pages.",
               {0.01, 4.0});
  options->Add(
      name("texel_size"), &texel_size,
      "Smallest width of a texel on the surface, in the unit of the sparse model; caps the "
      "density where photos are very close. 0: no cap.",
      {0.0, 1e30});
  options->Add(name("max_face_width"), &max_face_width,
               "Faces wider than this in a photo [px] are split, so that each part may take the "
               "photo that sees it; the surface stays the same. 0: none.",
               {0.0, 1e6});
  options->Add(name("max_page_size"), &max_page_size,
               "Largest side of a page in texels; more pages are made as needed.", {256, 8192});
  options->Add(name("atlas_patch_padding"), &atlas_patch_padding,
               "Texels around each chart; less packs tighter, more survives coarser mip levels.",
               {1, 64});
  options->Add(name("max_num_views"), &max_num_views,
               "Number of best photos looked at per face; each takes 12 bytes per face.", {1, 64});
  options->Add(
      name("seam_cost"), &seam_cost,
      "Cost of a seam per pixel; raising it gives fewer and larger charts, from less good photos.",
      {0.0, 1000.0});
  options->Add(name("apply_color_correction"), &apply_color_correction,
               "Balance the exposure of the photos and level the colours at seams.");
  options->Add(
      name("reject_ghosts"), &reject_ghosts,
      "Leave a photo out where it shows something that the others do not: people who walked by.");
  options->Add(name("fade_width"), &fade_width,
               "Width [px] on each side of a seam over which two photos are mixed; 0: off.",
               {0.0, 256.0});
  options->AddEnum(
      name("unseen"), &unseen,
      "Faces that no photo shows: fill them with colours from around, drop them, or "
      "give them one color.",
      {{"fill", UnseenFaces::kFill}, {"drop", UnseenFaces::kDrop}, {"color", UnseenFaces::kColor}});
  options->Add(name("unseen_color"), &unseen_color,
               "Red, green and blue for --MeshTextureMapping.unseen color, as r,g,b in 0 .. 255.");
}

bool MeshTexturerOptions::Check(std::string* error) const {
  if (!CheckOptions(*this, error)) return false;
  if (ParseUnseenColor(unseen_color)) return true;
  *error = fmt::format(
      "MeshTextureMapping.unseen_color is '{}', but must be three numbers in 0 .. 255 such as "
      "128,128,128",
      unseen_color);
  return false;
}

}  // namespace lsmvs
