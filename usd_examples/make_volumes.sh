#!/bin/sh
# Writes the base volumes of the example scenes. Usage: make_volumes.sh STF FOLDER
#   STF     the command build/bin/stf
#   FOLDER  where the scenes look for them: `volumes` beside the scenes
# The build calls this for build/usd_examples. Both are made at their own default size: marble about 40 x 40 mm and 8 mm
# deep; carved wax 10 x 10 mm, with the symmetry of a square, about 5 mm deep.
set -eu
stf=$1
folder=$2
mkdir -p "$folder"
"$stf" make marble "$folder/marble.vdb"
"$stf" make wax "$folder/wax.vdb"
