#!/bin/sh
# Writes the base volumes of the example scenes. Usage: make_volumes.sh STF FOLDER
#   STF     the command build/bin/stf
#   FOLDER  where the scenes look for them: `volumes` beside the scenes
# The build calls this for build/usd_examples. Sizes are in voxels, voxel edges in mm.
set -eu
stf=$1
folder=$2
mkdir -p "$folder"
# Marble: 40 x 40 mm, 8 mm deep.
"$stf" make marble "$folder/marble.vdb" --size 160,160,32 --voxel 0.25 --seed 1
# Carved wax: 10 x 10 mm with the symmetry of a square, 4 mm deep.
"$stf" make wax "$folder/wax.vdb" --size 80,80,32 --voxel 0.125 --seed 1
