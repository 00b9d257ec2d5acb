#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  fuzz::FuzzInput input(data, size);
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt", "rigs.txt"}) {
    fuzz::PutFile(name, input.NextPiece());
  }
  fuzz::PutFile("frames.txt", input.Rest());
  fuzz::ExpectInputErrorAtMost([&] { MakeScene(ReadSparseModel(fuzz::Folder()), "model"); });
  return 0;
}
