#include "fuzz_input.h"
#include "lsmvs/mesh/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("mesh.ply", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] { ReadMeshPly(path); });
  return 0;
}
