// Writes a tetrahedron with the installed library, reads it back and checks it: what a user's first
// program would do.
#include <cstdio>

#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/ply.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  lsmvs::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  lsmvs::WriteMeshPly(argv[1], mesh);
  const lsmvs::MeshInspection inspection = lsmvs::Inspect(lsmvs::ReadMeshPly(argv[1]));
  std::printf("closed %d, volume %.6f\n", inspection.IsClosed(), inspection.volume);
  return inspection.IsClosed() && inspection.volume > 0.166 && inspection.volume < 0.167 ? 0 : 1;
}
