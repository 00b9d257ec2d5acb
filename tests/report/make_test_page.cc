// Writes the page that tests/report/web/page_test.mjs looks at: make_test_page OUTPUT.html [FACES]
// Four wavy squares of known colours before a ring of cameras whose photos are magenta.
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/report/report.h"
#include "lsmvs/util/atomic_file.h"

namespace {

using namespace lsmvs;

TriangleMesh WavySquare(int n, double height, const Color& color) {
  TriangleMesh mesh;
  for (int row = 0; row <= n; ++row) {
    for (int column = 0; column <= n; ++column) {
      const double x = 2.0 * column / n - 1, y = 2.0 * row / n - 1;
      mesh.vertices.emplace_back(x, y, height * std::sin(9 * x) * std::cos(7 * y));
      mesh.vertex_colors.push_back(color);
    }
  }
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const int a = row * (n + 1) + column, c = a + n + 1;
      mesh.faces.emplace_back(a, a + 1, c + 1);
      mesh.faces.emplace_back(a, c + 1, c);
    }
  }
  return mesh;
}

// A camera at `center` that looks at the origin, y up in the world.
PosedCamera LookingAtOrigin(const Eigen::Vector3d& center) {
  PosedCamera viewpoint;
  viewpoint.camera = {640, 480, 700, 700, 330, 236};
  const Eigen::Vector3d forward = -center.normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitY()).normalized();
  Eigen::Matrix3d rotation;
  rotation.row(0) = right;
  rotation.row(1) = forward.cross(right);
  rotation.row(2) = forward;
  viewpoint.cam_from_world = Rigid3(rotation, -rotation * center);
  return viewpoint;
}

ReportMesh MakeMesh(const char* title, int n, double height, const Color& color, float error) {
  ReportMesh mesh;
  mesh.title = title;
  mesh.file = std::string(title) + ".ply";
  mesh.origin = "test";
  mesh.shown = WavySquare(n, height, color);
  mesh.errors.assign(mesh.shown.vertices.size(), error);
  mesh.figures.name = mesh.file;
  mesh.figures.inspection = Inspect(mesh.shown);
  mesh.figures.photometric = PhotometricScore{};
  mesh.figures.photometric->score = 0.9 - error / 10;
  mesh.seconds = 10 + 100 * error;
  mesh.peak_bytes = uint64_t{1} << 29;
  return mesh;
}

// Takes 3 x 3 squares out of a square of n x n, near a corner.
void CutHole(int n, TriangleMesh* mesh) {
  FilterFaces(mesh, [n](size_t f) {
    const int row = static_cast<int>(f / 2) / n, column = static_cast<int>(f / 2) % n;
    return std::abs(row - n / 8) > 1 || std::abs(column - n / 8) > 1;
  });
}

// A page whose left half is green and whose right half is white; the mesh shows the left half, but
// for the faces with x > 0.6 and y > 0.6, which are white.
void PutTexture(ReportMesh* mesh) {
  ColorImage page(64, 32, Color(255, 255, 255));
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 32; ++column) page(column, row) = Color(30, 200, 30);
  }
  mesh->texture_size = {64, 32};
  mesh->texture_jpeg = EncodeJpeg(page, 95);
  for (const Eigen::Vector3i& face : mesh->shown.faces) {
    const Eigen::Vector3d& x = mesh->shown.vertices[face[0]];
    const float left = x.x() > 0.6 && x.y() > 0.6 ? 40.0f : 8.0f;
    mesh->texcoords.push_back(
        {Eigen::Vector2f(left, 8), Eigen::Vector2f(left + 8, 8), Eigen::Vector2f(left, 16)});
  }
  mesh->shown.vertex_colors.clear();
}

DepthErrors SomeDepthErrors(size_t good) {
  DepthErrors errors;
  errors.all.bins = {good, 20, 10, 5, 5, 2, 2, 1, 1, 1};
  errors.all.num_missing = 120 - good;
  return errors;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const int faces = argc > 2 ? std::atoi(argv[2]) : 200000;
  const int n = static_cast<int>(std::lround(std::sqrt(faces / 2.0)));
  Report report;
  report.title = "Test <page> & \"quotes\"";
  report.workspace = "/some/where";
  report.program = "lsmvs test";
  report.up = {0, 1, 0};
  report.radius = 1.5;
  report.error_caption = "Distance to the ground truth|0|4 GSD";
  report.meshes.push_back(MakeMesh("red", n, 0.02, Color(220, 30, 30), 0.0f));
  report.meshes.push_back(MakeMesh("green", n, 0.04, Color(30, 200, 30), 0.4f));
  report.meshes.push_back(MakeMesh("blue", n, 0.06, Color(40, 60, 230), 1.0f));
  report.meshes.push_back(MakeMesh("yellow", n, 0.03, Color(230, 220, 30), 0.7f));
  CutHole(n, &report.meshes[0].shown);
  PutTexture(&report.meshes[1]);
  for (ReportMesh& mesh : report.meshes) {
    mesh.figures.silhouettes = SilhouetteFigures{6, 0.8, 0.001, 0.002, 0.03, 4.2};
  }
  report.meshes[0].figures.inspection->num_faces = 10'000'000;  // as if it had been simplified
  for (size_t i = 0; i < 4; ++i) {
    report.meshes[i].figures.depth_errors = SomeDepthErrors(100 - 20 * i);
  }
  for (int i = 0; i < 6; ++i) {
    const double angle = (i - 2) * std::numbers::pi / 14;
    ReportPhoto photo;
    photo.name = "photo" + std::to_string(i) + ".jpg";
    photo.viewpoint = LookingAtOrigin({4 * std::sin(angle), 0.3, 4 * std::cos(angle)});
    if (i != 5) photo.jpeg = EncodeJpeg(ColorImage(64, 48, Color(255, 0, 255)), 90);
    report.photos.push_back(photo);
  }
  report.key_photo = 2;
  report.missing.emplace_back("COLMAP Delaunay", "needs CGAL </script><script>alert(1)</script>");
  report.stages.push_back({"patch_match_stereo", 100, uint64_t{1} << 30});
  report.options.emplace_back("VisibilityMesher.sigma", "1");
  report.notes.push_back("A note.");
  WriteFileAtomically(argv[1], MakeReportPage(report));
  return 0;
}
