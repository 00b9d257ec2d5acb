#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "lsmvs/image/image_store.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/textured_mesh.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/cost_estimate.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/phase_timer.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// What becomes of faces that no photo shows.
enum class UnseenFaces {
  kFill,   // colours that spread from the seen faces around
  kDrop,   // they are left out of the mesh
  kColor,  // one colour
};

struct MeshTexturerOptions {
  // Texels per pixel of the photo that a part of the surface is taken from. At 1 texels are copied
  // pixels; less takes smaller pages and averages pixels.
  double texture_scale_factor = 1.0;
  // Smallest width of a texel on the surface, world units; caps the density where photos are closer
  // than anyone needs. 0: no cap.
  double texel_size = 0.0;
  // Faces wider than this in a photo are split, so that each part may take the photo that sees it
  // [px]. 0: none.
  double max_face_width = 16.0;
  // Largest side of a page [texels]; more pages are made as needed. 8192 is what common graphics
  // cards and browsers load.
  int max_page_size = 4096;
  // Texels between a chart and the border of its rectangle: half of the distance of two charts.
  int atlas_patch_padding = 2;
  // Best photos of a face that are looked at. More cost memory (12 bytes each) and help little.
  int max_num_views = 12;
  // Price of a pixel of seam against a pixel of surface that takes a photo of no quality. More
  // gives fewer and larger charts from less good photos.
  double seam_cost = 3.0;
  // Exposure gains and levelling of seams. Without it texels keep the colours of the photos.
  bool apply_color_correction = true;
  // Whether photos that contradict the others at a place are left out there.
  bool reject_ghosts = true;
  // Width over which photos are mixed on each side of a seam, pixels. 0: not.
  double fade_width = 8.0;
  UnseenFaces unseen = UnseenFaces::kFill;
  // Red, green and blue of UnseenFaces::kColor, as "r,g,b" in 0 .. 255.
  std::string unseen_color = "128,128,128";

  void Describe(OptionSet* options);
  // Also checks unseen_color.
  bool Check(std::string* error) const;
};

struct TexturingResult {
  TexturedMesh textured;
  size_t num_faces_unseen = 0;  // of the input
  double unseen_area_share = 0;
  size_t num_charts = 0;
  double utilisation = 0;  // texels in faces / texels of all pages
  size_t num_ghosts = 0;   // candidates left out, of all faces
  bool gains_used = false;
  PhaseSeconds seconds;
};

// Takes a page (in order of its number, from 0) and returns where it lies now.
using PageSink = std::function<std::filesystem::path(int page_idx, ColorImage&& page)>;

// Textures a mesh with the photos: one photo per face by a graph cut, with exposure balanced, what
// contradicts other photos left out, and seams levelled and faded. Pages are baked one by one, each
// handed to `write_page` and forgotten.
//   M. Waechter, N. Moehrle, M. Goesele: Let there be color! Large-scale texturing of 3D
//   reconstructions, ECCV 2014.
// The surface stays as it is, but for what kDrop leaves out: wide faces are split, the others and
// all vertices are kept. Vertex colours are dropped. Every face has texture coordinates. Same bytes
// for any number of threads and any budget of memory. Memory: about 300 bytes per face, one page (8
// bytes per texel), one photo with its depth map per thread (12 bytes per pixel); what the image
// store holds comes on top. Throws InputError if no photo shows any face, UsageError for options
// out of range, CancelledError. `mesh_name` is for messages.
TexturingResult TextureMesh(const Scene& scene, const ImageStore& images, TriangleMesh mesh,
                            const std::string& mesh_name, const MeshTexturerOptions& options,
                            const PageSink& write_page, const RunContext& context);

// For a mesh of so many faces, from the number of photos and their sizes.
CostEstimate EstimateTexturingCost(const ImageStore& images, size_t num_faces,
                                   const MeshTexturerOptions& options, int num_threads);

// Texels of all pages, about: what the photos show of the surface once.
double ExpectedTexels(const ImageStore& images, double views_per_point,
                      const MeshTexturerOptions& options);

}  // namespace lsmvs
