"""What the interoperability tests ask of the current COLMAP (pycolmap).

  describe MODEL             one line an image, in COLMAP's order of registered images: id name cx cy cz, then a line
                             "points N mean_track_length"
  convert MODEL OUT bin|txt  reads a model and writes it again
  rigs OUT_BIN OUT_TXT       makes a model of two rigs with two cameras each and writes it twice
  fuse WORKSPACE OUT_PLY     stereo_fusion on geometric maps
  mesh FUSED_PLY OUT_PLY     poisson_meshing
"""

import os
import sys

import pycolmap


def describe(model):
    reconstruction = pycolmap.Reconstruction(model)
    for image_id in reconstruction.reg_image_ids():
        image = reconstruction.image(image_id)
        center = image.projection_center()
        print(image_id, image.name, *(f"{x:.17g}" for x in center))
    print("points", reconstruction.num_points3D(), f"{reconstruction.compute_mean_track_length():.17g}")


def write(reconstruction, folder, kind):
    os.makedirs(folder, exist_ok=True)
    (reconstruction.write_binary if kind == "bin" else reconstruction.write_text)(folder)


def convert(model, out, kind):
    write(pycolmap.Reconstruction(model), out, kind)


def rigs(out_bin, out_txt):
    options = pycolmap.SyntheticDatasetOptions()
    options.num_rigs = 2
    options.num_cameras_per_rig = 2
    options.num_frames_per_rig = 3
    options.num_points3D = 50
    pycolmap.set_random_seed(0)
    reconstruction = pycolmap.synthesize_dataset(options)
    write(reconstruction, out_bin, "bin")
    write(reconstruction, out_txt, "txt")


def fuse(workspace, out_ply):
    options = pycolmap.StereoFusionOptions()
    options.min_num_pixels = 3
    options.num_threads = 1
    pycolmap.stereo_fusion(out_ply, workspace, input_type="geometric", options=options, output_type="PLY")


def mesh(fused_ply, out_ply):
    options = pycolmap.PoissonMeshingOptions()
    options.depth = 5
    options.num_threads = 1
    options.trim = 0
    pycolmap.poisson_meshing(fused_ply, out_ply, options)


if __name__ == "__main__":
    {f.__name__: f for f in (describe, convert, rigs, fuse, mesh)}[sys.argv[1]](*sys.argv[2:])
