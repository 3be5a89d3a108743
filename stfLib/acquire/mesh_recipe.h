// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_triangles.h"
#include "stfLib/base/error.h"
#include "stfLib/optics/material.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace stf {

/// A material by name (of a PropertyTable), or written out where it is used.
struct MaterialChoice {
    std::string name;
    std::optional<Material> given;
    bool empty() const { return name.empty() && !given; }
};

/// Where triangles come from: a file, or a shape that is made (docs/acquire_mesh.md).
struct MeshSource {
    std::string file, part; ///< `part`: only what the file names so; empty: everything
    enum class Shape { None, Sphere, Box, Cylinder, Pebble, Layer } shape = Shape::None;
    double roughness = 0.2;    ///< of a pebble: height of its bumps, in radii
    Vec2d depthMm{0, 1};       ///< of a layer: from, to
    double waveMm = 0;         ///< of a layer: height of its waves above and below
    int cells = 4;             ///< of a layer: waves along the tile
    std::uint64_t seed = 0;    ///< of pebble and layer
    std::string label() const; ///< for messages
};

/// How a mesh stands in the tile: x and y along its sides, z outward, z = 0 its top; mm, degrees. Applied in this
/// order: scale, rotate about x, y, z, fit, translate.
struct MeshPlacement {
    double fit =
        0; ///< share of the tile that it fills along the axis that allows the least, in the middle; 0: as it is
    Vec3d scale{1, 1, 1}, rotateDegrees{0, 0, 0}, translateMm{0, 0, 0};
};

/// Copies at random places.
struct MeshScatter {
    enum class Turn { None, Vertical, Any };
    int count = 0;       ///< 0: by `fraction`
    double fraction = 0; ///< sum of the copies' volumes over that of the tile
    std::uint64_t seed = 0;
    Vec2d scale{1, 1}; ///< from, to
    Turn turn = Turn::Any;
    std::optional<Vec2d> depthMm; ///< of the copies' middles: from, to; nothing: the whole tile
    bool apart = false;           ///< bounding spheres do not overlap
    double gapMm = 0;             ///< between them
};

struct MeshEntry {
    MeshSource source;
    MaterialChoice material; ///< empty: the names that the file's parts have
    int priority = 0;        ///< the higher wins where meshes overlap, the later one of equals
    MeshPlacement placement;
    std::optional<MeshScatter> scatter;
    bool body = false;    ///< with Top::Geometry: the matrix is inside this mesh
    bool surface = false; ///< of a void: light refracts at it
};

/// Everything `stf acquire mesh` does, docs/acquire_mesh.md.
struct MeshRecipe {
    enum class Top { Flat, Relief, Geometry };
    std::string name;
    Vec3i size{0, 0, 0};
    Vec3d voxelMm{0, 0, 0};
    MaterialChoice matrix, core; ///< no core: the matrix
    Top top = Top::Flat;
    MeshSource relief; ///< of Top::Relief
    MeshPlacement reliefPlacement;
    std::string materials; ///< path of a table of materials; empty: the built-in ones
    std::vector<MeshEntry> meshes;

    Vec3d extentMm() const { return {size.x * voxelMm.x, size.y * voxelMm.y, size.z * voxelMm.z}; }
};

/// Reads a recipe from JSON text. `origin` names it in messages, `folder` is what its paths are relative to. Throws
/// Error with the place in the recipe: not JSON, unknown or missing keys, values of another kind or out of range.
MeshRecipe parseMeshRecipe(const std::string& text, const std::string& origin, const std::string& folder);

/// The JSON text of one mesh of a recipe from words of a command line: "FILE,material=NAME,priority=2,scale=1:1:2,fit,
/// scatter.count=20". Throws Error for a word that is neither.
std::string meshWords(const std::string& words);

} // namespace stf
