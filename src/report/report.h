#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lsmvs/evaluation/evaluation_text.h"
#include "lsmvs/evaluation/mesh_renderer.h"
#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// A photo that the page can jump to.
struct ReportPhoto {
  std::string name;
  PosedCamera viewpoint;  // of the full-size photo
  std::vector<uint8_t>
      jpeg;  // the photo at any size; empty: the page has its pose but not its picture
};

// A mesh of the comparison.
struct ReportMesh {
  std::string title;    // "lsmvs refined"
  std::string file;     // name of its file
  std::string origin;   // who made it, in a few words
  std::string picture;  // file name of its PNG beside the page; empty: none
  // What is drawn: simplified if the mesh is large, with vertex colours if it has any.
  TriangleMesh shown;
  // Texture of `shown`, or empty: coordinates of each face's corners in pixels, and the page.
  std::vector<std::array<Eigen::Vector2f, 3>> texcoords;
  Eigen::Vector2i texture_size = Eigen::Vector2i::Zero();
  std::vector<uint8_t> texture_jpeg;
  // Of `shown`: 0 right, 1 wrong, NaN unknown; empty: no errors are known. The page colours by it.
  std::vector<float> errors;
  MeshFigures figures;  // of the full mesh
  uint64_t file_bytes = 0;
  std::optional<double> seconds;       // that making it took, with what only it needs
  std::optional<uint64_t> peak_bytes;  // while it was made
};

// A cloud of the comparison: figures alone, nothing is drawn.
struct ReportCloud {
  std::string title, file, origin;  // as of a mesh
  MeshFigures figures;
  uint64_t file_bytes = 0;
};

// A step of a run.
struct ReportStage {
  std::string name;
  double seconds = 0;
  std::optional<uint64_t> peak_bytes;
};

// What the page shows.
struct Report {
  std::string title;
  std::string workspace;
  std::string program;  // name and version
  Eigen::Vector3d up = Eigen::Vector3d(0, -1, 0);
  Eigen::Vector3d focus = Eigen::Vector3d::Zero();  // what the camera turns about
  double radius = 1;                                // of what is worth seeing, about the focus
  int key_photo = -1;  // the page opens at its pose; -1: a view of everything
  std::vector<ReportPhoto> photos;
  std::vector<ReportMesh> meshes;  // at least one
  std::vector<ReportCloud> clouds;
  // Meshes that are not there, and why.
  std::vector<std::pair<std::string, std::string>> missing;
  std::vector<ReportStage> stages;
  std::vector<std::pair<std::string, std::string>> options;  // name and value
  std::string error_caption;                                 // what `errors` means, with units
  std::vector<std::string> notes;
};

// The page: one HTML file that loads nothing else and runs from disk. Its size is about 8 bytes a
// face and vertex that is shown, and the photos. Throws Error if this build has no page (see
// HasReportPage).
std::string MakeReportPage(const Report& report);

// Whether the page was built into this program; it is left out where npm was not to be used.
bool HasReportPage();

// The figures alone, for scripts. Stable keys.
std::string MakeReportJson(const Report& report);

}  // namespace lsmvs
