#pragma once

#include <string>

#include "lsmvs/evaluation/mesh_renderer.h"
#include "lsmvs/program/command_context.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

struct MeshPictureOptions {
  std::string input_path;   // mesh (PLY, with or without texture)
  std::string output_path;  // PNG; replaced if it is there
  // Workspace with the poses of the photos; without it the mesh stands on a turntable.
  std::string workspace_path;
  std::string view_name;  // photo whose pose is taken; empty: the one with most sparse points
  bool turntable = false;
  double azimuth = 0, elevation = 20;  // of the turntable [degrees]
  std::string up;                      // axis of the turntable as x,y,z; empty: up in the photos
  // Share of the vertices that the turntable's picture must hold.
  double fit_share = 0.98;
  int num_frames = 1;              // of a full turn; above 1: OUTPUT-000.png, ...
  int width = 1280, height = 960;  // pixels; the height of a photo's pose follows from its camera
  // Folder of the scratch file of a mesh that does not fit into memory; empty: the system's for
  // temporary files.
  std::string scratch_path;
  RenderOptions render;

  void Describe(OptionSet* options);
};

// Draws a mesh from the pose of a photo or on a turntable. Throws UsageError, InputError for input
// that is no mesh, Error(kOverwrite) if the picture would replace an input.
void DrawMesh(const MeshPictureOptions& options, const CommandContext& context);

}  // namespace lsmvs
