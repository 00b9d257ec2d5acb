#!/bin/sh
# Exports a painted mesh and opens it in other programs: run.sh NPM NODE CHROMIUM LSMVS MAKE_TEXTURED_MESH BUILD_FOLDER
set -e
here=$(cd "$(dirname "$0")" && pwd)
npm=$1 node=$2 chromium=$3 lsmvs=$4 maker=$5 folder=$6
mkdir -p "$folder"
if ! cmp -s "$here/package-lock.json" "$folder/package-lock.json" || [ ! -d "$folder/node_modules/cesium" ]; then
  cp "$here/package.json" "$folder"
  (cd "$folder" && cp "$here/package-lock.json" . && "$npm" ci --ignore-scripts --no-audit --no-fund --loglevel=error)
fi
rm -rf "$folder/data"
"$maker" "$folder/data" 0.06 2048 10
for name in mesh colored; do
  "$lsmvs" mesh_exporter --input_path "$folder/data/$name.ply" --output_path "$folder/data/out/$name.ply" --output_type PLY
  "$lsmvs" mesh_exporter --input_path "$folder/data/$name.ply" --output_path "$folder/data/obj/$name.obj" --output_type OBJ
  "$lsmvs" mesh_exporter --input_path "$folder/data/$name.ply" --output_path "$folder/data/out/$name.glb" --output_type GLB
  "$lsmvs" mesh_exporter --input_path "$folder/data/$name.ply" --output_path "$folder/data/out/${name}_compressed.glb" --output_type GLB --compress
  "$lsmvs" mesh_exporter --input_path "$folder/data/$name.ply" --output_path "$folder/data/tiles_$name" --output_type 3DTILES \
    --texture_format png --Tileset.max_tile_faces 600
done
exec "$node" "$here/export_test.mjs" "$chromium" "$folder"
