#!/bin/sh
# Writes the volumes of the scenes in `bad` that are not plain text. Usage: make_bad_volumes.sh STF FOLDER
set -eu
stf=$1
folder=$2
mkdir -p "$folder"
"$stf" make uniform "$folder/uniform.vdb" --size 1,1,8 --voxel 0.5
head -c "$(($(wc -c <"$folder/uniform.vdb") / 2))" "$folder/uniform.vdb" >"$folder/truncated.vdb"
